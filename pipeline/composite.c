/* SPDX-License-Identifier: Apache-2.0 */
/* The layout of a composite: a column for each picture (label, picture, magnified crops, error heat
 * map), with the legend and the metrics below the reference. Everything is drawn in multiples of a
 * letter's height. */

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "pipeline/crops.h"
#include "pipeline/display.h"
#include "pipeline/opencv.h"

enum { PANEL_LEAST = 420, PANEL_MOST = 1280, PICTURE_MAX = 3 };
enum { BACKGROUND = 0x16181c, INK = 0xf2f2f2, FAINT = 0xb4bac2 };
static const canvas_color CROP_COLORS[FEWRAY_CROPS] = {0xff9f1c, 0x2ec4f0, 0xe85dff};
static const char *const LABELS[PICTURE_MAX] = {"noisy", "denoised", "reference"};

/* Heat runs over the logarithm of the relative error between these. */
static const double HEAT_LEAST = 0.01, HEAT_MOST = 3;

struct layout {
    int letter, gap;               /* pixels: height of a capital, space between things */
    int column_width;              /* at least the panel's */
    int panel_width, panel_height; /* of a picture as shown */
    int crop_width, crop_height;   /* of a magnified crop as shown */
    int label_y, panel_y, crop_y, heat_label_y, heat_y, caption_y;
    int width, height;
};

struct composite {
    const struct opencv *cv;
    int count;         /* of pictures: 2, or 3 with the reference */
    int width, height; /* of the pictures, pixels */
    float *planes[PICTURE_MAX][3];
    uint8_t *shown[PICTURE_MAX]; /* (height, width, 3), sRGB */
    uint8_t *heat[PICTURE_MAX];  /* (height, width, 3), of noisy and denoised where there is a
                                    reference */
    struct fewray_metrics metrics[2];
    struct fewray_crop crops[FEWRAY_CROPS];
    int crop_count;
    struct layout layout;
    struct canvas *canvas;
};

static uint8_t *show(float *const planes[3], size_t count, double exposure) {
    uint8_t *rgb = malloc(3 * count);
    const double scale = exp2(exposure);
    for (size_t i = 0; rgb && i < count; i++)
        for (int c = 0; c < 3; c++)
            rgb[3 * i + c] = display_byte(scale * planes[c][i]);
    return rgb;
}

/* |x - r| / (|r| + 0.01), mean of the channels; a pixel that isn't finite is as wrong as can be. */
static double relative_error(float *const x[3], float *const r[3], size_t i) {
    double sum = 0;
    for (int c = 0; c < 3; c++)
        sum += fabs((double)x[c][i] - r[c][i]) / (fabs((double)r[c][i]) + 0.01);
    return isfinite(sum) ? sum / 3 : HEAT_MOST;
}

static double heat_position(double error) {
    const double position = log(fmax(error, 1e-12) / HEAT_LEAST) / log(HEAT_MOST / HEAT_LEAST);
    return fmin(fmax(position, 0), 1);
}

static uint8_t *heat(const struct opencv *cv, float *const x[3], float *const r[3], int width,
                     int height) {
    const size_t count = (size_t)width * (size_t)height;
    uint8_t *rgb = malloc(3 * count), *values = malloc(count);
    bool drawn = rgb && values && count <= 1u << 30;
    for (size_t i = 0; drawn && i < count; i++)
        values[i] = (uint8_t)(255 * heat_position(relative_error(x, r, i)) + 0.5);
    drawn = drawn && cv->heat_colors(values, (int)count, rgb);
    free(values);
    if (!drawn) {
        free(rgb);
        rgb = NULL;
    }
    return rgb;
}

static int at_least(int value, int least) {
    return value > least ? value : least;
}

/* Small pictures are enlarged by a whole number, large ones shrunk. */
static void size_panel(struct composite *in) {
    struct layout *layout = &in->layout;
    const double longer = in->width > in->height ? in->width : in->height;
    double scale = longer > PANEL_MOST ? PANEL_MOST / longer : 1;
    if (in->width < PANEL_LEAST && longer * 2 <= PANEL_MOST)
        scale = fmax(1, fmin(floor(PANEL_MOST / longer), ceil((double)PANEL_LEAST / in->width)));
    layout->panel_width = at_least((int)lround(in->width * scale), 1);
    layout->panel_height = at_least((int)lround(in->height * scale), 1);
    layout->column_width = at_least(layout->panel_width, PANEL_LEAST);
}

