/* SPDX-License-Identifier: Apache-2.0 */
/* Any build makes nearly the pictures of the stored table, whatever compiler, optimisation or
 * sanitizer: their means over blocks are compared. To store the table anew, after a change that is
 * to change pictures:
 *
 *     stress_stable_pictures --write tests/data/stable_pictures.txt
 */

#include "tests/unit/check.h"

#include <stdio.h>
#include <string.h>

#include "picture_jobs.h"

enum { ACROSS = 4, DOWN = 3 };

/* Builds differ by rounding: kernels fuse multiplications with additions or don't, by instruction
 * set and optimisation. Now and then a path then takes another way, which changes a block of more
 * than 100 pixels by one of more than 500 samples: measured are 0.003 of a block, 0.0005 of a
 * picture. */
#define BLOCK_BOUND   0.01  /* of a block's value and a tenth of the picture's mean */
#define PICTURE_BOUND 0.002 /* of the picture's mean */

/* Mean of R, G or B over a block of 1 / ACROSS x 1 / DOWN of the picture. */
static double block_mean(const struct fewray_frame *frame, int block, int c) {
    const float *plane = fewray_frame_plane(frame, (const char *[]){"R", "G", "B"}[c]);
    const int i = block % ACROSS, j = block / ACROSS;
    double sum = 0;
    int count = 0;
    for (int y = j * frame->height / DOWN; y < (j + 1) * frame->height / DOWN; y++)
        for (int x = i * frame->width / ACROSS; x < (i + 1) * frame->width / ACROSS; x++, count++)
            sum += (double)plane[(size_t)y * (size_t)frame->width + (size_t)x];
    return sum / count;
}

/* Each picture is a line of its name, and a line of R, G, B for each block. */
static bool write_table(const char *path) {
    FILE *file = fopen(path, "w");
    if (!file)
        return false;
    fprintf(file,
            "# Means of R, G, B over %d x %d blocks, row by row; made by stress_stable_pictures "
            "--write\n",
            ACROSS, DOWN);
    for (int p = 0; p < PICTURES; p++) {
        struct fewray_frame *frame = picture_render(&pictures[p], 1, NULL);
        fprintf(file, "%s\n", pictures[p].name);
        for (int b = 0; b < ACROSS * DOWN; b++)
            fprintf(file, "  %.6g %.6g %.6g\n", block_mean(frame, b, 0), block_mean(frame, b, 1),
                    block_mean(frame, b, 2));
        fewray_frame_destroy(&frame);
    }
    return fclose(file) == 0;
}

static void read_line(FILE *file, char line[256]) {
    do
        assert_non_null(fgets(line, 256, file));
    while (line[0] == '#');
    line[strcspn(line, "\n")] = 0;
}

/* The greatest difference of a block, and that of the means. */
static void compare(const struct fewray_frame *frame, double stored[ACROSS * DOWN][3],
                    double *block, double *picture) {
    double sums[2] = {0, 0};
    for (int k = 0; k < ACROSS * DOWN * 3; k++) {
        sums[0] += stored[k / 3][k % 3];
        sums[1] += block_mean(frame, k / 3, k % 3);
    }
    *block = 0;
    *picture = fabs(sums[1] / sums[0] - 1);
    for (int k = 0; k < ACROSS * DOWN * 3; k++) {
        const double expected = stored[k / 3][k % 3];
        const double scale = expected + 0.1 * sums[0] / (ACROSS * DOWN * 3);
        *block = fmax(*block, fabs(block_mean(frame, k / 3, k % 3) - expected) / scale);
    }
}

static void test_pictures_are_those_of_the_table(void **state) {
    (void)state;
    FILE *file = fopen(TEST_DATA "/stable_pictures.txt", "r");
    assert_non_null(file);
    for (int p = 0; p < PICTURES; p++) {
        char line[256];
        double stored[ACROSS * DOWN][3], block, picture;
        read_line(file, line);
        assert_string_equal(line, pictures[p].name);
        for (int b = 0; b < ACROSS * DOWN; b++) {
            read_line(file, line);
            assert_int_equal(
                sscanf(line, "%lf %lf %lf", &stored[b][0], &stored[b][1], &stored[b][2]), 3);
        }
        struct fewray_frame *frame = picture_render(&pictures[p], 1, NULL);
        compare(frame, stored, &block, &picture);
        fewray_frame_destroy(&frame);
        if (getenv("FEWRAY_SHOW"))
            printf("%-36s block %.2e, picture %.2e\n", pictures[p].name, block, picture);
        if (!(block <= BLOCK_BOUND) || !(picture <= PICTURE_BOUND))
            fail_msg("%s: a block is %.3g off, the mean %.3g", pictures[p].name, block, picture);
    }
    fclose(file);
}

int main(int argc, char **argv) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_pictures_are_those_of_the_table)};
    if (argc == 3 && !strcmp(argv[1], "--write"))
        return write_table(argv[2]) ? 0 : 1;
    return cmocka_run_group_tests(tests, NULL, NULL);
}
