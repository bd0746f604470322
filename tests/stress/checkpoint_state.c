/* SPDX-License-Identifier: Apache-2.0 */
/* A state whose numbers are wrong although its checksum is right: reading it ends with
 * FEWRAY_ERROR_FORMAT, or takes what can do no harm; it never reads beyond its bytes nor allocates
 * more than they could fill. */

#include "scene_scratch.h"

#include "fewray/guide.h"

#define SCENE EXAMPLES "/cornell-box.xml"

/* The state of a guided render in memory. */
struct memory {
    unsigned char *bytes;
    size_t size, room, at;
    const struct fewray_film *film;
    struct fewray_maps *maps;
    struct fewray_render_settings *settings;
    struct fewray_render_stats stats;
};

static bool put(void *user, const void *bytes, size_t size) {
    struct memory *m = user;
    if (m->size + size > m->room) {
        m->room = 2 * (m->size + size);
        m->bytes = realloc(m->bytes, m->room);
        assert_non_null(m->bytes);
    }
    if (size > 0)
        memcpy(m->bytes + m->size, bytes, size);
    m->size += size;
    return true;
}

/* False beyond the end, which stream_move() must have noticed before. */
static bool get(void *user, void *bytes, size_t size) {
    struct memory *m = user;
    assert_true(size <= m->size - m->at);
    if (size > 0)
        memcpy(bytes, m->bytes + m->at, size);
    m->at += size;
    return true;
}

static bool always(void *user) {
    (void)user;
    return true;
}

/* The state in the middle of the pass from 4 to 16 samples: with maps, sums, probes and records. */
static void take_state(void *user, bool whole_pass) {
    struct memory *m = user;
    (void)whole_pass;
    if (fewray_state_samples(m->settings->state) > 4.1 && m->size == 0)
        assert_true(fewray_state_write(m->settings->state, m->settings, m->film, m->maps, &m->stats,
                                       put, m));
}

static struct {
    struct fewray_scene *scene;
    struct fewray_world *world;
    struct fewray_render_settings settings;
    struct memory memory;
} stage;

static int set_up(void **state) {
    (void)state;
    struct fewray_film *film = NULL;
    struct fewray_look *look = NULL;
    struct fewray_state *place = NULL;
    struct fewray_render_settings *s = &stage.settings;
    struct memory *m = &stage.memory;
    fewray_render_settings_init(s);
    s->width = 40;
    s->height = 20;
    s->spp = 20;
    s->threads = 1;
    int status = fewray_scene_load(SCENE, NULL, &stage.scene, NULL);
    status = status ? status : fewray_world_create(stage.scene, 1, &stage.world, NULL);
    status = status ? status : fewray_film_create(stage.world, s, &film, NULL);
    status = status ? status : fewray_state_create(&place, NULL);
    s->state = place;
    s->pause_due = always;
    s->paused = take_state;
    s->pause_user = m;
    m->film = film;
    m->settings = s;
    status = status ? status : fewray_trace_look(stage.world, s, film, &look, &m->stats, NULL);
    status = status ? status : fewray_maps_create(look, s, &m->maps, &m->stats, NULL);
    fewray_state_has_maps(place);
    fewray_look_destroy(&look);
    status = status ? status : fewray_trace_rest(stage.world, m->maps, s, film, &m->stats, NULL);
    fewray_maps_destroy(&m->maps);
    fewray_film_destroy(&film);
    fewray_state_destroy(&place);
    s->state = NULL;
    return status || m->size == 0 ? -1 : 0;
}

static int tear_down(void **state) {
    (void)state;
    free(stage.memory.bytes);
    fewray_world_destroy(&stage.world);
    fewray_scene_destroy(&stage.scene);
    return 0;
}

/* Reads the first `size` bytes. */
static int read_state(size_t size) {
    struct fewray_film *film = NULL;
    struct fewray_maps *maps = NULL;
    struct fewray_state *place = NULL;
    struct fewray_render_stats stats = {0};
    struct memory *m = &stage.memory;
    m->at = 0;
    assert_int_equal(fewray_film_create(stage.world, &stage.settings, &film, NULL), FEWRAY_OK);
    assert_int_equal(fewray_state_create(&place, NULL), FEWRAY_OK);
    const int status =
        fewray_state_read(place, &stage.settings, film, &maps, &stats, get, m, size, NULL);
    assert_true(status == FEWRAY_OK || !maps);
    fewray_maps_destroy(&maps);
    fewray_state_destroy(&place);
    fewray_film_destroy(&film);
    return status;
}

static void test_a_state_is_read_as_it_was_written(void **state) {
    (void)state;
    assert_int_equal(read_state(stage.memory.size), FEWRAY_OK);
    assert_int_equal(stage.memory.at, stage.memory.size);
}

static void test_a_state_that_ends_early_is_refused(void **state) {
    (void)state;
    const size_t size = stage.memory.size;
    for (size_t k = 0; k < 150; k++)
        assert_int_equal(read_state(k * (size - 1) / 149), FEWRAY_ERROR_FORMAT);
}

/* The words of the head and, evenly, of all that follows; of each kind of array some. */
static void test_numbers_that_cannot_be_are_refused_or_harmless(void **state) {
    (void)state;
    static const int32_t bad[] = {-1, INT32_MAX, INT32_MIN, 1 << 24};
    struct memory *m = &stage.memory;
    const size_t words = m->size / 4, head = 64, others = 500;
    int refused = 0;
    for (size_t k = 0; k < head + others; k++) {
        const size_t word = k < head ? k : head + (k - head) * (words - head - 1) / others;
        int32_t before;
        memcpy(&before, m->bytes + 4 * word, 4);
        memcpy(m->bytes + 4 * word, &bad[k % 4], 4);
        const int status = read_state(m->size);
        if (status != FEWRAY_OK && status != FEWRAY_ERROR_FORMAT &&
            status != FEWRAY_ERROR_ARGUMENT) /* another spp */
            fail_msg("word %zu = %d: status %d", word, (int)bad[k % 4], status);
        refused += status != FEWRAY_OK;
        memcpy(m->bytes + 4 * word, &before, 4);
    }
    assert_true(refused >= 8); /* of the head's 13 numbers alone, all but flags */
    assert_int_equal(read_state(m->size), FEWRAY_OK);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_state_is_read_as_it_was_written),
        cmocka_unit_test(test_a_state_that_ends_early_is_refused),
        cmocka_unit_test(test_numbers_that_cannot_be_are_refused_or_harmless),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