static void lay_out(struct composite *in, int slots, bool caption) {
    struct layout *layout = &in->layout;
    size_panel(in);
    layout->letter = at_least(layout->column_width / 38, 11);
    layout->gap = layout->letter / 2 + 2;
    layout->crop_width = (layout->column_width - (slots - 1) * layout->gap) / slots;
    layout->crop_height = layout->crop_width * 3 / 4;

    const int line = 2 * layout->letter;
    layout->label_y = layout->gap + line - layout->letter / 2;
    layout->panel_y = layout->gap + line;
    layout->crop_y = layout->panel_y + layout->panel_height + layout->gap;
    layout->heat_label_y =
        layout->crop_y + layout->crop_height + layout->gap + line - layout->letter / 2;
    layout->heat_y = layout->heat_label_y + layout->letter / 2;
    const int heat_height = at_least(layout->panel_height, 14 * layout->letter);
    const int end =
        in->count == 3 ? layout->heat_y + heat_height : layout->crop_y + layout->crop_height;
    layout->caption_y = end + layout->gap + line - layout->letter / 2;
    layout->height = (caption ? layout->caption_y + layout->letter / 2 : end) + layout->gap;
    layout->width = in->count * (layout->column_width + layout->gap) + layout->gap;
}

static int column_x(const struct composite *in, int column) {
    return in->layout.gap + column * (in->layout.column_width + in->layout.gap);
}

/* Crops of the asked places cut to the picture, or picked ones: magnified 4 times, more where the
 * panel itself is enlarged. */
static int choose_crops(struct composite *in, const struct fewray_composite_options *options,
                        struct fewray_error *error) {
    for (int i = 0; i < options->crop_count; i++) {
        struct fewray_crop *crop = &in->crops[i];
        *crop = options->crops[i];
        if (crop->x < 0 || crop->y < 0 || crop->width < 1 || crop->height < 1 ||
            crop->x >= in->width || crop->y >= in->height)
            return fewray_fail(error, FEWRAY_ERROR_ARGUMENT, NULL, 0,
                               "the crop %d,%d,%d,%d lies outside of %dx%d pixels", crop->x,
                               crop->y, crop->width, crop->height, in->width, in->height);
        if (crop->width > in->width - crop->x)
            crop->width = in->width - crop->x;
        if (crop->height > in->height - crop->y)
            crop->height = in->height - crop->y;
    }
    in->crop_count = options->crop_count;
    if (in->crop_count)
        return FEWRAY_OK;

    const struct layout *layout = &in->layout;
    const double zoom = fmax(4, 2.0 * layout->panel_width / in->width);
    int w = at_least((int)(layout->crop_width / zoom), 4),
        h = at_least((int)(layout->crop_height / zoom), 3);
    w = w < in->width ? w : in->width;
    h = h < in->height ? h : in->height;
    in->crop_count = FEWRAY_CROPS;
    if (!crops_pick(in->shown[0], in->shown[1], in->shown[in->count - 1], in->width, in->height, w,
                    h, in->crops))
        return fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0, "no memory to pick crops");
    return FEWRAY_OK;
}

/* Where a crop of this shape stands in its slot. */
static struct box crop_place(const struct composite *in, int column, int i) {
    const struct layout *layout = &in->layout;
    const struct fewray_crop *crop = &in->crops[i];
    const double scale =
        fmin((double)layout->crop_width / crop->width, (double)layout->crop_height / crop->height);
    const int w = at_least((int)(crop->width * scale), 1),
              h = at_least((int)(crop->height * scale), 1);
    return (struct box){column_x(in, column) + i * (layout->crop_width + layout->gap),
                        layout->crop_y, w, h};
}

static void draw_panel(struct composite *in, int column) {
    const struct layout *layout = &in->layout;
    const int x = column_x(in, column), line = at_least(layout->letter / 8, 1);
    const struct box whole = {0, 0, in->width, in->height};
    in->cv->text(in->canvas, x, layout->label_y, layout->letter, INK, LABELS[column]);
    in->cv->paste(in->canvas, in->shown[column], in->width, in->height, whole,
                  (struct box){x, layout->panel_y, layout->panel_width, layout->panel_height});
    const double scale_x = (double)layout->panel_width / in->width,
                 scale_y = (double)layout->panel_height / in->height;
    for (int i = 0; i < in->crop_count; i++) {
        const struct fewray_crop *crop = &in->crops[i];
        const struct box part = {crop->x, crop->y, crop->width, crop->height};
        const struct box mark = {
            x + (int)(crop->x * scale_x), layout->panel_y + (int)(crop->y * scale_y),
            at_least((int)(crop->width * scale_x), 3), at_least((int)(crop->height * scale_y), 3)};
        const struct box place = crop_place(in, column, i);
        in->cv->outline(in->canvas, mark, line, CROP_COLORS[i]);
        in->cv->paste(in->canvas, in->shown[column], in->width, in->height, part, place);
        in->cv->outline(in->canvas, place, 2 * line, CROP_COLORS[i]);
    }
}

