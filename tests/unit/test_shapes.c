/* SPDX-License-Identifier: Apache-2.0 */
/* Hits on shapes: where, with which normals, uv and tangents. */

#include "shape_stage.h"

/* --- against Mitsuba */

#define PLACE                                                                                      \
    "<rotate x='1' y='2' z='3' angle='40'/><translate x='1' y='0.5' z='0.25'/></transform>"
#define HALF   "<transform name='to_world'><scale value='0.5'/>" PLACE
#define MIRROR "<transform name='to_world'><scale x='0.5' y='0.5' z='-0.5'/>" PLACE
#define OVAL   "<transform name='to_world'><scale x='0.5' y='1' z='0.5'/>" PLACE
#define FLIP   "<boolean name='flip_normals' value='true'/>"
#define BALL   "<shape type='sphere'><float name='radius' value='1.5'/><point name='center' x='0.5'/>"
#define TUBE                                                                                       \
    "<shape type='cylinder'><point name='p0' value='0.1,0.2,-1'/>"                                 \
    "<point name='p1' value='0.4,1,1.5'/><float name='radius' value='0.7'/>"
#define INSTANCE(group)                                                                            \
    "<shape type='shapegroup' id='g'>" group "</shape>"                                            \
    "<shape type='instance'><ref id='g'/><transform name='to_world'>"                              \
    "<scale x='1' y='2' z='-0.5'/><rotate x='1' y='2' z='3' angle='40'/>"                          \
    "<translate x='0.2'/></transform></shape>"

struct measured {
    const char *shape;
    float origin[3], direction[3], distance, p[3], n[3], uv[2], dp_du[3], dp_dv[3];
};

