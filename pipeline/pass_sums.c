/* SPDX-License-Identifier: Apache-2.0 */
/* Finds passes that add up to the picture, and prepares them for its kernels. */

#include "pipeline/pass_sums.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "pipeline/pass_recipes.h"

/* A sum holds within this: half floats of a dozen passes are 0.1 % off at most, a missing pass more
 * than this. */
#define SUM_ERROR_MAX 0.005

/* A pass is divided by no smaller colour. */
#define COLOR_MIN 1e-4f

struct search {
    const struct fewray_frame *frame;
    const struct adoption *adoption;
    bool noisy;
    struct pass_sums *out;
    struct pass_sum *sum;
};

static size_t pixel_count(const struct fewray_frame *frame) {
    return (size_t)frame->width * (size_t)frame->height;
}

/* The planes of the pass, of what they were before the denoiser where that is wanted. */
static bool point_to(const struct search *search, struct fewray_plane *const found[3],
                     char channels[3][FEWRAY_NAME_MAX], const float *data[3]) {
    for (int c = 0; c < 3; c++) {
        char noisy[FEWRAY_NAME_MAX + 8];
        snprintf(noisy, sizeof noisy, "noisy.%s", found[c]->name);
        const float *before = search->noisy ? fewray_frame_plane(search->frame, noisy) : NULL;
        data[c] = before ? before : found[c]->data;
        if (channels)
            memcpy(channels[c], found[c]->name, FEWRAY_NAME_MAX);
        if (!data[c])
            return false;
    }
    return true;
}

/* Finds a pass by one of its names, "A|B". */
static bool find_pass(const struct search *search, const char *names,
                      struct fewray_plane *found[3]) {
    while (*names) {
        char stem[FEWRAY_NAME_MAX];
        const int length = (int)strcspn(names, "|");
        snprintf(stem, sizeof stem, "%.*s.", length, names);
        if (layer_find(search->frame, stem, "RGB", found) ||
            layer_find(search->frame, stem, "red,green,blue", found) ||
            layer_find_adopted(search->frame, search->adoption, stem, found))
            return true;
        names += length + (names[length] == '|');
    }
    return false;
}

static void add_pass(struct search *search, struct fewray_plane *const found[3],
                     const char *color) {
    struct pass_sums *out = search->out;
    struct fewray_plane *factor[3];
    if (out->pass_count == PASSES_MAX)
        return;
    struct light_pass *pass = &out->passes[out->pass_count];
    *pass = (struct light_pass){.emission = ""};
    if (!point_to(search, found, pass->channels, pass->data) ||
        (color &&
         (!find_pass(search, color, factor) || !point_to(search, factor, NULL, pass->color))))
        return;
    out->pass_count++;
    search->sum->count++;
}

/* All passes whose name, behind the view layer's, begins with the stem. */
static void add_all(struct search *search, const char *stem, size_t length) {
    for (size_t i = 0; i < search->frame->plane_count; i++) {
        const char *name = search->frame->planes[i].name;
        const char *last = strrchr(name, '.');
        const char *start = last;
        while (start && start > name && start[-1] != '.')
            start--;
        if (!last || strcmp(last, ".R") || strncmp(start, stem, length) ||
            !strncmp(name, "noisy.", strlen("noisy.")))
            continue;
        char whole[FEWRAY_NAME_MAX];
        struct fewray_plane *found[3];
        snprintf(whole, sizeof whole, "%.*s.", (int)(last - name), name);
        if (layer_find(search->frame, whole, "RGB", found))
            add_pass(search, found, NULL);
    }
}

static void add_term(struct search *search, const struct pass_term *term) {
    struct fewray_plane *found[3];
    if (term->unless && find_pass(search, term->unless, found))
        return;
    if (!strchr(term->names, '*')) {
        if (find_pass(search, term->names, found))
            add_pass(search, found, term->color);
        return;
    }
    for (const char *names = term->names; *names;) {
        const size_t length = strcspn(names, "|");
        add_all(search, names, length - 1);
        names += length + (names[length] == '|');
    }
}

/* Mean difference of the sum from the picture, over the picture's mean. */
static double sum_error(const struct fewray_frame *frame, const struct pass_sum *sum) {
    float *color[3], *emission[3];
    double total = 0, off = 0;
    if (!fewray_frame_layer(frame, FEWRAY_COLOR, color))
        return INFINITY;
    if (sum->emission)
        fewray_frame_layer(frame, FEWRAY_EMISSION, emission);
    const size_t count = pixel_count(frame);
    for (int c = 0; c < 3; c++)
        for (size_t i = 0; i < count; i++) {
            double value = sum->emission ? emission[c][i] : 0;
            for (int k = 0; k < sum->count; k++) {
                const struct light_pass *pass = &sum->passes[k];
                value += pass->data[c][i] * (pass->color[c] ? pass->color[c][i] : 1.0f);
            }
            if (!isfinite(value) || !isfinite(color[c][i]))
                continue;
            total += fabs((double)color[c][i]);
            off += fabs(color[c][i] - value);
        }
    return total > 0 ? off / total : INFINITY;
}

/* Where the unfiltered emission belongs. */
static void place_emission(const struct pass_recipe *recipe, bool known, struct pass_sum *sum) {
    for (int k = 0; k < sum->count; k++)
        if (sum->emission)
            sum->passes[k].emission = "";
        else if (known && recipe->emission_inside)
            sum->passes[k].emission = k ? "" : ":emission";
        else
            sum->passes[k].emission = ":shared";
}

