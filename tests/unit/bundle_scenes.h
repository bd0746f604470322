/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_TESTS_BUNDLE_SCENES_H
#define FEWRAY_TESTS_BUNDLE_SCENES_H

/* Small scenes of all that a bundle of paths can meet: what it shades itself, what sends a path on
 * alone, and every kind of light. */

#include "scene_scratch.h"

/* A camera in the room's front wall; `lens` comes with a thin lens. */
#define CAMERA(type, lens)                                                                         \
    "<sensor type='" type "'>" lens "<float name='fov' value='75'/><transform name='to_world'>"    \
    "<lookat origin='0.1,0.2,0.95' target='0,-0.2,-1' up='0,1,0'/></transform>"                    \
    "<film type='hdrfilm'><integer name='width' value='24'/><integer name='height' value='18'/>"   \
    "</film></sensor>"
#define PINHOLE CAMERA("perspective", "")

#define RGB(name, value) "<rgb name='" name "' value='" value "'/>"
#define DIFFUSE(color)   "<bsdf type='diffuse'>" RGB("reflectance", color) "</bsdf>"
#define SHAPE(type, at, of)                                                                        \
    "<shape type='" type "'><transform name='to_world'>" at "</transform>" of "</shape>"
#define GLOW(color) "<emitter type='area'>" RGB("radiance", color) "</emitter>"

/* Walls whose fronts look inwards. */
#define ROOM                                                                                       \
    "<shape type='cube'><boolean name='flip_normals' value='true'/>" DIFFUSE(                      \
        "0.8 0.6 0.4") "</shape>"
#define FLOOR                                                                                      \
    SHAPE("rectangle", "<scale value='3'/><rotate x='1' angle='-90'/><translate y='-1'/>",         \
          DIFFUSE("0.7 0.7 0.6"))
#define UNDER_CEILING    "<scale value='0.4'/><rotate x='1' angle='90'/><translate y='0.98'/>"
#define LAMP_OF(emitter) SHAPE("rectangle", UNDER_CEILING, emitter DIFFUSE("0.5"))
#define LAMP             LAMP_OF(GLOW("9 7 5"))
/* Triangles without vertex normals, and with some. */
#define BLOCK_OF(bsdf)                                                                             \
    SHAPE("cube",                                                                                  \
          "<scale value='0.25'/><rotate y='1' angle='30'/><translate x='-0.45' y='-0.75' "         \
          "z='-0.4'/>",                                                                            \
          bsdf)
#define BLOCK BLOCK_OF(DIFFUSE("0.3 0.5 0.8"))
#define TUBE_OF(bsdf)                                                                              \
    "<shape type='cylinder'><point name='p0' x='0.4' y='-1' z='-0.4'/><point name='p1' x='0.4' "   \
    "y='0.1' z='-0.5'/><float name='radius' value='0.25'/>" bsdf "</shape>"
#define TUBE                                                                                       \
    TUBE_OF("<bsdf type='twosided'>" DIFFUSE("0.8 0.8 0.1") DIFFUSE("0.1 0.2 0.9") "</bsdf>")
#define BALL_OF(bsdf)                                                                              \
    "<shape type='sphere'><point name='center' x='0' y='-0.4' z='-0.3'/><float name='radius' "     \
    "value='0.3'/>" bsdf "</shape>"
#define THINGS BLOCK TUBE
/* A plate in the air whose back looks at the camera. */
#define PLATE_OF(bsdf)                                                                             \
    SHAPE("rectangle",                                                                             \
          "<scale value='0.5'/><rotate y='1' angle='160'/><translate y='0.1' "                     \
          "z='-0.6'/>",                                                                            \
          bsdf)
#define CHECKS(name, bright)                                                                       \
    "<texture type='checkerboard' name='" name "'>" RGB("color0", "0 0 0")                         \
        RGB("color1", bright) "<transform name='to_uv'><scale x='6' y='4'/></transform></texture>"