/* By ray_intersect() of Mitsuba 3.9.1, scalar_rgb: t, p, sh_frame.n, uv, dp_du and dp_dv. */
static const struct measured measured[] = {
    {BALL "</shape>",
     {5, 1, 1},
     {-0.9701425f, -0.1455214f, -0.1940285f},
     3.242719f,
     {1.8541f, 0.528115f, 0.37082f},
     {0.9027334f, 0.3520767f, 0.2472133f},
     {0.05918433f, 0.4204852f},
     {-3.318245f, 8.508063f, 0},
     {1.085341f, 0.4232958f, -4.566122f}},
    {BALL "</shape>",
     {1, 0.5f, 0.25f},
     {0.3292928f, -0.5488213f, 0.7683498f},
     1.219321f,
     {1.401514f, -0.1691892f, 1.186865f},
     {0.6010091f, -0.1127928f, 0.7912433f},
     {0.9704744f, 0.2094342f},
     {1.063047f, 5.664377f, 0},
     {3.664668f, -0.6877568f, -2.881633f}},
    {BALL HALF "</shape>",
     {5, 1, 1},
     {-0.9701425f, -0.1455214f, -0.1940285f},
     3.185137f,
     {1.909963f, 0.5364944f, 0.3819926f},
     {0.9523657f, -0.1342737f, 0.2738072f},
     {0.8888777f, 0.2807955f},
     {0.487592f, 3.604918f, 0.07187575f},
     {0.6454465f, -0.04212799f, -2.265674f}},
    {BALL HALF "</shape>",
     {1, 0.5f, 0.25f},
     {0.3292928f, -0.5488213f, 0.7683498f},
     0.643068f,
     {1.211758f, 0.1470706f, 0.7441012f},
     {0.02142509f, -0.6535054f, 0.7566186f},
     {0.5881587f, 0.2307376f},
     {2.567234f, -1.311267f, -1.205261f},
     {-1.342114f, -1.484235f, -1.243957f}},
    {BALL MIRROR "</shape>",
     {5, 1, 1},
     {-0.9701425f, -0.1455214f, -0.1940285f},
     3.185137f,
     {1.909963f, 0.5364944f, 0.3819926f},
     {-0.9523657f, 0.1342737f, -0.2738072f},
     {0.8888777f, 0.7192045f},
     {0.4875917f, 3.604918f, 0.07187594f},
     {-0.6454467f, 0.04212774f, 2.265674f}},
    {BALL MIRROR "</shape>",
     {1, 0.5f, 0.25f},
     {0.3292928f, -0.5488213f, 0.7683498f},
     0.643068f,
     {1.211758f, 0.1470706f, 0.7441012f},
     {-0.02142509f, 0.6535054f, -0.7566186f},
     {0.5881587f, 0.7692625f},
     {2.567233f, -1.311266f, -1.205261f},
     {1.342114f, 1.484235f, 1.243957f}},
    {BALL HALF FLIP "</shape>",
     {5, 1, 1},
     {-0.9701425f, -0.1455214f, -0.1940285f},
     3.185137f,
     {1.909963f, 0.5364944f, 0.3819926f},
     {-0.9523657f, 0.1342737f, -0.2738072f},
     {0.8888777f, 0.2807955f},
     {0.487592f, 3.604918f, 0.07187575f},
     {0.6454465f, -0.04212799f, -2.265674f}},
    {"<shape type='sphere'><float name='radius' value='0.25'/><point name='center' "
     "value='2000,-1000,500'/></shape>",
     {2001, -1000.25f, 499.5f},
     {-0.8284821f, 0.2393393f, 0.5062946f},
     0.9113819f,
     {2000.245f, -1000.032f, 499.9614f},
     {0.9797794f, -0.1274153f, -0.1542652f},
     {0.9794175f, 0.5492404f},
     {0.2001935f, 1.539368f, 0},
     {-0.1201703f, 0.01562804f, -0.7761652f}},
    {TUBE "</shape>",
     {3, 1, 0.5f},
     {-0.9656091f, -0.2414023f, -0.09656091f},
     2.128549f,
     {0.9446537f, 0.4861634f, 0.2944654f},
     {0.978333f, -0.200035f, -0.05338875f},
     {0.9692953f, 0.532735f},
     {0.76142f, 4.098375f, -1.40285f},
     {0.3f, 0.8f, 2.5f}},
    {TUBE HALF "</shape>",
     {3, 1, 0.5f},
     {-0.9656091f, -0.2414023f, -0.09656091f},
     1.820769f,
     {1.241849f, 0.5604622f, 0.3241849f},
     {0.7417299f, -0.666392f, -0.07588463f},
     {0.7855289f, 0.451463f},
     {1.301558f, 1.547203f, -0.8649943f},
     {0.4167788f, 0.3260685f, 1.210361f}},
    {TUBE HALF "</shape>",
     {1.13f, 0.85f, 0.4f},
     {0.4866643f, -0.8111071f, 0.3244428f},
     0.320295f,
     {1.285876f, 0.5902066f, 0.5039174f},
     {0.69993f, -0.7125244f, -0.04906318f},
     {0.7747384f, 0.5922019f},
     {1.409072f, 1.444369f, -0.8743127f},
     {0.4167788f, 0.3260685f, 1.210361f}},
    {TUBE MIRROR "</shape>",
     {3, 1, 0.5f},
     {-0.9656091f, -0.2414023f, -0.09656091f},
     1.687054f,
     {1.370966f, 0.5927413f, 0.3370964f},
     {0.8203626f, -0.2134676f, -0.5305063f},
     {0.8672909f, 0.1831891f},
     {0.8299609f, 1.977192f, 0.4878404f},
     {-0.5675157f, 0.5048823f, -1.08075f}},
    {TUBE HALF FLIP "</shape>",
     {3, 1, 0.5f},
     {-0.9656091f, -0.2414023f, -0.09656091f},
     1.820769f,
     {1.241849f, 0.5604622f, 0.3241849f},
     {-0.7417299f, 0.666392f, 0.07588463f},
     {0.7855289f, 0.451463f},
     {1.301558f, 1.547203f, -0.8649943f},
     {0.4167788f, 0.3260685f, 1.210361f}},
    {"<shape type='disk'>" OVAL "</shape>",
     {1.1f, 0.8f, 3},
     {0.0198968f, -0.09948402f, -0.9948402f},
     2.830321f,
     {1.156314f, 0.5184283f, 0.1842833f},
     {0.3937178f, -0.07152553f, 0.9164445f},
     {0.3133371f, 0.9600301f},
     {0.4988693f, 0.05881301f, -0.2097313f},
     {-0.7276038f, 1.722565f, 0.4470298f}},
    {"<shape type='disk'>" OVAL FLIP "</shape>",
     {0.9f, 0.3f, -3},
     {-0.01997106f, 0.04992766f, 0.9985531f},
     3.323628f,
     {0.8336236f, 0.465941f, 0.3188195f},
     {-0.3937178f, 0.07152553f, -0.9164445f},
     {0.3455153f, 0.4672764f},
     {-0.4815313f, -0.09857477f, 0.1991794f},
     {0.850786f, -1.891684f, -0.5131499f}},
    {"<shape type='rectangle'>" OVAL "</shape>",
     {1.1f, 0.8f, 3},
     {0.0198968f, -0.09948402f, -0.9948402f},
     2.83032f,
     {1.156314f, 0.5184284f, 0.1842834f},
     {0.3937178f, -0.07152553f, 0.9164445f},
     {0.651754f, 0.4610668f},
     {0.7827557f, 0.548799f, -0.293451f},
     {-0.9639089f, 1.665778f, 0.5441177f}},
    {"<shape type='cube'>" OVAL "</shape>",
     {1.2f, 0.8f, 3},
     {0.0198968f, -0.09948402f, -0.9948402f},
     2.316666f,
     {1.246094f, 0.5695289f, 0.6952877f},
     {0.3937178f, -0.07152553f, 0.9164445f},
     {0.530224f, 0.6001189f},
     {-0.9639089f, 1.665778f, 0.5441177f},
     {0.7827556f, 0.5487989f, -0.2934511f}},
    {"<shape type='cube'>" OVAL "</shape>",
     {-3, 0.8f, 0},
     {1, 0, 0},
     3.366472f,
     {0.3664719f, 0.8f, -1.236053e-09f},
     {-0.3937178f, 0.07152553f, -0.9164445f},
     {0.2564082f, 0.2421048f},
     {0.9639089f, -1.665778f, -0.5441177f},
     {0.7827556f, 0.5487989f, -0.293451f}},
    {INSTANCE(BALL "</shape>"),
     {3, 1, 0.5f},
     {-0.9617558f, -0.2564682f, -0.09617558f},
     1.77001f,
     {1.297683f, 0.5460488f, 0.3297682f},
     {0.5403195f, 0.03974383f, 0.8405208f},
     {0.002191487f, 0.877718f},
     {-3.442489f, 5.856652f, 1.936036f},
     {-3.013812f, -2.560799f, 2.058483f}},
    {INSTANCE(BALL "</shape>"),
     {0.1f, 0.2f, 0.1f},
     {0.3292928f, -0.5488213f, 0.7683498f},
     0.7188029f,
     {0.3366966f, -0.1944943f, 0.6522921f},
     {0.1865853f, -0.2109564f, 0.9595225f},
     {0.5058017f, 0.8474637f},
     {4.309886f, -7.146973f, -2.409387f},
     {3.551818f, 2.469485f, -0.1477435f}},
    {INSTANCE(TUBE "</shape>"),
     {3, 1, 0.5f},
     {-0.9617558f, -0.2564682f, -0.09617558f},
     3.450427f,
     {-0.3184679f, 0.1150756f, 0.168153f},
     {-0.7507719f, -0.6118699f, -0.2489115f},
     {0.5790235f, 0.3782622f},
     {5.086567f, -4.986881f, -3.083545f},
     {-1.028448f, 1.586669f, -0.7982967f}},
    {INSTANCE("<shape type='cube'></shape>"),
     {3, 1, 0.5f},
     {-0.9617558f, -0.2564682f, -0.09617558f},
     2.205582f,
     {0.8787684f, 0.4343381f, 0.2878768f},
     {0.3937178f, -0.07152554f, 0.9164445f},
     {0.4717652f, 0.8425981f},
     {1.927818f, -3.331556f, -1.088235f},
     {1.565511f, 1.097598f, -0.5869021f}},
    {INSTANCE("<shape type='cube'></shape>"),
     {0.1f, 0.2f, 0.1f},
     {0.3292928f, -0.5488213f, 0.7683498f},
     0.5292146f,
     {0.2742664f, -0.09044413f, 0.506622f},
     {0.3937178f, -0.07152554f, 0.9164445f},
     {0.493323f, 0.429914f},
     {1.927818f, -3.331556f, -1.088235f},
     {1.565511f, 1.097598f, -0.5869021f}},
};

