/* SPDX-License-Identifier: Apache-2.0 */
/* oneDNN's side of fewray-bench-conv (C API of version 2). */

#include <dnnl.h>
#include <omp.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "denoise/nn/bench_conv.h"

enum { SRC, WEIGHTS, BIAS, DST, MEMORIES };

struct job {
    dnnl_engine_t engine;
    dnnl_stream_t stream;
    dnnl_primitive_attr_t attributes;
    dnnl_post_ops_t post_ops;
    dnnl_primitive_desc_t description;
    dnnl_primitive_t primitive;
    dnnl_memory_t memory[MEMORIES];
    dnnl_exec_arg_t arguments[MEMORIES];
};

/* The convolution with all layouts left to oneDNN. The rows above and below the slice are input,
 * not padding, which oneDNN would skip. */
static dnnl_status_t describe(struct job *job, const struct bench_shape *s) {
    dnnl_dims_t src = {1, s->in, s->height + s->kernel - 1, s->width},
                dst = {1, s->out, s->height, s->width};
    dnnl_dims_t weights = {s->out, s->in, s->kernel, s->kernel}, bias = {s->out};
    dnnl_dims_t strides = {1, 1}, padding = {0, s->kernel / 2};
    dnnl_memory_desc_t shapes[MEMORIES];
    dnnl_convolution_desc_t conv;
    dnnl_status_t status =
        dnnl_memory_desc_init_by_tag(&shapes[SRC], 4, src, dnnl_f32, dnnl_format_tag_any);
    status |=
        dnnl_memory_desc_init_by_tag(&shapes[WEIGHTS], 4, weights, dnnl_f32, dnnl_format_tag_any);
    status |= dnnl_memory_desc_init_by_tag(&shapes[BIAS], 1, bias, dnnl_f32, dnnl_a);
    status |= dnnl_memory_desc_init_by_tag(&shapes[DST], 4, dst, dnnl_f32, dnnl_format_tag_any);
    status |= dnnl_convolution_forward_desc_init(
        &conv, dnnl_forward_inference, dnnl_convolution_direct, &shapes[SRC], &shapes[WEIGHTS],
        &shapes[BIAS], &shapes[DST], strides, padding, padding);
    status |= dnnl_post_ops_create(&job->post_ops);
    status |= dnnl_post_ops_append_eltwise(job->post_ops, 1.0f, dnnl_eltwise_relu, 0.2f, 0.0f);
    status |= dnnl_primitive_attr_create(&job->attributes);
    status |= dnnl_primitive_attr_set_post_ops(job->attributes, job->post_ops);
    if (status != dnnl_success)
        return status;
    return dnnl_primitive_desc_create(&job->description, &conv, job->attributes, job->engine, NULL);
}

static dnnl_status_t allocate(struct job *job) {
    static const dnnl_query_t queries[] = {dnnl_query_src_md, dnnl_query_weights_md,
                                           dnnl_query_weights_md, dnnl_query_dst_md};
    static const int indices[] = {0, 0, 1, 0};
    static const int names[] = {DNNL_ARG_SRC, DNNL_ARG_WEIGHTS, DNNL_ARG_BIAS, DNNL_ARG_DST};
    for (int i = 0; i < MEMORIES; ++i) {
        const dnnl_memory_desc_t *shape =
            dnnl_primitive_desc_query_md(job->description, queries[i], indices[i]);
        dnnl_status_t status =
            dnnl_memory_create(&job->memory[i], shape, job->engine, DNNL_MEMORY_ALLOCATE);
        void *data = NULL;
        if (status == dnnl_success)
            status = dnnl_memory_get_data_handle(job->memory[i], &data);
        if (status != dnnl_success)
            return status;
        size_t floats = dnnl_memory_desc_get_size(shape) / sizeof(float);
        for (size_t k = 0; k < floats; ++k)
            ((float *)data)[k] = (float)(rand() % 2001 - 1000) * 1e-3f;
        job->arguments[i] = (dnnl_exec_arg_t){names[i], job->memory[i]};
    }
    return dnnl_success;
}

static void limit_isa(enum nn_isa isa) {
    static const dnnl_cpu_isa_t names[] = {
        [NN_ISA_AUTO] = dnnl_cpu_isa_all,
        [NN_ISA_PLAIN] = dnnl_cpu_isa_sse41,
        [NN_ISA_AVX2] = dnnl_cpu_isa_avx2,
        [NN_ISA_AVX512] = dnnl_cpu_isa_avx512_core,
    };
    dnnl_set_max_cpu_isa(names[isa]); /* all calls but the first have no effect */
}

double bench_dnnl(const struct bench_shape *s, enum nn_isa isa, int threads, double seconds) {
    struct job job;
    memset(&job, 0, sizeof job);
    double best = 0.0;
    omp_set_num_threads(threads);
    limit_isa(isa);
    if (dnnl_engine_create(&job.engine, dnnl_cpu, 0) != dnnl_success ||
        dnnl_stream_create(&job.stream, job.engine, dnnl_stream_default_flags) != dnnl_success ||
        describe(&job, s) != dnnl_success || allocate(&job) != dnnl_success ||
        dnnl_primitive_create(&job.primitive, job.description) != dnnl_success)
        goto done;

    double flop = 2.0 * s->out * s->in * s->kernel * s->kernel * s->height * s->width;
    int calls = 1 + (int)(2e7 / flop);
    for (double end = bench_now() + seconds; bench_now() < end;) {
        double start = bench_now();
        for (int i = 0; i < calls; ++i)
            dnnl_primitive_execute(job.primitive, job.stream, MEMORIES, job.arguments);
        dnnl_stream_wait(job.stream);
        double rate = calls * flop / (bench_now() - start);
        best = rate > best ? rate : best;
    }

done:
    for (int i = 0; i < MEMORIES; ++i)
        dnnl_memory_destroy(job.memory[i]);
    dnnl_primitive_destroy(job.primitive);
    dnnl_primitive_desc_destroy(job.description);
    dnnl_primitive_attr_destroy(job.attributes);
    dnnl_post_ops_destroy(job.post_ops);
    dnnl_stream_destroy(job.stream);
    dnnl_engine_destroy(job.engine);
    return best;
}