static void try_recipe(const struct fewray_frame *frame, const struct adoption *adoption,
                       const struct pass_recipe *recipe, bool noisy, struct pass_sums *out) {
    if (out->count == SUMS_MAX)
        return;
    float *emission[3];
    const int before = out->pass_count;
    struct pass_sum *sum = &out->sums[out->count];
    *sum = (struct pass_sum){
        .naming = recipe->naming, .what = recipe->what, .passes = &out->passes[before]};
    struct search search = {frame, adoption, noisy, out, sum};
    for (const struct pass_term *term = recipe->terms; term->names; term++)
        add_term(&search, term);
    const bool known = fewray_frame_layer(frame, FEWRAY_EMISSION, emission);
    sum->emission = recipe->emission_apart && known;
    if (sum->count + sum->emission < 2 || sum->count < 1) {
        out->pass_count = before;
        return;
    }
    sum->error = sum_error(frame, sum);
    sum->holds = sum->error <= SUM_ERROR_MAX;
    place_emission(recipe, known, sum);
    out->count++;
}

/* Two recipes may name the same passes: the worse one goes. */
static bool is_part_of_another(const struct pass_sums *sums, const struct pass_sum *sum) {
    for (int s = 0; s < sums->count; s++) {
        const struct pass_sum *other = &sums->sums[s];
        bool all = other != sum && (other->holds || !sum->holds) &&
                   (other->count > sum->count || (other->count == sum->count && other < sum));
        for (int k = 0; all && k < sum->count; k++) {
            bool found = false;
            for (int j = 0; j < other->count; j++)
                found |= !strcmp(other->passes[j].channels[0], sum->passes[k].channels[0]);
            all = found;
        }
        if (all)
            return true;
    }
    return false;
}

void pass_sums_find(const struct fewray_frame *frame, const struct adoption *adoption,
                    enum layer_naming naming, bool noisy, struct pass_sums *out) {
    int count;
    const struct pass_recipe *recipes = pass_recipes(&count);
    memset(out, 0, sizeof *out);
    for (int i = 0; i < count; i++)
        if (naming == NAMING_AUTO || naming == recipes[i].naming)
            try_recipe(frame, adoption, &recipes[i], noisy, out);
    bool again[SUMS_MAX];
    for (int s = 0; s < out->count; s++)
        again[s] = is_part_of_another(out, &out->sums[s]);
    int kept = 0;
    for (int s = 0; s < out->count; s++)
        if (!again[s])
            out->sums[kept++] = out->sums[s];
    out->count = kept;
}

/* --- around the denoiser */

static void plane_name(int pass, int c, char name[FEWRAY_NAME_MAX]) {
    snprintf(name, FEWRAY_NAME_MAX, "fewray.pass%02d.%c", pass, "RGB"[c]);
}

const float *pass_sums_plane(const struct fewray_frame *frame, int pass, int c) {
    char name[FEWRAY_NAME_MAX];
    plane_name(pass, c, name);
    return fewray_frame_plane(frame, name);
}

int pass_sums_start(struct fewray_frame *frame, struct pass_sums *sums, char names[][80],
                    int *count, struct fewray_error *error) {
    *count = 0;
    for (int s = 0; s < sums->count; s++)
        for (int k = 0; sums->sums[s].holds && k < sums->sums[s].count; k++) {
            const struct light_pass *pass = &sums->sums[s].passes[k];
            const int index = (int)(pass - sums->passes);
            for (int c = 0; c < 3; c++) {
                char name[FEWRAY_NAME_MAX];
                plane_name(index, c, name);
                float *data = fewray_frame_add(frame, name);
                if (!data)
                    return fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0,
                                       "no memory for the passes");
                for (size_t i = 0; i < pixel_count(frame); i++)
                    data[i] = pass->data[c][i] * (pass->color[c] ? pass->color[c][i] : 1.0f);
                fewray_frame_repair_radiance(frame, data);
            }
            snprintf(names[(*count)++], 80, "fewray.pass%02d%s", index, pass->emission);
        }
    return FEWRAY_OK;
}

static bool can_show(const struct light_pass *pass, int c, size_t i) {
    return !pass->color[c] || pass->color[c][i] > COLOR_MIN;
}

/* One pixel's passes of a sum: the light times colour of the filtered planes becomes light. */
static void divide_pixel(const struct pass_sum *sum, int c, size_t i, float *const planes[]) {
    double shown = 0, lost = 0;
    for (int k = 0; k < sum->count; k++)
        *(can_show(&sum->passes[k], c, i) ? &shown : &lost) += planes[k][i];
    const float scale = shown > 0 ? (float)((shown + lost) / shown) : 1;
    for (int k = 0; k < sum->count; k++) {
        const struct light_pass *pass = &sum->passes[k];
        if (can_show(pass, c, i))
            planes[k][i] *= scale / (pass->color[c] ? pass->color[c][i] : 1);
        else
            planes[k][i] = pass->data[c][i];
    }
}

void pass_sums_finish(struct fewray_frame *frame, struct pass_sums *sums) {
    for (int s = 0; s < sums->count; s++) {
        const struct pass_sum *sum = &sums->sums[s];
        bool divided = false;
        for (int k = 0; k < sum->count; k++)
            divided |= sum->passes[k].color[0] != NULL;
        for (int c = 0; c < 3 && sum->holds && divided; c++) {
            float *planes[PASSES_MAX];
            for (int k = 0; k < sum->count; k++) {
                char name[FEWRAY_NAME_MAX];
                plane_name((int)(&sum->passes[k] - sums->passes), c, name);
                planes[k] = fewray_frame_plane(frame, name);
            }
            for (size_t i = 0; i < pixel_count(frame); i++)
                divide_pixel(sum, c, i, planes);
        }
    }
}