static void check_measured(const struct measured *m) {
    struct stage stage = stage_open(m->shape);
    struct surface s;
    /* Of a cylinder's or a disk's 512 segments. */
    bool round = strstr(m->shape, "cylinder") || strstr(m->shape, "disk");
    bool disk = strstr(m->shape, "'disk'");
    float fine = round ? 2e-4f : 5e-6f, size = length(vec(m->p[0], m->p[1], m->p[2]));
    struct vec3 dp_dv = vec(m->dp_dv[0], m->dp_dv[1], m->dp_dv[2]);
    struct vec3 moved = scene_origin(stage.scene);
    assert_true(surface_trace(stage.world,
                              sub(vec(m->origin[0], m->origin[1], m->origin[2]), moved),
                              vec(m->direction[0], m->direction[1], m->direction[2]), false, &s));
    s.position = add(s.position, moved);
    assert_near(s.distance, m->distance, fine * (1 + size));
    assert_close("position", s.position, m->p, fine * (1 + size));
    /* Where it lies on the sphere depends on the rounding of coordinates in the thousands. */
    float angle = size > 1000 ? 2e-3f : fine;
    assert_close("normal", s.normal, m->n, 4 * angle);
    assert_near(s.u, m->uv[0], angle);
    assert_near(s.v, m->uv[1], disk ? 1e-3 : angle);
    assert_close("dp_du", s.dp_du, m->dp_du, (round ? 0.02f : 8 * angle) * length(s.dp_du));
    /* A triangle's v is no angle: of a disk's dp_dv the direction is right, not the length. */
    if (disk)
        s.dp_dv = scale(normalize(s.dp_dv), length(dp_dv));
    assert_close("dp_dv", s.dp_dv, m->dp_dv, (round ? 0.02f : 8 * angle) * length(dp_dv));
    assert_true(fabsf(dot(s.geometric_normal, s.normal)) > 0.9999f);
    assert_near(fabsf(length(s.geometric_normal)), 1, 1e-5);
    stage_close(&stage);
}

