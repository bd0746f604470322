/* SPDX-License-Identifier: Apache-2.0 */
/* What the processes of a team exchange. */

#include "guide/trace/team.h"

#include <stdlib.h>
#include <string.h>

#include "guide/trace/tiles.h"

#define CHUNK_BYTES ((size_t)8 << 20) /* of all processes, exchanged at once */

static bool is_alone(const struct fewray_team *team) {
    return !team || team->size < 2;
}

static int fail_lost(struct fewray_error *error) {
    return fewray_fail(error, FEWRAY_ERROR_IO, NULL, 0,
                       "the other processes can't be reached any more; start the render again");
}

static int common_divisor(int a, int b) {
    while (b) {
        int rest = a % b;
        a = b;
        b = rest;
    }
    return a;
}

/* A step near the golden ratio of the size spreads each process's tiles evenly over the picture;
 * one without a common divisor gives each column to all of them in turn. */
struct team_deal team_deal(const struct fewray_team *team) {
    if (is_alone(team))
        return (struct team_deal){1, 1};
    int step = (int)(0.618 * team->size) + 1;
    while (common_divisor(step, team->size) != 1)
        step++;
    return (struct team_deal){team->size, step};
}

/* What a process tells of its status. */
struct verdict {
    int status;
    struct fewray_error error;
};
_Static_assert(sizeof(struct verdict) <= FEWRAY_TEAM_MESSAGE, "short messages have room");
_Static_assert(sizeof(struct fewray_render_stats) <= FEWRAY_TEAM_MESSAGE, "likewise");

int fewray_team_agree(const struct fewray_team *team, int status, struct fewray_error *error) {
    if (is_alone(team))
        return status;
    struct verdict mine = {.status = status}, *all = team->messages;
    if (status && error)
        mine.error = *error;
    if (!team->gather(team->user, &mine, all, sizeof(mine)))
        return fail_lost(error);
    int first = -1;
    for (int r = 0; r < team->size; r++) /* who is interrupted could still go on */
        if (all[r].status && (first < 0 || all[first].status == FEWRAY_ERROR_CANCELLED))
            first = r;
    if (first < 0)
        return FEWRAY_OK;
    if (error)
        *error = all[first].error;
    return all[first].status;
}

/* Buffers of one exchange. */
struct exchange {
    size_t room;      /* items of each process */
    char *mine, *all; /* (room, item_bytes); (size, room, item_bytes) */
    size_t *counts;   /* (size) */
};

static void free_exchange(struct exchange *e) {
    free(e->mine);
    free(e->all);
    free(e->counts);
}

/* All return the same status. */
static int start_exchange(const struct fewray_team *team, size_t item_bytes, size_t count,
                          struct exchange *e, struct fewray_error *error) {
    size_t size = (size_t)team->size, room = CHUNK_BYTES / size / item_bytes;
    size_t enough = count < room ? count : room;
    e->room = enough > 0 ? enough : 1;
    e->mine = calloc(e->room, item_bytes);
    e->all = malloc(size * e->room * item_bytes);
    e->counts = calloc(size, sizeof(*e->counts));
    int status = FEWRAY_OK;
    if (!e->mine || !e->all || !e->counts)
        status = fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0,
                             "no memory to exchange results with other processes");
    return fewray_team_agree(team, status, error);
}

int team_share(const struct fewray_team *team, void *items, size_t item_bytes, size_t count,
               team_owner_function owner, const void *user, struct fewray_error *error) {
    if (is_alone(team))
        return FEWRAY_OK;
    struct exchange e = {.room = 0};
    struct team_deal deal = team_deal(team);
    size_t counts_bytes = (size_t)team->size * sizeof(*e.counts), end;
    char *bytes = items;
    int status = start_exchange(team, item_bytes, count, &e, error);
    for (size_t start = 0; start < count && !status; start = end) {
        memset(e.counts, 0, counts_bytes);
        for (end = start; end < count; end++) { /* until a process has no room for its next */
            int o = owner(user, deal, end);
            if (e.counts[o] == e.room)
                break;
            if (o == team->rank)
                memcpy(e.mine + e.counts[o] * item_bytes, bytes + end * item_bytes, item_bytes);
            e.counts[o]++;
        }
        if (!team->gather(team->user, e.mine, e.all, e.room * item_bytes))
            status = fail_lost(error);
        memset(e.counts, 0, counts_bytes);
        for (size_t i = start; i < end && !status; i++) {
            int o = owner(user, deal, i);
            if (o != team->rank)
                memcpy(bytes + i * item_bytes,
                       e.all + ((size_t)o * e.room + e.counts[o]) * item_bytes, item_bytes);
            e.counts[o]++;
        }
    }
    free_exchange(&e);
    return status;
}

static int pixel_owner(const void *user, struct team_deal deal, size_t item) {
    size_t width = *(const size_t *)user;
    return team_owner(deal, (int)(item % width / TILE_SIZE), (int)(item / width / TILE_SIZE));
}

int team_share_pixels(const struct fewray_team *team, void *pixels, size_t pixel_bytes, int width,
                      int height, struct fewray_error *error) {
    size_t w = (size_t)width;
    return team_share(team, pixels, pixel_bytes, w * (size_t)height, pixel_owner, &w, error);
}

int team_add_stats(const struct fewray_team *team, const struct fewray_render_stats *mine,
                   struct fewray_render_stats *sum, struct fewray_error *error) {
    if (is_alone(team)) {
        stats_add(sum, mine);
        return FEWRAY_OK;
    }
    const struct fewray_render_stats *all = team->messages;
    if (!team->gather(team->user, mine, team->messages, sizeof(*mine)))
        return fail_lost(error);
    for (int r = 0; r < team->size; r++)
        stats_add(sum, &all[r]);
    return FEWRAY_OK;
}
