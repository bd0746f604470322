/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_PIPELINE_STATS_H
#define FEWRAY_PIPELINE_STATS_H

/* The statistics of a run as JSON, and back into one line for people. */

#include <jansson.h>

#include "fewray/pipeline.h"

/* threads, or the number of cores that this process may use where it is 0. */
int stats_threads(int threads);

/* Writes an object, which it takes over, as a text file; NULL: there was no memory for it. */
int stats_write_json(json_t *object, const char *path, struct fewray_error *error);

/* Writes the JSON to exactly this file (no temporary). peak_rss_bytes is taken here. */
int stats_write(const struct fewray_run_stats *stats, const char *path, struct fewray_error *error);

/* Writes a sentence into text where half floats were too small for the picture: any pixel clipped,
 * or more than half of all pixels black though there is light. False: they weren't. */
bool stats_half_warning(const struct fewray_run_stats *stats, char *text, size_t size);

/* Reads a JSON that stats_write() left and writes "4 spp, 1.42 s (look 0.2, ...), 2 threads" into
 * text, cut at size. */
int stats_read_summary(const char *path, char *text, size_t size, struct fewray_error *error);

#endif
