/* SPDX-License-Identifier: Apache-2.0 */
/* The pictures, one file after another: each is read, shown, judged and forgotten. */

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "features/png.h"
#include "pipeline/layer_names.h"
#include "pipeline/opencv.h"
#include "pipeline/page/page.h"

static double number_of(const json_t *object, const char *key) {
    const json_t *value = json_object_get(object, key);
    return json_is_number(value) ? json_number_value(value) : NAN;
}

/* From first look to denoiser, as the bench counts them; NaN where the statistics don't tell. */
static double work_seconds(const json_t *stats, bool denoised) {
    const double seconds = number_of(stats, "initial_s") + number_of(stats, "guide_s") +
                           number_of(stats, "render_s") +
                           (denoised ? number_of(stats, "denoise_s") : 0);
    return seconds > 0 ? seconds : NAN;
}

/* A plan's samples are fractions: a mean over the picture. */
static double samples(const json_t *stats, const struct fewray_frame *frame) {
    const double planned = number_of(json_object_get(stats, "plan"), "spp"),
                 wanted = number_of(stats, "spp");
    return planned > 0 ? planned : wanted > 0 ? wanted : frame->spp;
}

static int put_image(struct page *page, const char *kind, const struct page_row *row,
                     const void *png, size_t bytes) {
    const struct page_size shown =
        page_shown_size(page->width, page->height, page->options->max_width);
    fprintf(page->file, "<img class=\"%s\" width=\"%d\" height=\"%d\" alt=\"", kind, shown.width,
            shown.height);
    if (!strcmp(kind, "error"))
        fputs("Relative squared error: ", page->file);
    html_text(page->file, row->label);
    fputs("\" src=\"", page->file);
    html_png(page->file, png, bytes);
    fputs("\">\n", page->file);
    return FEWRAY_OK;
}

/* Compares and draws the map. */
static int judge(struct page *page, float *const planes[3], struct page_row *row,
                 struct fewray_error *error) {
    static const char *const noise_names[3] = {"stderr.R", "stderr.G", "stderr.B"};
    const struct opencv *cv = opencv_open(error);
    if (!cv)
        return FEWRAY_ERROR_UNSUPPORTED;
    float *reference[3], *noise[3];
    fewray_frame_layer(page->reference, FEWRAY_COLOR, reference);
    bool has_noise = true;
    for (int c = 0; c < 3; c++)
        has_noise = (noise[c] = fewray_frame_plane(page->reference, noise_names[c])) && has_noise;
    int status = cv->metrics(planes, reference, has_noise ? noise : NULL, page->width, page->height,
                             &row->metrics, error);
    void *png = NULL;
    size_t bytes;
    if (!status)
        status =
            page_error_map(planes, reference, page->width, page->height,
                           page_shown_size(page->width, page->height, page->options->max_width),
                           page->palette, &png, &bytes, error);
    if (!status)
        status = put_image(page, "error", row, png, bytes);
    row->judged = !status;
    free(png);
    return status;
}

static int put_figure(struct page *page, float *const planes[3], struct page_row row,
                      struct fewray_error *error) {
    void *png = NULL;
    size_t bytes;
    int status = page_show(planes, page->width, page->height, page->options->exposure,
                           page_shown_size(page->width, page->height, page->options->max_width),
                           &png, &bytes, error);
    if (status)
        return status;
    fputs("<figure class=\"picture\" data-name=\"", page->file);
    html_text(page->file, row.label);
    fputs("\">\n", page->file);
    put_image(page, "shown", &row, png, bytes);
    free(png);
    if (page->reference && !row.is_reference)
        status = judge(page, planes, &row, error);
    fputs("<figcaption>", page->file);
    html_text(page->file, row.label);
    fputs("</figcaption>\n</figure>\n", page->file);
    page->rows[page->row_count++] = row;
    return status;
}

/* The first picture says how large all are. */
static int check_size(struct page *page, const struct fewray_frame *frame,
                      struct fewray_error *error) {
    if (page->width == 0) {
        page->width = frame->width;
        page->height = frame->height;
        fprintf(page->file,
                "<section style=\"--w:%d;--h:%d\">\n<div class=\"pictures\" role=\"group\" "
                "aria-label=\"Pictures\">\n",
                frame->width, frame->height);
    }
    if (frame->width == page->width && frame->height == page->height)
        return FEWRAY_OK;
    return fewray_fail(error, FEWRAY_ERROR_ARGUMENT, NULL, 0,
                       "has %dx%d pixels, another picture of the page %dx%d; all need one size",
                       frame->width, frame->height, page->width, page->height);
}

/* name without its ".exr"; what: NULL, or behind a comma. */
static void set_label(struct page_row *row, const char *name, const char *what) {
    snprintf(row->label, sizeof row->label, "%.*s%s%s", (int)(strlen(name) - 4), name,
             what ? ", " : "", what ? what : "");
}