#define PICTURE(name)                                                                              \
    "<texture type='bitmap' name='" name "'><string name='filename' "                              \
    "value='picture.hdr'/></texture>"
#define SKY_MAP                                                                                    \
    "<emitter type='envmap'><string name='filename' value='picture.hdr'/><float name='scale' "     \
    "value='2'/><transform name='to_world'><rotate y='1' angle='70'/></transform></emitter>"
#define SKY "<emitter type='constant'>" RGB("radiance", "0.5 0.6 0.9") "</emitter>"
#define SUN                                                                                        \
    "<emitter type='sunsky'><vector name='sun_direction' x='1' y='2' z='1'/><float "               \
    "name='sun_aperture' value='6'/></emitter>"
#define BULB                                                                                       \
    "<emitter type='point'><point name='position' x='0.3' y='0.8' z='0.4'/>" RGB(                  \
        "intensity", "1 2 3") "</emitter>"
#define SPOT                                                                                       \
    "<emitter type='spot'><transform name='to_world'><lookat origin='-0.6,0.8,0.6' "               \
    "target='0,-1,-0.4' up='0,0,1'/></transform>" RGB(                                             \
        "intensity", "9 6 3") "<float "                                                            \
                              "name='cutoff_angle' value='35'/></emitter>"
#define BEAM                                                                                       \
    "<emitter type='directional'><vector name='direction' x='-1' y='-2' z='-1.5'/>" RGB(           \
        "irradiance", "1 2 1.5") "</emitter>"
/* Six shining triangles each; three of them are too many for a table. */
#define CRUMBS(x, y, z, color)                                                                     \
    SHAPE("cube", "<scale value='0.06'/><translate x='" x "' y='" y "' z='" z "'/>",               \
          GLOW(color) DIFFUSE("0.5"))
#define GROUP "<shape type='shapegroup' id='g'>" BLOCK TUBE "</shape>"
#define PLACED                                                                                     \
    "<shape type='instance'><ref id='g'/><transform name='to_world'><scale value='0.7'/>"          \
    "<rotate y='1' angle='25'/><translate x='0.2' y='-0.3'/></transform></shape>"
#define MIRROR "<bsdf type='conductor'/>"
#define GLASS  "<bsdf type='dielectric'/>"

