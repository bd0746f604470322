/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_BUNDLE_H
#define FEWRAY_GUIDE_BUNDLE_H

/* Sixteen paths that go side by side: their rays are traced as packets, and what happens at plain
 * diffuse triangles is computed for all at once. A path that meets anything else goes on alone, by
 * trace_path() or trace_incident(). The samples are those of trace_path() but for rounding. */

#include "denoise/nn/nn.h"
#include "guide/trace/integrator.h"

enum { BUNDLE_LANES = 16 };

/* One of a bundle's paths. */
struct bundle_start {
    int x, y; /* pixel */
    struct sampler sampler;
    float direction[2]; /* of a look's path: what warps to its first bounce */
    /* Where to note what the bounces saw; NULL: not wanted. All of a bundle's have a record or
     * none; always a look's. */
    struct look_record *record;
    struct look_second *second;
};

/* What one instruction set runs. */
struct bundle_tracer {
    /* Traces `count` paths, 1..BUNDLE_LANES. */
    void (*paths)(const struct integrator *in, int count, const struct bundle_start *starts,
                  struct path_sample *samples);
    /* trace_look_path() likewise. */
    void (*looks)(const struct integrator *in, int count, const struct bundle_start *starts,
                  struct path_sample *samples);
    /* trace_features() of the points (x[i], y[i]) of the picture; starts: their samplers. */
    void (*features)(const struct integrator *in, int count, const float *x, const float *y,
                     const struct bundle_start *starts, struct path_sample *samples);
};
extern const struct bundle_tracer bundle_plain, bundle_avx2, bundle_avx512;

/* The best that the CPU and the environment variable FEWRAY_ISA allow. */
const struct bundle_tracer *bundle_tracer_get(void);

#endif