static int put_file(struct page *page, const struct fewray_frame *frame, int index,
                    struct fewray_error *error) {
    const json_t *stats = page->stats[index];
    float *noisy[3], *color[3];
    int status = check_size(page, frame, error);
    if (status)
        return status;
    struct page_row row = {.spp = samples(stats, frame)};
    const bool has_noisy = fewray_frame_layer(frame, FEWRAY_NOISY, noisy);
    if (has_noisy) {
        if (page->noisy_row < 0)
            page->noisy_row = page->row_count;
        row.seconds = work_seconds(stats, false);
        set_label(&row, page->folder.names[index], "before the denoiser");
        status = put_figure(page, noisy, row, error);
    }
    if (status)
        return status;
    fewray_frame_layer(frame, FEWRAY_COLOR, color);
    row.seconds = work_seconds(stats, true);
    set_label(&row, page->folder.names[index], NULL);
    return put_figure(page, color, row, error);
}

static int read_stats(const char *exr_path, json_t **stats, struct fewray_error *error) {
    char path[PAGE_PATH_MAX + 8];
    snprintf(path, sizeof path, "%.*s.json", (int)(strlen(exr_path) - 4), exr_path);
    return page_read_json(path, stats, error);
}

static int read_and_put(struct page *page, int index, struct fewray_error *error) {
    char path[PAGE_PATH_MAX];
    struct fewray_frame *frame = NULL;
    int status = page_join(page->options->folder, page->folder.names[index], path, error);
    if (!status)
        status = read_stats(path, &page->stats[index], error);
    if (!status)
        status = read_picture(path, NAMING_AUTO, &frame, error);
    if (!status && (status = put_file(page, frame, index, error)) && error && !error->file[0])
        snprintf(error->file, sizeof error->file, "%s", path);
    fewray_frame_destroy(&frame);
    return status;
}

static int read_reference(struct page *page, struct fewray_error *error) {
    const char *path = page->folder.reference;
    uint8_t steps[256];
    if (!path[0])
        return FEWRAY_OK;
    int status = read_picture(path, NAMING_AUTO, &page->reference, error);
    if (!status && strlen(path) > 4)
        status = read_stats(path, &page->stats[PAGE_FILES_MAX], error);
    const struct opencv *cv = status ? NULL : opencv_open(error);
    if (!cv)
        return status ? status : FEWRAY_ERROR_UNSUPPORTED;
    for (int i = 0; i < 256; i++)
        steps[i] = (uint8_t)i;
    if (!cv->heat_colors(steps, 256, page->palette))
        return fewray_fail(error, FEWRAY_ERROR_MEMORY, path, 0, "no memory for colours");
    return check_size(page, page->reference, error);
}

static int put_reference(struct page *page, struct fewray_error *error) {
    const json_t *stats = page->stats[PAGE_FILES_MAX];
    float *planes[3];
    if (!page->reference)
        return FEWRAY_OK;
    struct page_row row = {.label = "reference",
                           .is_reference = true,
                           .seconds = work_seconds(stats, true),
                           .spp = samples(stats, page->reference)};
    fewray_frame_layer(page->reference, FEWRAY_COLOR, planes);
    return put_figure(page, planes, row, error);
}

/* What the divider first parts: before and after the denoiser; else the largest and the least
 * error; else the first two. */
static void put_pair(const struct page *page) {
    int left = 0, right = page->row_count > 1 ? 1 : 0;
    if (page->noisy_row >= 0) {
        left = page->noisy_row;
        right = left + 1;
    } else if (page->reference && page->folder.count > 1) {
        left = right = 0;
        for (int i = 1; i < page->row_count; i++) {
            const double mrse = page->rows[i].metrics.mrse;
            if (page->rows[i].judged && mrse > page->rows[left].metrics.mrse)
                left = i;
            if (page->rows[i].judged && mrse < page->rows[right].metrics.mrse)
                right = i;
        }
    }
    fprintf(page->file, "<div id=\"pair\" data-left=\"%d\" data-right=\"%d\" hidden></div>\n", left,
            right);
}

static int put_legend(const struct page *page, struct fewray_error *error) {
    uint8_t steps[256];
    void *png = NULL;
    size_t bytes;
    if (!page->reference)
        return FEWRAY_OK;
    for (int i = 0; i < 256; i++)
        steps[i] = (uint8_t)i;
    const int status =
        png_encode_indexed("report", 256, 1, steps, page->palette, &png, &bytes, error);
    if (status)
        return status;
    fputs("<div class=\"legend\">\n<img alt=\"\" src=\"", page->file);
    html_png(page->file, png, bytes);
    free(png);
    fputs("\">\n<div class=\"ticks\">", page->file);
    for (double tick = PAGE_HEAT_LEAST; tick < 1.5 * PAGE_HEAT_MOST; tick *= 10)
        fprintf(page->file, "<span>%g</span>", tick);
    fputs("</div>\nRelative squared error of a pixel, (x &minus; r)&sup2; / (r&sup2; + 0.01), mean "
          "of R, G and B; no unit. Its mean over the picture is mrse.\n</div>\n",
          page->file);
    return FEWRAY_OK;
}

int page_pictures(struct page *page, struct fewray_error *error) {
    int status = read_reference(page, error);
    for (int i = 0; i < page->folder.count && !status; i++)
        status = read_and_put(page, i, error);
    if (!status)
        status = put_reference(page, error);
    if (status || page->row_count == 0)
        return status;
    fputs("</div>\n", page->file);
    status = put_legend(page, error);
    put_pair(page);
    fputs("</section>\n\n", page->file);
    return status;
}
