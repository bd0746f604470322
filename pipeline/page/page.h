/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_PIPELINE_PAGE_H
#define FEWRAY_PIPELINE_PAGE_H

/* `fewray report`: one self-contained HTML page that compares the pictures of a folder. page.html
 * is its frame, page.css its look, page.js its viewer; all three are embedded in the program.
 *
 *     page_write()
 *         page_folder_read()     which EXRs, which of them is the reference
 *         page_pictures()        each picture once: as PNG, as error map, as metrics
 *         page_table(), page_curves(), page_made()
 */

#include <jansson.h>
#include <stdio.h>

#include "fewray/pipeline.h"

struct page_options {
    const char *folder;
    const char *output;    /* NULL: report.html in the folder */
    const char *reference; /* NULL: the folder's reference.exr, where it is there */
    const char *title;     /* NULL: the folder's name */
    float exposure;        /* in stops, before the sRGB transfer function */
    int max_width;         /* pixels; wider pictures are shown smaller, and judged in full */
};

/* Writes the page, whole or not at all. The same files and options give the same bytes. */
int page_write(const struct page_options *options, struct fewray_error *error);

/* --- folder.c */

enum { PAGE_FILES_MAX = 64, PAGE_PATH_MAX = 1024 };

struct page_folder {
    char *names[PAGE_FILES_MAX]; /* of the EXRs without the reference, ascending; owned */
    int count;
    char reference[PAGE_PATH_MAX]; /* path; empty: none */
    char bench[PAGE_PATH_MAX];     /* path of bench.json; empty: none */
};

/* An error where there is neither a picture nor a bench. Release it also after an error. */
int page_folder_read(const struct page_options *options, struct page_folder *folder,
                     struct fewray_error *error);
void page_folder_release(struct page_folder *folder);
/* Writes "FOLDER/NAME" into path, or an error. */
int page_join(const char *folder, const char *name, char path[PAGE_PATH_MAX],
              struct fewray_error *error);
/* Reads the JSON object of a regular file; *out is NULL where there is no such file. */
int page_read_json(const char *path, json_t **out, struct fewray_error *error);

/* --- what the steps share */

/* A picture of the page: a file's result, or what its denoiser was given. */
struct page_row {
    char label[320]; /* "guided", "guided, before the denoiser" */
    bool is_reference;
    bool judged; /* against the reference */
    struct fewray_metrics metrics;
    double seconds; /* of work, from first look to denoiser; NaN: not known */
    double spp;     /* 0: not known */
};

enum { PAGE_ROWS_MAX = 2 * PAGE_FILES_MAX + 1 };

struct page {
    const struct page_options *options;
    struct page_folder folder;
    FILE *file; /* the page so far */
    struct fewray_frame *reference;
    int width, height; /* pixels of every picture; 0: none was read yet */
    uint8_t palette[256 * 3];
    struct page_row *rows;             /* (PAGE_ROWS_MAX); owned */
    int row_count, noisy_row;          /* noisy_row: the first one before a denoiser; -1 */
    json_t *stats[PAGE_FILES_MAX + 1]; /* of each file, the reference's behind them; NULL: none;
                                          owned */
    json_t *bench;                     /* NULL: none; owned */
};

/* Each writes a part of the page. Errors of writing show at the file's end. */
int page_pictures(struct page *page, struct fewray_error *error);
void page_table(const struct page *page);
void page_curves(const struct page *page);
void page_made(const struct page *page);

/* --- picture.c: pixels, (height, width) planes to PNG */

struct page_size {
    int width, height;
};
/* The size in which width x height pixels are shown. */
struct page_size page_shown_size(int width, int height, int max_width);

/* *png is malloc'd. */
int page_show(float *const planes[3], int width, int height, float exposure, struct page_size shown,
              void **png, size_t *bytes, struct fewray_error *error);
/* The error map of x against r: (x - r)^2 / (r^2 + 0.01), mean of the channels, as the metric mrse
 * is the mean of the map. */
int page_error_map(float *const x[3], float *const r[3], int width, int height,
                   struct page_size shown, const uint8_t palette[256 * 3], void **png,
                   size_t *bytes, struct fewray_error *error);
/* The colours of the map run over the logarithm of the error between these. */
#define PAGE_HEAT_LEAST 1e-4
#define PAGE_HEAT_MOST  10.0

/* --- html.c */

/* Text as HTML has it, also between quotes: nothing in it is markup. */
void html_text(FILE *file, const char *text);
/* A data URI of a PNG. */
void html_png(FILE *file, const void *png, size_t bytes);

#endif
