/* SPDX-License-Identifier: Apache-2.0 */
/* Where the denoiser sends the light of single pixels: draw_kernel NOISY.exr OUT.png X,Y [X,Y...]
 *
 * Shows what layers of one's own are good for: they are filtered by the very weights that the
 * picture is filtered by. Here such a layer is 1 at one pixel and 0 elsewhere, so that what comes
 * out are that pixel's weights in the pixels around. For each pixel two panels are drawn: the noisy
 * picture around it, and the weights, logarithmic from 1e-4 (black) to 1 (white). */

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fewray/denoise.h"

enum { RADIUS = 32, SIDE = 2 * RADIUS + 1, ZOOM = 4, PANEL = SIDE * ZOOM, GAP = 8, MAX_PIXELS = 4 };

struct drawing {
    struct fewray_frame *frame;
    float *color[3];
    int width; /* of the drawing, pixels */
    uint8_t *rgb;
};

static void put(const struct drawing *d, int panel, int dx, int dy, const uint8_t rgb[3]) {
    for (int y = 0; y < ZOOM; y++)
        for (int x = 0; x < ZOOM; x++) {
            const int to_x = panel * (PANEL + GAP) + (dx + RADIUS) * ZOOM + x;
            const int to_y = (dy + RADIUS) * ZOOM + y;
            memcpy(d->rgb + 3 * ((size_t)to_y * (size_t)d->width + (size_t)to_x), rgb, 3);
        }
}

static uint8_t encode(float linear) {
    return (uint8_t)(255 * powf(fminf(fmaxf(linear, 0), 1), 1 / 2.2f) + 0.5f);
}

/* Black, violet, red, yellow, white. */
static void heat(float weight, uint8_t rgb[3]) {
    static const float anchors[5][3] = {
        {0, 0, 0}, {80, 18, 123}, {205, 60, 60}, {252, 180, 50}, {255, 255, 230}};
    const float t = fminf(fmaxf(4 + log10f(fmaxf(weight, 1e-6f)), 0), 3.999f);
    const int k = (int)t;
    for (int c = 0; c < 3; c++)
        rgb[c] = (uint8_t)(anchors[k][c] + (t - (float)k) * (anchors[k + 1][c] - anchors[k][c]));
}

static void draw(const struct drawing *d, const float *weights, int panel, int x, int y) {
    const struct fewray_frame *f = d->frame;
    double sum = 0;
    for (int dy = -RADIUS; dy <= RADIUS; dy++)
        for (int dx = -RADIUS; dx <= RADIUS; dx++) {
            uint8_t rgb[3] = {255, 45, 85};
            if (x + dx < 0 || y + dy < 0 || x + dx >= f->width || y + dy >= f->height)
                continue;
            const size_t i = (size_t)(y + dy) * (size_t)f->width + (size_t)(x + dx);
            for (int c = 0; c < 3 && (dx || dy); c++)
                rgb[c] = encode(d->color[c][i]);
            put(d, panel, dx, dy, rgb);
            heat(weights[i], rgb);
            put(d, panel + 1, dx, dy, rgb);
            sum += (double)weights[i];
        }
    const size_t own = (size_t)y * (size_t)f->width + (size_t)x;
    printf("%d,%d: its weight in itself %.4f, sum of its weights around %.4f\n", x, y,
           (double)weights[own], sum);
}

/* What the file has of what helps the denoiser. */
static struct fewray_denoise_input find_input(const struct fewray_frame *f,
                                              const struct fewray_denoise_layer *layer) {
    struct fewray_denoise_input in = {
        .width = f->width, .height = f->height, .layers = layer, .layer_count = 1};
    const struct {
        enum fewray_layer layer;
        struct fewray_channels *to;
    } known[] = {{FEWRAY_COLOR, &in.color},
                 {FEWRAY_VARIANCE, &in.variance},
                 {FEWRAY_ALBEDO, &in.albedo},
                 {FEWRAY_SHADED_ALBEDO, &in.shaded_albedo},
                 {FEWRAY_NORMAL, &in.normal},
                 {FEWRAY_EMISSION, &in.emission},
                 {FEWRAY_DEPTH, &in.depth},
                 {FEWRAY_IRRADIANCE, &in.irradiance},
                 {FEWRAY_IRRADIANCE_CONFIDENCE, &in.confidence}};
    for (size_t k = 0; k < sizeof known / sizeof *known; k++) {
        float *planes[3] = {NULL, NULL, NULL};
        if (fewray_frame_layer(f, known[k].layer, planes))
            *known[k].to = fewray_planar(planes, f->width);
    }
    return in;
}

