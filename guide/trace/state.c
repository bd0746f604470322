/* SPDX-License-Identifier: Apache-2.0 */
/* A render's state: what it consists of, in the order of its bytes. */

#include "guide/trace/state.h"

#include <stdlib.h>
#include <string.h>

#include "guide/odis/maps_state.h"
#include "guide/trace/film.h"
#include "guide/trace/rest.h"

/* What the arrays that follow depend on; numbers alone. */
struct head {
    int phase, width, height, spp, look_samples;
    int first, end, next, tiles;
    int guided, split, seconds, kept; /* whether there are maps, ... */
    uint32_t part;
    struct fewray_render_stats before, pass; /* counts */
};

int fewray_state_create(struct fewray_state **out, struct fewray_error *error) {
    *out = calloc(1, sizeof **out);
    return *out ? FEWRAY_OK
                : fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0, "no memory for the state");
}

void fewray_state_destroy(struct fewray_state **state) {
    if (!*state)
        return;
    fewray_look_destroy(&(*state)->read_look);
    fewray_look_destroy(&(*state)->read_kept);
    free(*state);
    *state = NULL;
}

void state_enter(struct fewray_state *state, enum state_phase phase, int first, int end) {
    if (!state)
        return;
    if (!state->resumes) {
        state->next = 0;
        state->counts = (struct fewray_render_stats){0};
    }
    state->phase = phase;
    state->first = first;
    state->end = end;
}

bool fewray_state_is_behind_look(const struct fewray_state *state) {
    return state->phase == STATE_REST;
}

bool fewray_state_can_be_written(const struct fewray_state *state) {
    return !state->resumes &&
           (state->phase == STATE_REST || (state->phase == STATE_LOOK && state->look));
}

void fewray_state_has_maps(struct fewray_state *state) {
    state->look = NULL;
    state_enter(state, STATE_REST, 0, 0);
}

double fewray_state_samples(const struct fewray_state *state) {
    const double part = state->tiles > 0 ? (double)state->next / state->tiles : 0;
    if (state->phase == STATE_LOOK)
        return part * state->look_samples;
    return state->look_samples + state->first + part * (state->end - state->first);
}

static bool move_film(struct stream *s, struct fewray_film *film, bool look) {
    const size_t pixels = (size_t)film->width * (size_t)film->height;
    return (!look || stream_move(s, film->group[GROUP_LOOK], pixels * sizeof **film->group)) &&
           stream_move(s, film->group[GROUP_REST], pixels * sizeof **film->group) &&
           (!film->indirect ||
            stream_move(s, film->indirect, pixels * GROUP_COUNT * sizeof *film->indirect));
}

static bool move_body(struct stream *s, const struct head *head, struct fewray_film *film,
                      struct fewray_maps **maps, struct fewray_look **look,
                      struct fewray_look **kept) {
    const int w = head->width, h = head->height;
    const bool looking = head->phase == STATE_LOOK;
    return move_film(s, film, looking || head->guided) &&
           (!looking || stream_look(s, look, w, h, head->look_samples, head->seconds)) &&
           (!head->guided || maps_move(s, w, h, maps)) &&
           (!head->kept || stream_look(s, kept, w, h, KEPT_SAMPLES, true));
}

bool fewray_state_write(const struct fewray_state *state,
                        const struct fewray_render_settings *settings,
                        const struct fewray_film *film, const struct fewray_maps *maps,
                        const struct fewray_render_stats *counts,
                        bool (*write)(void *user, const void *bytes, size_t size), void *user) {
    struct stream s = {.write = write, .user = user};
    struct fewray_look *look = (struct fewray_look *)state->look;
    struct fewray_look *kept = (struct fewray_look *)rest_kept(state->rest);
    struct head head;
    memset(&head, 0, sizeof head); /* its padding, too */
    head.phase = (int)state->phase;
    head.width = film->width;
    head.height = film->height;
    head.spp = settings->spp;
    head.look_samples = state->look_samples;
    head.first = state->first;
    head.end = state->end;
    head.next = state->next;
    head.tiles = state->tiles;
    head.guided = maps != NULL;
    head.split = film->indirect != NULL;
    head.seconds = look && look->seconds;
    head.kept = kept != NULL;
    head.part = rest_part(state->rest);
    head.before = *counts;
    head.pass = state->counts;
    struct fewray_maps *moved = (struct fewray_maps *)maps;
    return STREAM_MOVE(&s, head) &&
           move_body(&s, &head, (struct fewray_film *)film, &moved, &look, &kept);
}

/* Whether the numbers can be those of this render. */
static bool is_sound(const struct head *head, const struct fewray_film *film,
                     const struct fewray_render_settings *settings) {
    const int tiles = film_tile_count(film);
    return (head->phase == STATE_LOOK || head->phase == STATE_REST) && head->width == film->width &&
           head->height == film->height && head->spp > 0 && head->look_samples >= 0 &&
           head->look_samples <= head->spp && head->first >= 0 && head->first <= head->end &&
           head->end <= head->spp - head->look_samples &&
           (head->tiles == 0 || head->tiles == tiles) && head->next >= 0 &&
           head->next <= head->tiles && head->split == (film->indirect != NULL) &&
           (head->phase == STATE_REST || !head->seconds == !settings->probes) &&
           (!head->guided || head->phase == STATE_REST) &&
           (head->phase == STATE_REST ? head->look_samples == (head->guided ? settings->initial : 0)
                                      : head->look_samples == settings->initial);
}

/* Whether samples done for a render of other spp are the first ones of this one, too. */
static bool fits(const struct head *head, const struct fewray_render_settings *settings) {
    if (head->spp == settings->spp)
        return true;
    if (settings->part)
        return false; /* parts lie one after another in the pixels' sequences */
    return head->phase == STATE_LOOK ||
           rest_passes_agree(settings->refine && head->guided, head->look_samples, head->spp,
                             settings->spp, head->first, head->next);
}

int fewray_state_read(struct fewray_state *state, const struct fewray_render_settings *settings,
                      struct fewray_film *film, struct fewray_maps **maps,
                      struct fewray_render_stats *counts,
                      bool (*read)(void *user, void *bytes, size_t size), void *user, size_t size,
                      struct fewray_error *error) {
    struct stream s = {.read = read, .user = user, .left = size};
    struct head head = {0};
    *maps = NULL;
    bool moved = STREAM_MOVE(&s, head) && stream_demand(&s, is_sound(&head, film, settings));
    if (moved && !fits(&head, settings))
        return fewray_fail(error, FEWRAY_ERROR_ARGUMENT, NULL, 0,
                           "the samples done for --spp %d aren't the first ones of --spp %d; give "
                           "--spp %d",
                           head.spp, settings->spp, head.spp);
    moved = moved && move_body(&s, &head, film, maps, &state->read_look, &state->read_kept) &&
            stream_demand(&s, s.left == 0);
    if (!moved) {
        fewray_maps_destroy(maps);
        return s.fault == STREAM_NO_MEMORY
                   ? fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0, "no memory for the state")
                   : fewray_fail(error, FEWRAY_ERROR_FORMAT, NULL, 0,
                                 s.fault == STREAM_CUT ? "the state is cut off"
                                                       : "the state holds impossible values");
    }
    state->phase = (enum state_phase)head.phase;
    state->look_samples = head.look_samples;
    state->first = head.first;
    state->end = head.end;
    state->next = head.next;
    state->tiles = head.tiles;
    state->counts = head.pass;
    state->read_part = head.part;
    state->resumes = true;
    *counts = head.before;
    return FEWRAY_OK;
}
