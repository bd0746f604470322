/* SPDX-License-Identifier: Apache-2.0 */
/* Teams of processes, played by threads: the same bits as one process alone, the same status for
 * all. */

#include "tests/unit/check.h"

#include <pthread.h>
#include <string.h>

#include "guide/trace/team.h"
#include "guide/trace/tiles.h"

enum { SIZE = 3, WIDTH = 72, HEIGHT = 56 };

/* Where the members of a team meet. */
struct meeting {
    pthread_barrier_t barrier;
    const void *mine[SIZE];
};

struct member {
    struct meeting *meeting;
    struct fewray_team team;
    struct fewray_render_settings settings;
    const char *path;
    char messages[SIZE * FEWRAY_TEAM_MESSAGE];
    int status;
    struct fewray_error error;
    struct fewray_render_stats stats;
    struct fewray_frame *frame;
};

static bool meet(void *user, const void *mine, void *all, size_t bytes) {
    struct member *member = user;
    struct meeting *meeting = member->meeting;
    meeting->mine[member->team.rank] = mine;
    pthread_barrier_wait(&meeting->barrier);
    for (size_t r = 0; r < SIZE; r++)
        memcpy((char *)all + r * bytes, meeting->mine[r], bytes);
    pthread_barrier_wait(&meeting->barrier);
    return true;
}

/* Runs work(member) for all members at once. */
static void play(struct member members[SIZE], void *(*work)(void *)) {
    struct meeting meeting;
    pthread_t threads[SIZE];
    pthread_barrier_init(&meeting.barrier, NULL, SIZE);
    for (int r = 0; r < SIZE; r++) {
        members[r].meeting = &meeting;
        members[r].team = (struct fewray_team){r, SIZE, meet, &members[r], members[r].messages};
        members[r].settings.team = &members[r].team;
        assert_int_equal(pthread_create(&threads[r], NULL, work, &members[r]), 0);
    }
    for (int r = 0; r < SIZE; r++)
        pthread_join(threads[r], NULL);
    pthread_barrier_destroy(&meeting.barrier);
}

/* A guided render. */
static void *render(void *user) {
    struct member *m = user;
    const struct fewray_render_settings *settings = &m->settings;
    struct fewray_scene *scene = NULL;
    struct fewray_world *world = NULL;
    struct fewray_film *film = NULL;
    struct fewray_look *look = NULL;
    struct fewray_maps *maps = NULL;
    if ((m->status = fewray_scene_load(m->path, NULL, &scene, &m->error)) ||
        (m->status = fewray_world_create(scene, settings->threads, &world, &m->error)) ||
        (m->status = fewray_film_create(world, settings, &film, &m->error)) ||
        (m->status = fewray_trace_look(world, settings, film, &look, &m->stats, &m->error)) ||
        (m->status = fewray_maps_create(look, settings, &maps, &m->stats, &m->error)) ||
        (m->status = fewray_trace_rest(world, maps, settings, film, &m->stats, &m->error)) ||
        (m->status = fewray_trace_edges(world, settings, film, &m->stats, &m->error)) ||
        (m->status = fewray_film_frame(film, maps, &m->frame, &m->error)))
        m->frame = NULL;
    fewray_maps_destroy(&maps);
    fewray_look_destroy(&look);
    fewray_film_destroy(&film);
    fewray_world_destroy(&world);
    fewray_scene_destroy(&scene);
    return NULL;
}

static struct fewray_render_settings small(void) {
    struct fewray_render_settings s;
    fewray_render_settings_init(&s);
    s.width = WIDTH;
    s.height = HEIGHT;
    s.spp = 18; /* maps are refined at 4 and at 16 */
    s.threads = 1;
    s.direct = true;
    return s;
}

static void assert_same(const struct member *a, const struct member *b) {
    assert_int_equal(a->status, FEWRAY_OK);
    assert_int_equal(b->status, FEWRAY_OK);
    assert_memory_equal(&a->stats, &b->stats, sizeof(a->stats));
    assert_int_equal(a->frame->plane_count, b->frame->plane_count);
    for (size_t k = 0; k < a->frame->plane_count; k++)
        assert_memory_equal(a->frame->planes[k].data, b->frame->planes[k].data,
                            WIDTH * HEIGHT * sizeof(float));
}