/* The picture denoised anew for each pixel, with an impulse there. */
static int add_panels(struct fewray_denoiser *denoiser, const struct drawing *d, int panel, int x,
                      int y, struct fewray_error *error) {
    const struct fewray_frame *f = d->frame;
    if (x < 0 || y < 0 || x >= f->width || y >= f->height)
        return fewray_fail(error, FEWRAY_ERROR_ARGUMENT, NULL, 0,
                           "%d,%d lies outside of the picture", x, y);
    const size_t count = (size_t)f->width * (size_t)f->height;
    float *floats = calloc(5 * count, sizeof *floats);
    if (!floats)
        return fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0, "no memory for a layer of weights");
    float *impulse[3] = {floats, NULL, NULL}, *weights = floats + count;
    impulse[0][(size_t)y * (size_t)f->width + (size_t)x] = 1;
    const struct fewray_denoise_layer layer = {.in = fewray_planar(impulse, f->width),
                                               .coverage = true,
                                               .out = {weights, NULL, NULL},
                                               .out_pixel_stride = 1,
                                               .out_row_stride = f->width};
    const struct fewray_denoise_input in = find_input(f, &layer);
    const int status = fewray_denoiser_run(denoiser, &in, floats + 2 * count, NULL, error);
    if (!status)
        draw(d, weights, panel, x, y);
    free(floats);
    return status;
}

static int run(const char *exr, const char *png, int count, char **pixels,
               struct fewray_error *error) {
    struct drawing d = {.width = 2 * count * (PANEL + GAP) - GAP};
    struct fewray_denoiser *denoiser = NULL;
    struct fewray_denoise_options options;
    fewray_denoise_options_init(&options);
    int status = fewray_frame_read_exr(exr, &d.frame, error);
    if (!status && !fewray_frame_layer(d.frame, FEWRAY_COLOR, d.color))
        status = fewray_fail(error, FEWRAY_ERROR_FORMAT, exr, 0, "it has no channels R, G, B");
    if (!status) {
        fewray_frame_repair(d.frame);
        status = fewray_denoiser_create(&options, &denoiser, error);
    }
    d.rgb = malloc(3 * (size_t)d.width * PANEL);
    if (!status && !d.rgb)
        status = fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0, "no memory for the drawing");
    if (!status)
        memset(d.rgb, 255, 3 * (size_t)d.width * PANEL);
    for (int k = 0; k < count && !status; k++) {
        int x, y;
        if (sscanf(pixels[k], "%d,%d", &x, &y) != 2)
            status = fewray_fail(error, FEWRAY_ERROR_ARGUMENT, NULL, 0,
                                 "%s should be X,Y in pixels", pixels[k]);
        else
            status = add_panels(denoiser, &d, 2 * k, x, y, error);
    }
    if (!status)
        status = fewray_image_write_png(png, d.width, PANEL, d.rgb, error);
    free(d.rgb);
    fewray_denoiser_destroy(&denoiser);
    fewray_frame_destroy(&d.frame);
    return status;
}

int main(int argc, char **argv) {
    if (argc < 4 || argc > 3 + MAX_PIXELS) {
        fprintf(stderr, "usage: draw_kernel NOISY.exr OUT.png X,Y [X,Y...]\n");
        return 2;
    }
    struct fewray_error error;
    if (run(argv[1], argv[2], argc - 3, argv + 3, &error)) {
        char text[1024];
        fprintf(stderr, "%s\n", fewray_error_text(&error, text, sizeof text));
        return 1;
    }
    return 0;
}
