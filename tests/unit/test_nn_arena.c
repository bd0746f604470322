/* SPDX-License-Identifier: Apache-2.0 */
/* The arena's plan: live buffers never overlap, and dead ones' memory is used again. */

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "denoise/nn/nn.h"

static void assert_plan_is_valid(const struct nn_buffer *b, int count, const size_t *offsets,
                                 size_t total) {
    for (int i = 0; i < count; ++i) {
        assert_true(offsets[i] % 64 == 0);
        assert_true(offsets[i] + b[i].bytes <= total);
        for (int j = 0; j < i; ++j) {
            bool live = b[i].first <= b[j].last && b[j].first <= b[i].last;
            bool overlap =
                offsets[i] < offsets[j] + b[j].bytes && offsets[j] < offsets[i] + b[i].bytes;
            assert_false(live && overlap);
        }
    }
}

static void test_live_buffers_never_overlap(void **state) {
    (void)state;
    srand(3);
    for (int round = 0; round < 2000; ++round) {
        struct nn_buffer buffers[64];
        size_t offsets[64], sum = 0;
        int count = rand() % 65;
        for (int i = 0; i < count; ++i) {
            buffers[i].bytes = (size_t)(rand() % 10000);
            buffers[i].first = rand() % 40;
            buffers[i].last = buffers[i].first + rand() % 8;
            sum += (buffers[i].bytes + 63) & ~(size_t)63;
        }
        size_t total = nn_arena_plan(buffers, count, offsets);
        assert_plan_is_valid(buffers, count, offsets, total);
        assert_true(total <= sum);
    }
}

static void test_chain_needs_two_buffers(void **state) {
    (void)state;
    struct nn_buffer chain[10];
    size_t offsets[10];
    for (int i = 0; i < 10; ++i)
        chain[i] = (struct nn_buffer){.bytes = 1000, .first = i, .last = i + 1};
    size_t total = nn_arena_plan(chain, 10, offsets);
    assert_plan_is_valid(chain, 10, offsets, total);
    assert_true(total == 2 * 1024);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_live_buffers_never_overlap),
        cmocka_unit_test(test_chain_needs_two_buffers),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