static const struct bundle_scene {
    const char *name, *text;
    int max_depth, rr_depth;
} bundle_scenes[] = {
    {"closed box", PINHOLE ROOM LAMP THINGS, -1, 5},
    {"closed box, depth 1", PINHOLE ROOM LAMP THINGS, 1, 5},
    {"closed box, depth 2", PINHOLE ROOM LAMP THINGS, 2, 5},
    {"closed box, depth 3", PINHOLE ROOM LAMP THINGS, 3, 5},
    {"closed box, depth 8", PINHOLE ROOM LAMP THINGS, 8, 5},
    {"closed box, early roulette", PINHOLE ROOM LAMP THINGS, -1, 2},
    {"closed box, roulette at once", PINHOLE ROOM LAMP THINGS, 8, 1},
    {"checkerboard",
     PINHOLE ROOM LAMP BLOCK_OF(
         "<bsdf type='diffuse'>" CHECKS("reflectance", "1 0.7 0.4") "</bsdf>"),
     6, 5},
    {"bitmap", PINHOLE ROOM LAMP TUBE_OF("<bsdf type='diffuse'>" PICTURE("reflectance") "</bsdf>"),
     6, 5},
    {"one-sided plate from behind", PINHOLE ROOM LAMP PLATE_OF(DIFFUSE("0.9")), 6, 5},
    {"plate of two sides",
     PINHOLE ROOM LAMP PLATE_OF("<bsdf type='twosided'>" DIFFUSE("0.9 0.1 0.2")
                                    DIFFUSE("0.2 0.9 0.3") "</bsdf>"),
     6, 5},
    {"plate with a mirror behind",
     PINHOLE ROOM LAMP PLATE_OF("<bsdf type='twosided'>" DIFFUSE("0.9 0.1 0.2") MIRROR "</bsdf>"),
     6, 5},
    {"black block", PINHOLE ROOM LAMP BLOCK_OF(DIFFUSE("0")), 6, 5},
    {"even sky", PINHOLE FLOOR THINGS SKY, 6, 5},
    {"even sky, depth 2", PINHOLE FLOOR THINGS SKY, 2, 5},
    {"sky and lamp", PINHOLE FLOOR THINGS SKY LAMP, 4, 2},
    {"sky map", PINHOLE FLOOR THINGS SKY_MAP, 6, 5},
    {"sky map, bulb and crumbs",
     PINHOLE FLOOR THINGS SKY_MAP BULB CRUMBS("0", "-0.5", "0.1", "30 20 10"), 3, 5},
    {"sun and sky", PINHOLE FLOOR THINGS SUN, 6, 5},
    {"sun, sky and lamp", PINHOLE FLOOR THINGS SUN LAMP_OF(GLOW("90 70 50")), 2, 5},
    {"bulb", PINHOLE ROOM THINGS BULB, 6, 5},
    {"spot", PINHOLE ROOM THINGS SPOT, 6, 5},
    {"beam", PINHOLE FLOOR THINGS BEAM, 6, 5},
    {"beam and even sky", PINHOLE FLOOR THINGS BEAM SKY, 6, 5},
    {"no light", PINHOLE ROOM THINGS, 4, 5},
    {"shining ball", PINHOLE ROOM THINGS BALL_OF(GLOW("3 2 1")), 6, 5},
    {"shining tube", PINHOLE ROOM BLOCK TUBE_OF(GLOW("3 2 1")), 6, 5},
    {"shining sheet with bent normals",
     PINHOLE ROOM TUBE SHAPE("obj", "<translate x='-0.2' z='-0.7'/>",
                             "<string name='filename' value='bent.obj'/>" GLOW("9 7 5")),
     6, 5},
    {"sheet with bent normals",
     PINHOLE ROOM LAMP TUBE SHAPE("obj", "<translate x='-0.2' z='-0.7'/>",
                                  "<string name='filename' value='bent.obj'/>" DIFFUSE("0.7")),
     6, 5},
    {"lamp with dark checks",
     PINHOLE ROOM THINGS LAMP_OF("<emitter type='area'>" CHECKS("radiance", "9 7 5") "</emitter>"),
     6, 5},
    {"red block under a green lamp",
     PINHOLE ROOM LAMP_OF(GLOW("0 9 0")) BLOCK_OF(DIFFUSE("0.9 0 0")), 6, 5},
    {"light tree",
     PINHOLE ROOM THINGS BULB SPOT CRUMBS("-0.5", "0.5", "0", "30 20 10")
         CRUMBS("0.6", "-0.8", "0.3", "10 20 30") CRUMBS("0", "0.9", "-0.8", "50 50 50"),
     6, 5},
    {"light tree and sky",
     PINHOLE FLOOR THINGS SKY_MAP CRUMBS("-0.5", "0.5", "0", "30 20 10")
         CRUMBS("0.6", "-0.8", "0.3", "10 20 30"),
     3, 2},
    {"ball", PINHOLE ROOM LAMP THINGS BALL_OF(DIFFUSE("0.6")), 6, 5},
    {"mirror", PINHOLE ROOM LAMP THINGS BALL_OF(MIRROR), 6, 5},
    {"mirror block, early roulette", PINHOLE ROOM LAMP TUBE BLOCK_OF(MIRROR), -1, 2},
    {"glass", PINHOLE ROOM LAMP THINGS BALL_OF(GLASS), 8, 5},
    {"plastic", PINHOLE ROOM LAMP TUBE BLOCK_OF("<bsdf type='plastic'/>"), 6, 5},
    {"rough metal", PINHOLE ROOM LAMP BLOCK TUBE_OF("<bsdf type='roughconductor'/>"), 2, 5},
    {"mask",
     PINHOLE ROOM LAMP THINGS PLATE_OF(
         "<bsdf type='mask'><float name='opacity' value='0.5'/><bsdf type='twosided'>" DIFFUSE(
             "0.9") "</bsdf></bsdf>"),
     6, 5},
    {"instances", PINHOLE ROOM LAMP GROUP PLACED BALL_OF(DIFFUSE("0.5")), 6, 5},
    {"thin lens",
     CAMERA(
         "thinlens",
         "<float name='aperture_radius' value='0.05'/><float name='focus_distance' value='1.4'/>")
         ROOM LAMP THINGS,
     4, 5},
    {"thin lens and glass",
     CAMERA(
         "thinlens",
         "<float name='aperture_radius' value='0.05'/><float name='focus_distance' value='1.4'/>")
         ROOM LAMP BLOCK BALL_OF(GLASS),
     6, 5},
};

