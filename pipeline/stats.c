/* SPDX-License-Identifier: Apache-2.0 */
/* Statistics as JSON, by jansson. */

#include "pipeline/stats.h"

#include <jansson.h>
#include <math.h>
#include <omp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>

#include "pipeline/origin.h"

int stats_threads(int threads) {
    return threads > 0 ? threads : omp_get_num_procs();
}

static json_int_t peak_rss_bytes(void) {
    struct rusage usage;
    return getrusage(RUSAGE_SELF, &usage) ? 0 : (json_int_t)usage.ru_maxrss * 1024;
}

/* Microseconds are enough, and keep the file readable. */
static void set_seconds(json_t *object, const char *key, double seconds) {
    json_object_set_new(object, key, json_real(round(seconds * 1e6) / 1e6));
}

static void set_count(json_t *object, const char *key, long long count) {
    json_object_set_new(object, key, json_integer(count));
}

static void add_skipped(json_t *skipped, const char *what, const char *why, long long count) {
    if (count > 0)
        json_array_append_new(skipped, json_pack("{s:s, s:s, s:I}", "what", what, "why", why,
                                                 "count", (json_int_t)count));
}

/* What the scene didn't need. */
static json_t *list_skipped(const struct fewray_run_stats *stats) {
    const struct fewray_render_stats *counts = &stats->counts;
    const long long pixels = (long long)stats->width * stats->height;
    json_t *skipped = json_array();
    add_skipped(skipped, "image library", "the scene has no textures", stats->no_images);
    add_skipped(skipped, "textures", "no visible material uses them", stats->unused_textures);
    add_skipped(skipped, "network on a grid point", "nothing there to guide",
                counts->grids - counts->grids_inferred - counts->grids_shared);
    add_skipped(skipped, "network on a grid point", "a flat surface shares a neighbour's map",
                counts->grids_shared);
    if (counts->grids > 0)
        add_skipped(skipped, "guide of a pixel", "no map can be sampled there",
                    pixels - counts->pixels_guided);
    if (stats->guide_skipped)
        add_skipped(skipped, "guide", "the first bounce causes too little of the noise", pixels);
    if (stats->first_look_was_all)
        add_skipped(skipped, "guided samples", "the first look used the whole budget", pixels);
    add_skipped(skipped, "denoiser tile", "nothing there to filter",
                (long long)stats->tiles - stats->tiles_denoised);
    return skipped;
}

/* What the planner decided; NaN is null, there is no such number in JSON. */
static json_t *plan_to_json(const struct fewray_plan *plan, double seconds) {
    json_t *object = json_object(), *reasons = json_array();
    for (int i = 0; i < plan->reason_count; i++)
        json_array_append_new(reasons, json_string(plan->reasons[i]));
    if (plan->wanted_s > 0)
        set_seconds(object, "wanted_s", plan->wanted_s);
    set_seconds(object, "predicted_s", plan->predicted_s);
    set_seconds(object, "true_s", seconds);
    if (plan->wanted_error > 0)
        json_object_set_new(object, "wanted_error", json_real(plan->wanted_error));
    json_object_set_new(object, "estimated_error",
                        isnan(plan->estimated_error) ? json_null()
                                                     : json_real(plan->estimated_error));
    json_object_set_new(object, "spp", json_real(plan->spp));
    set_count(object, "least_spp", plan->least_spp);
    set_count(object, "most_spp", plan->most_spp);
    set_count(object, "passes", plan->passes);
    set_count(object, "pictures", plan->pictures);
    json_object_set_new(object, "adaptive", json_boolean(plan->adaptive));
    json_object_set_new(object, "hit_max_spp", json_boolean(plan->hit_max_spp));
    json_object_set_new(object, "too_short", json_boolean(plan->too_short));
    json_object_set_new(object, "reasons", reasons);
    return object;
}

/* What ran where, for whoever reads the figures later. */
static void set_origin(json_t *object) {
    char text[4096];
    json_object_set_new(object, "version", json_string(FEWRAY_VERSION));
    origin_cpu(text, sizeof text);
    json_object_set_new(object, "cpu", json_string(text));
    if (origin_command(text, sizeof text))
        json_object_set_new(object, "command", json_string(text));
}