static void test_hits_are_mitsubas(void **state) {
    (void)state;
    for (size_t i = 0; i < COUNT(measured); i++)
        check_measured(&measured[i]);
}

/* --- triangles' tangents */

static struct surface hit_triangle(const char *vertices, struct stage *stage) {
    char text[512];
    struct surface s;
    snprintf(text, sizeof(text), "%sf 1/1 2/2 3/3\n", vertices);
    scratch_text("triangle.obj", text);
    *stage = stage_open("<shape type='obj'><string name='filename' value='triangle.obj'/>"
                        "<boolean name='flip_tex_coords' value='false'/></shape>");
    assert_true(surface_trace(stage->world, vec(0.3f, 0.3f, 2), vec(0, 0, -1), false, &s));
    return s;
}

#define CORNERS "v 0 0 0\nv 1 0.2 0.1\nv 0.1 1 0.3\n"

static void test_tangents_follow_uv(void **state) {
    struct stage stage;
    (void)state;
    struct surface s = hit_triangle(CORNERS "vt 0 0\nvt 2 0.5\nvt 0.3 1\n", &stage);
    assert_close("dp_du", s.dp_du, (float[]){0.5135135f, -0.1621622f, -0.02702703f}, 1e-6f);
    assert_close("dp_dv", s.dp_dv, (float[]){-0.05405406f, 1.048649f, 0.3081081f}, 1e-6f);
    stage_close(&stage);
    /* Degenerate uv: any basis, but one. */
    s = hit_triangle(CORNERS "vt 0 0\nvt 1 1\nvt 2 2\n", &stage);
    assert_close("dp_du", s.dp_du, (float[]){0.9992189f, -0.005662861f, 0.0391087f}, 1e-6f);
    assert_close("dp_dv", s.dp_dv, (float[]){-0.005662861f, 0.9589443f, 0.2835381f}, 1e-6f);
    stage_close(&stage);
    s = hit_triangle(CORNERS "vt 0 0\nvt 1e-30 0\nvt 0 1e-30\n", &stage);
    assert_near(length(s.dp_du), 1, 1e-5);
    stage_close(&stage);
}

static void test_no_tangents_where_no_material_needs_them(void **state) {
    struct stage stage = stage_open("<shape type='cube'/>");
    struct surface s;
    (void)state;
    stage.scene->bsdfs[stage.scene->meshes[0].bsdf].tangents = false;
    assert_true(surface_trace(stage.world, vec(0, 0, 5), vec(0, 0, -1), false, &s));
    assert_near(length(s.dp_du) + length(s.dp_dv), 0, 0);
    stage_close(&stage);
}

/* Embree's own checks would end the program. */
static void test_rays_from_beyond_meet_nothing(void **state) {
    struct stage stage = stage_open("<shape type='sphere'/><shape type='rectangle'/>");
    struct vec3 beyond[] = {{1e25f, 0, 0}, {0, -INFINITY, 0}, {0, 0, NAN}};
    struct surface s;
    (void)state;
    for (size_t i = 0; i < COUNT(beyond); i++) {
        assert_false(surface_trace(stage.world, beyond[i], vec(0, 0, 1), false, &s));
        assert_false(surface_trace(stage.world, vec(0, 0, 3), beyond[i], false, &s));
        assert_true(surface_blocked(stage.world, beyond[i], vec(0, 0, 1), vec(0, 0, 3)));
    }
    stage_close(&stage);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_hits_are_mitsubas),
        cmocka_unit_test(test_tangents_follow_uv),
        cmocka_unit_test(test_no_tangents_where_no_material_needs_them),
        cmocka_unit_test(test_rays_from_beyond_meet_nothing),
    };
    return cmocka_run_group_tests(tests, scratch_create, scratch_remove);
}