static void draw_heat(struct composite *in, int column) {
    const struct layout *layout = &in->layout;
    const int x = column_x(in, column);
    char label[64];
    snprintf(label, sizeof label, "error of %s: %.3g %%", LABELS[column],
             100 * in->metrics[column].mape);
    in->cv->text(in->canvas, x, layout->heat_label_y, layout->letter, INK, label);
    in->cv->paste(in->canvas, in->heat[column], in->width, in->height,
                  (struct box){0, 0, in->width, in->height},
                  (struct box){x, layout->heat_y, layout->panel_width, layout->panel_height});
}

/* The colour scale with ticks in per cent. */
static void draw_legend(struct composite *in) {
    static const double ticks[] = {0.01, 0.03, 0.1, 0.3, 1, 3};
    const struct layout *layout = &in->layout;
    const int x = column_x(in, 2), width = layout->column_width - 2 * layout->letter,
              letter = layout->letter;
    const int y = layout->heat_y + letter / 2;
    uint8_t values[256], colors[256 * 3];
    for (int i = 0; i < 256; i++)
        values[i] = (uint8_t)i;
    if (in->cv->heat_colors(values, 256, colors))
        in->cv->paste(in->canvas, colors, 256, 1, (struct box){0, 0, 256, 1},
                      (struct box){x, y, width, letter});
    for (size_t i = 0; i < sizeof ticks / sizeof *ticks; i++) {
        char text[16];
        snprintf(text, sizeof text, "%g %%", 100 * ticks[i]);
        const int at = x + (int)(heat_position(ticks[i]) * (width - 1)),
                  size = in->cv->text_width(0.8 * letter, text);
        int text_x = at - size / 2;
        text_x = text_x < x                                 ? x
                 : text_x + size > x + layout->column_width ? x + layout->column_width - size
                                                            : text_x;
        in->cv->fill(in->canvas, (struct box){at, y + letter, 1, letter / 2}, INK);
        in->cv->text(in->canvas, text_x, y + letter * 27 / 10, 0.8 * letter, INK, text);
    }
    in->cv->text(in->canvas, x, layout->heat_label_y, letter, INK, "relative error");
    in->cv->text(in->canvas, x, y + letter * 44 / 10, 0.75 * letter, FAINT,
                 "|x - r| / (|r| + 0.01), mean of R, G, B");
}

/* Metrics of noisy and denoised side by side, below the legend. */
static void draw_metrics(struct composite *in) {
    const struct fewray_metrics *noisy = &in->metrics[0], *denoised = &in->metrics[1];
    const struct {
        const char *name;
        double noisy, denoised;
    } rows[] = {
        {"mrse", noisy->mrse, denoised->mrse},
        {"ssim loss", noisy->ssim_loss, denoised->ssim_loss},
        {"psnr (dB)", noisy->psnr, denoised->psnr},
    };
    const struct layout *layout = &in->layout;
    const int letter = layout->letter, x = column_x(in, 2);
    const int columns[2] = {x + layout->column_width * 2 / 5, x + layout->column_width * 7 / 10};
    int y = layout->heat_y + 7 * letter;
    for (int c = 0; c < 2; c++)
        in->cv->text(in->canvas, columns[c], y, 0.9 * letter, FAINT, LABELS[c]);
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        y += 2 * letter;
        in->cv->text(in->canvas, x, y, 0.9 * letter, FAINT, rows[i].name);
        for (int c = 0; c < 2; c++) {
            char text[32];
            snprintf(text, sizeof text, "%.4g", c ? rows[i].denoised : rows[i].noisy);
            in->cv->text(in->canvas, columns[c], y, 0.9 * letter, INK, text);
        }
    }
}