static json_t *stats_to_json(const struct fewray_run_stats *stats) {
    const struct fewray_render_stats *counts = &stats->counts;
    json_t *object = json_object();
    set_seconds(object, "load_s", stats->load_s);
    set_seconds(object, "bvh_s", stats->bvh_s);
    set_seconds(object, "initial_s", stats->initial_s);
    set_seconds(object, "guide_s", stats->guide_s);
    set_seconds(object, "render_s", stats->render_s);
    set_seconds(object, "denoise_s", stats->denoise_s);
    set_seconds(object, "write_s", stats->write_s);
    set_seconds(object, "total_s", stats->total_s);
    set_seconds(object, "preview_s", stats->preview_s);
    set_count(object, "previews", stats->previews);
    set_seconds(object, "checkpoint_s", stats->checkpoint_s);
    set_count(object, "checkpoints", stats->checkpoints);
    if (stats->resumes > 0)
        json_object_set_new(object, "resumed",
                            json_pack("{s:i, s:f, s:f}", "times", stats->resumes, "at_spp",
                                      stats->resumed_spp, "earlier_s",
                                      round(stats->earlier_s * 1e6) / 1e6));
    set_count(object, "peak_rss_bytes", peak_rss_bytes());
    set_origin(object);
    set_count(object, "threads", stats->threads);
    set_count(object, "width", stats->width);
    set_count(object, "height", stats->height);
    set_count(object, "spp", stats->spp);
    set_count(object, "paths", counts->paths);
    set_count(object, "rays", counts->rays);
    set_count(object, "dropped", counts->dropped);
    set_count(object, "edge_pixels", counts->edge_pixels);
    set_count(object, "repaired", (long long)stats->repaired);
    set_count(object, "clipped", (long long)stats->clipped);
    set_count(object, "lost", (long long)stats->lost);
    set_count(object, "grids", counts->grids);
    set_count(object, "grids_inferred", counts->grids_inferred);
    set_count(object, "pixels_guided", counts->pixels_guided);
    set_count(object, "tiles", stats->tiles);
    set_count(object, "tiles_denoised", stats->tiles_denoised);
    json_object_set_new(object, "skipped", list_skipped(stats));
    if (stats->plan.made)
        json_object_set_new(object, "plan", plan_to_json(&stats->plan, stats->total_s));
    return object;
}

int stats_write_json(json_t *object, const char *path, struct fewray_error *error) {
    char *text = object ? json_dumps(object, JSON_INDENT(2) | JSON_REAL_PRECISION(9)) : NULL;
    json_decref(object);
    if (!text)
        return fewray_fail(error, FEWRAY_ERROR_MEMORY, path, 0, "no memory for the statistics");
    const size_t length = strlen(text);
    text[length] = '\n'; /* in place of the terminator: a text file ends with a line */
    const int status = fewray_write_file(path, text, length + 1, error);
    free(text);
    return status;
}

int stats_write(const struct fewray_run_stats *stats, const char *path,
                struct fewray_error *error) {
    return stats_write_json(stats_to_json(stats), path, error);
}

bool stats_half_warning(const struct fewray_run_stats *stats, char *text, size_t size) {
    const size_t pixels = (size_t)stats->width * (size_t)stats->height;
    const char *advice = "--float keeps them";
    if (stats->clipped > 0)
        snprintf(text, size,
                 "%zu pixels are brighter than 65504, the most that half floats hold; %s",
                 stats->clipped, advice);
    else if (2 * stats->lost > pixels)
        snprintf(text, size, "%zu pixels with light are below 3e-8 and black in half floats; %s",
                 stats->lost, advice);
    else
        return false;
    return true;
}

static double number_of(const json_t *object, const char *key) {
    return json_number_value(json_object_get(object, key));
}

int stats_read_summary(const char *path, char *text, size_t size, struct fewray_error *error) {
    json_error_t fault;
    json_t *object = json_load_file(path, 0, &fault);
    if (!object)
        return fewray_fail(error, FEWRAY_ERROR_FORMAT, path, fault.line > 0 ? fault.line : 0,
                           "the statistics can't be read: %s", fault.text);
    if (!json_is_number(json_object_get(object, "total_s"))) {
        json_decref(object);
        return fewray_fail(error, FEWRAY_ERROR_FORMAT, path, 0,
                           "there is no total_s; give a file that `fewray render --stats` wrote");
    }
    snprintf(text, size,
             "%.0f spp, %.2f s: look %.2f, guide %.2f, render %.2f, denoise %.2f; %.0f threads",
             number_of(object, "spp"), number_of(object, "total_s"), number_of(object, "initial_s"),
             number_of(object, "guide_s"), number_of(object, "render_s"),
             number_of(object, "denoise_s"), number_of(object, "threads"));
    json_decref(object);
    return FEWRAY_OK;
}