static void test_team_makes_the_same_bits_as_one_process(void **state) {
    (void)state;
    static struct member members[SIZE], alone;
    alone = (struct member){.path = EXAMPLES "/window-room.xml", .settings = small()};
    render(&alone);
    for (int r = 0; r < SIZE; r++)
        members[r] = alone;
    for (int r = 0; r < SIZE; r++) {
        members[r].frame = NULL;
        memset(&members[r].stats, 0, sizeof(members[r].stats));
    }
    play(members, render);
    assert_true(alone.stats.pixels_guided > WIDTH * HEIGHT / 4 && alone.stats.edge_pixels > 0);
    for (int r = 0; r < SIZE; r++) {
        assert_same(&members[r], &alone);
        fewray_frame_destroy(&members[r].frame);
    }
    fewray_frame_destroy(&alone.frame);
}

static void *agree(void *user) {
    struct member *m = user;
    m->status = fewray_team_agree(&m->team, m->status, &m->error);
    return NULL;
}

static void test_all_end_with_the_first_failure_and_its_error(void **state) {
    (void)state;
    static struct member members[SIZE];
    members[1].status = fewray_fail(&members[1].error, FEWRAY_ERROR_CANCELLED, NULL, 0, "stopped");
    members[2].status = fewray_fail(&members[2].error, FEWRAY_ERROR_MEMORY, "file", 7, "too much");
    play(members, agree);
    for (int r = 0; r < SIZE; r++) {
        assert_int_equal(members[r].status, FEWRAY_ERROR_MEMORY);
        assert_string_equal(members[r].error.what, "too much");
        assert_string_equal(members[r].error.file, "file");
    }
    members[0].status = members[2].status = FEWRAY_OK;
    members[1].status = fewray_fail(&members[1].error, FEWRAY_ERROR_CANCELLED, NULL, 0, "stopped");
    play(members, agree);
    for (int r = 0; r < SIZE; r++) {
        assert_int_equal(members[r].status, FEWRAY_ERROR_CANCELLED);
        assert_string_equal(members[r].error.what, "stopped");
    }
}

/* So large that one exchange isn't enough. */
enum { ITEMS = 10000, ITEM_BYTES = 1500 };

static int owner(const void *user, struct team_deal deal, size_t item) {
    (void)user;
    return item < ITEMS / 2 ? 0 : team_owner(deal, (int)item, (int)item / 100);
}

static void *share(void *user) {
    struct member *m = user;
    char *items = calloc(ITEMS, ITEM_BYTES);
    m->status = items ? FEWRAY_OK : FEWRAY_ERROR_MEMORY;
    for (size_t i = 0; items && i < ITEMS; i++)
        if (owner(NULL, team_deal(&m->team), i) == m->team.rank)
            memset(items + i * ITEM_BYTES, (int)(i % 251) + 1, ITEM_BYTES);
    if (items)
        m->status = team_share(&m->team, items, ITEM_BYTES, ITEMS, owner, NULL, &m->error);
    for (size_t i = 0; items && i < ITEMS; i++)
        for (size_t k = 0; k < ITEM_BYTES; k += ITEM_BYTES - 1)
            if (items[i * ITEM_BYTES + k] != (char)((int)(i % 251) + 1))
                m->status = FEWRAY_ERROR_FORMAT;
    free(items);
    return NULL;
}

static void test_unequal_shares_reach_all(void **state) {
    (void)state;
    static struct member members[SIZE];
    play(members, share);
    for (int r = 0; r < SIZE; r++)
        assert_int_equal(members[r].status, FEWRAY_OK);
}

/* Any rectangle of tiles is spread evenly, whatever the number of processes. */
static void test_tiles_are_dealt_out_evenly(void **state) {
    (void)state;
    for (int size = 2; size <= 64; size++) {
        const struct fewray_team team = {.size = size};
        const struct team_deal deal = team_deal(&team);
        int counts[64] = {0};
        for (int y = 0; y < size; y++)
            for (int x = 0; x < 40; x++)
                counts[team_owner(deal, x, y)]++;
        for (int r = 0; r < size; r++)
            assert_int_equal(counts[r], 40);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_team_makes_the_same_bits_as_one_process),
        cmocka_unit_test(test_all_end_with_the_first_failure_and_its_error),
        cmocka_unit_test(test_unequal_shares_reach_all),
        cmocka_unit_test(test_tiles_are_dealt_out_evenly),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