static void draw_caption(struct composite *in, const char *caption) {
    const struct layout *layout = &in->layout;
    const int room = layout->width - 2 * layout->gap;
    const int wanted = in->cv->text_width(layout->letter, caption);
    const double size = wanted > room ? (double)layout->letter * room / wanted : layout->letter;
    in->cv->text(in->canvas, layout->gap, layout->caption_y, size, INK, caption);
}

static bool find_pictures(struct composite *in,
                          const struct fewray_frame *const frames[PICTURE_MAX]) {
    in->count = frames[2] ? 3 : 2;
    in->width = frames[0]->width;
    in->height = frames[0]->height;
    for (int i = 0; i < in->count; i++) {
        const bool noisy = i == 0 && fewray_frame_layer(frames[i], FEWRAY_NOISY, in->planes[i]);
        if (!noisy && !fewray_frame_layer(frames[i], FEWRAY_COLOR, in->planes[i]))
            return false;
        if (frames[i]->width != in->width || frames[i]->height != in->height)
            return false;
    }
    return true;
}

/* Everything that is drawn later, of every pixel. */
static int prepare(struct composite *in, const struct fewray_frame *reference, double exposure,
                   struct fewray_error *error) {
    static const char *const noise_names[3] = {"stderr.R", "stderr.G", "stderr.B"};
    const size_t count = (size_t)in->width * (size_t)in->height;
    for (int i = 0; i < in->count; i++)
        if (!(in->shown[i] = show(in->planes[i], count, exposure)))
            return fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0, "no memory for a composite");
    if (!reference)
        return FEWRAY_OK;
    float *noise[3];
    bool has_noise = true;
    for (int c = 0; c < 3; c++)
        has_noise = (noise[c] = fewray_frame_plane(reference, noise_names[c])) && has_noise;
    for (int i = 0; i < 2; i++) {
        if (!(in->heat[i] = heat(in->cv, in->planes[i], in->planes[2], in->width, in->height)))
            return fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0, "no memory for a heat map");
        const int status = in->cv->metrics(in->planes[i], in->planes[2], has_noise ? noise : NULL,
                                           in->width, in->height, &in->metrics[i], error);
        if (status)
            return status;
    }
    return FEWRAY_OK;
}

static int draw_all(struct composite *in, const char *caption, const char *png_path,
                    struct fewray_error *error) {
    in->canvas = in->cv->create(in->layout.width, in->layout.height, BACKGROUND);
    if (!in->canvas)
        return fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0, "no memory for a composite");
    for (int i = 0; i < in->count; i++)
        draw_panel(in, i);
    for (int i = 0; i < 2 && in->heat[i]; i++)
        draw_heat(in, i);
    if (in->count == 3) {
        draw_legend(in);
        draw_metrics(in);
    }
    if (caption)
        draw_caption(in, caption);
    const uint8_t *pixels = in->cv->pixels(in->canvas);
    if (!pixels)
        return fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0, "the composite can't be drawn");
    return fewray_image_write_png(png_path, in->layout.width, in->layout.height, pixels, error);
}

int fewray_composite(const struct fewray_frame *noisy, const struct fewray_frame *denoised,
                     const struct fewray_frame *reference,
                     const struct fewray_composite_options *options, const char *png_path,
                     struct fewray_error *error) {
    static const struct fewray_composite_options defaults;
    const struct fewray_frame *const frames[PICTURE_MAX] = {noisy, denoised, reference};
    struct composite in = {0};
    int status;
    if (!options)
        options = &defaults;
    if (!find_pictures(&in, frames) || options->crop_count < 0 ||
        options->crop_count > FEWRAY_CROPS)
        return fewray_fail(
            error, FEWRAY_ERROR_ARGUMENT, NULL, 0,
            "a composite needs pictures of one size, with R, G, B each, and %d crops at most",
            FEWRAY_CROPS);
    lay_out(&in, options->crop_count ? options->crop_count : FEWRAY_CROPS, options->caption);
    in.cv = opencv_open(error);
    if (!in.cv)
        return FEWRAY_ERROR_UNSUPPORTED;
    if (!(status = prepare(&in, reference, options->exposure, error)) &&
        !(status = choose_crops(&in, options, error)))
        status = draw_all(&in, options->caption, png_path, error);
    if (in.canvas)
        in.cv->destroy(&in.canvas);
    for (int i = 0; i < PICTURE_MAX; i++) {
        free(in.shown[i]);
        free(in.heat[i]);
    }
    return status;
}