static const struct bundle_scene guided_scenes[] = {
    {"guided, closed box", PINHOLE ROOM LAMP THINGS, -1, 2},
    {"guided, closed box, depth 2", PINHOLE ROOM LAMP THINGS, 2, 5},
    {"guided, closed box, depth 3", PINHOLE ROOM LAMP THINGS, 3, 5},
    {"guided, dark checks and a mirror",
     PINHOLE ROOM TUBE LAMP_OF("<emitter type='area'>" CHECKS("radiance", "9 7 5") "</emitter>")
         BLOCK_OF(MIRROR),
     6, 5},
    {"guided, sky map and plastic", PINHOLE FLOOR BLOCK SKY_MAP TUBE_OF("<bsdf type='plastic'/>"),
     6, 5},
    {"guided, light tree",
     PINHOLE ROOM THINGS SPOT CRUMBS("-0.5", "0.5", "0", "30 20 10")
         CRUMBS("0.6", "-0.8", "0.3", "10 20 30"),
     4, 5},
};

/* A Radiance picture of 16 x 8 pixels without run lengths, some of them black. */
static inline void write_picture(void) {
    static const char header[] = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 8 +X 16\n";
    uint8_t bytes[sizeof(header) - 1 + 16 * 8 * 4];
    memcpy(bytes, header, sizeof(header) - 1);
    for (int i = 0; i < 16 * 8; i++) {
        uint8_t *pixel = bytes + sizeof(header) - 1 + 4 * i;
        bool dark = i % 5 == 0;
        pixel[0] = dark ? 0 : (uint8_t)(40 + 37 * i % 200);
        pixel[1] = dark ? 0 : (uint8_t)(30 + 53 * i % 200);
        pixel[2] = dark ? 0 : (uint8_t)(50 + 71 * i % 200);
        pixel[3] = dark ? 0 : (uint8_t)(128 + (i == 37 ? 4 : 0));
    }
    scratch_write("picture.hdr", bytes, sizeof(bytes));
}

/* A square whose corners have normals far from its own. */
static inline void write_sheet(void) {
    scratch_text("bent.obj", "v -0.6 -0.6 0\nv 0.6 -0.6 0\nv 0.6 0.6 0\nv -0.6 0.6 0\n"
                             "vn -0.9 0 0.4\nvn 0.9 0 0.4\nvn 0.7 0.7 0.1\nvn -0.9 0.4 0.2\n"
                             "f 1//1 2//2 3//3\nf 1//1 3//3 4//4\n");
}

/* The body is a scene's all but the root element. */
static inline struct fewray_scene *load_bundle_scene(const char *body) {
    static char text[16384];
    struct fewray_scene *scene = NULL;
    struct fewray_error error = {.line = 0};
    assert_true(snprintf(text, sizeof(text), "<scene version='3.0.0'>%s</scene>", body) <
                (int)sizeof(text));
    write_picture();
    write_sheet();
    if (fewray_scene_load(scratch_text("scene.xml", text), NULL, &scene, &error))
        fail_msg("line %d: %s\n%s", error.line, error.what, text);
    return scene;
}

#endif
