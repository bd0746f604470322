/* SPDX-License-Identifier: Apache-2.0 */
/* Input files that can't be opened or read, or are removed or cut off by another program while the
 * command reads them. Bound of every case: exit code 1, one line that names the file, no output. */

#include "tests/stress/fault_command.h"

#include "fewray/features.h"

#define OPTIONS " -o out.exr --width 8 --spp 1 --guide off --denoise off --threads 2"
#define MESHES  "render scene.xml" OPTIONS
/* OpenImageIO, which is slow to load, reads the pictures of this scene. */
#define IMAGES "render images.xml" OPTIONS

/* Larger than what one read of a stream takes. */
enum { GRID = 40 };

static void write_meshes(void) {
    FILE *obj = fopen(in_folder("mesh.obj"), "w"), *ply = fopen(in_folder("mesh.ply"), "w");
    assert_true(obj && ply);
    fprintf(ply,
            "ply\nformat ascii 1.0\nelement vertex %d\nproperty float x\nproperty float y\n"
            "property float z\nelement face %d\nproperty list uchar int vertex_indices\n"
            "end_header\n",
            GRID * GRID, (GRID - 1) * (GRID - 1));
    for (int i = 0; i < GRID * GRID; i++) {
        fprintf(obj, "v %d %d 5\n", i % GRID, i / GRID);
        fprintf(ply, "%d %d 5\n", i % GRID, i / GRID);
    }
    for (int y = 0; y < GRID - 1; y++)
        for (int x = 0; x < GRID - 1; x++) {
            const int i = y * GRID + x;
            fprintf(obj, "f %d %d %d\n", i + 1, i + 2, i + GRID + 1);
            fprintf(ply, "3 %d %d %d\n", i, i + 1, i + GRID);
        }
    assert_false(fclose(obj) | fclose(ply));
}

/* Radiance HDR without compression: red, green, blue, exponent. */
static void write_hdr(const char *path) {
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    fputs("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 64 +X 128\n", file);
    for (int i = 0; i < 64 * 128; i++)
        fwrite((const char[]){(char)(i % 7 + 100), 50, 60, (char)129}, 1, 4, file);
    assert_false(fclose(file));
}

static void write_pictures(void) {
    static uint8_t rgb[64 * 64 * 3];
    struct fewray_frame *frame = NULL;
    for (size_t i = 0; i < sizeof rgb; i++)
        rgb[i] = (uint8_t)(i * i % 251);
    assert_false(fewray_image_write_png(in_folder("texture.png"), 64, 64, rgb, NULL));
    assert_false(fewray_frame_create(64, 64, &frame, NULL));
    for (int c = 0; c < 3; c++) {
        float *plane = fewray_frame_add(frame, (const char[]){"RGB"[c], 0});
        assert_non_null(plane);
        for (int i = 0; i < 64 * 64; i++)
            plane[i] = (float)(i * i % 251) / 100;
    }
    assert_false(fewray_frame_write_exr(frame, in_folder("sky.exr"), true, NULL));
    fewray_frame_destroy(&frame);
    write_hdr(in_folder("lamp.hdr"));
}

#define SENSOR                                                                                     \
    "<scene version='3.0.0'><sensor type='perspective'><film type='hdrfilm'>"                      \
    "<integer name='width' value='8'/><integer name='height' value='8'/></film></sensor>"
#define TEXTURED(file)                                                                             \
    "<shape type='rectangle'><bsdf type='diffuse'><texture type='bitmap' name='reflectance'>"      \
    "<string name='filename' value='" file "'/></texture></bsdf></shape>"

static void write_scenes(void) {
    write_text(in_folder("scene.xml"), SENSOR
               "<include filename='part.xml'/><emitter type='constant'/>"
               "<shape type='ply'><string name='filename' value='mesh.ply'/></shape></scene>");
    write_text(in_folder("part.xml"),
               "<scene version='3.0.0'>"
               "<shape type='obj'><string name='filename' value='mesh.obj'/></shape>"
               "<shape type='rectangle'><bsdf type='diffuse'>"
               "<spectrum name='reflectance' filename='grey.spd'/></bsdf></shape></scene>");
    write_text(
        in_folder("images.xml"), SENSOR
        "<emitter type='envmap'><string name='filename' value='sky.exr'/></emitter>" TEXTURED(
            "texture.png") TEXTURED("lamp.hdr") "</scene>");
    write_text(in_folder("grey.spd"), "360 0.5\n500 0.5\n830 0.5\n");
}

/* All files anew: cases damage them. */
static void write_all(void) {
    write_meshes();
    write_pictures();
    write_scenes();
    unlink(in_folder("out.exr"));
}

static int prepare(void **state) {
    if (make_folder(state))
        return -1;
    write_all();
    expect_success(MESHES);
    expect_success(IMAGES);
    return 0;
}

static void expect_file_fault(const char *arguments, const char *rule, const char *named,
                              const char *reason) {
    char what[256];
    snprintf(what, sizeof what, "%s: %s", arguments, rule);
    write_all();
    const struct outcome outcome = run_command(arguments, rule, NULL);
    expect_failure(what, &outcome, named, reason);
    assert_true(access(in_folder("out.exr"), F_OK));
}

static void test_file_of_a_scene_at_fault_is_named(void **state) {
    (void)state;
    static const char *const files[] = {"scene.xml", "part.xml", "mesh.obj", "mesh.ply",
                                        "grey.spd"};
    static const struct {
        const char *fault, *reason;
    } faults[] = {
        {"open 1 %s fail 13", "Permission denied"},
        {"open 1 %s remove", "No such file"},
        {"open 1 %s fail 24", "Too many open files"},
        {"read 1 %s fail 5", NULL}, /* EIO */
        /* The file gets shorter between the look at its size and the read: a mapped file would end
         * the process by SIGBUS. */
        {"read 1 %s halve", NULL},
    };
    if (!FAULT_PRELOADS)
        skip();
    for (size_t i = 0; i < sizeof files / sizeof *files; i++)
        for (size_t k = 0; k < sizeof faults / sizeof *faults; k++) {
            char rule[64];
            snprintf(rule, sizeof rule, faults[k].fault, files[i]);
            expect_file_fault(MESHES, rule, files[i], faults[k].reason);
        }
}

/* Images are opened twice: to check them, and by their library. */
static void test_image_at_fault_is_named(void **state) {
    (void)state;
    static const struct {
        const char *file, *rule, *reason;
    } cases[] = {
        {"texture.png", "open 1 texture.png fail 13", "Permission denied"},
        {"texture.png", "open 2 texture.png remove", "No such file"},
        {"texture.png", "read 2 texture.png fail 5", NULL},
        {"texture.png", "read 1 texture.png halve", NULL},
        {"sky.exr", "open 2 sky.exr remove", NULL},
        {"sky.exr", "read 3 sky.exr fail 5", NULL},
        {"lamp.hdr", "open 3 lamp.hdr remove", NULL},
        {"lamp.hdr", "read 2 lamp.hdr halve", NULL},
    };
    if (!FAULT_PRELOADS)
        skip();
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        expect_file_fault(IMAGES, cases[i].rule, cases[i].file, cases[i].reason);
}

/* The other commands' inputs. */
static void test_pictures_of_other_commands_are_named(void **state) {
    (void)state;
    static const char *const commands[] = {"denoise sky.exr -o out.exr", "compare sky.exr sky.exr",
                                           "info sky.exr", "composite sky.exr sky.exr -o out.png",
                                           "merge sky.exr -o out.exr"};
    static const char *const faults[] = {"open 1 sky fail 13", "open 1 sky remove",
                                         "open 2 sky remove", "read 1 sky halve",
                                         "read 2 sky fail 5"};
    if (!FAULT_PRELOADS)
        skip();
    for (int i = 0; i < 5; i++)
        for (int k = 0; k < 5; k++)
            /* info needs the header alone; OpenCV is slow to load, and all read by one function. */
            if ((i != 2 || k != 3) && ((i != 1 && i != 3) || k == 4))
                expect_file_fault(commands[i], faults[k], "sky.exr", NULL);
}

static void test_weights_are_named(void **state) {
    (void)state;
    if (!FAULT_PRELOADS)
        skip();
    expect_file_fault("denoise sky.exr -o out.exr --denoise-weights mesh.obj", "read 1 mesh fail 5",
                      "mesh.obj", NULL);
    expect_file_fault("denoise sky.exr -o out.exr --denoise-weights mesh.obj",
                      "open 1 mesh fail 13", "mesh.obj", NULL);
    expect_file_fault("denoise sky.exr -o out.exr --denoise-weights mesh.obj", "open 1 mesh remove",
                      "mesh.obj", NULL);
}

/* Without an argument, all but the slow ones; else those that match it. */
int main(int argc, char **argv) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_file_of_a_scene_at_fault_is_named),
        cmocka_unit_test(test_image_at_fault_is_named),
        cmocka_unit_test(test_pictures_of_other_commands_are_named),
        cmocka_unit_test(test_weights_are_named),
    };
    if (argc > 1)
        cmocka_set_test_filter(argv[1]);
    else
        cmocka_set_skip_filter("test_image_*");
    return cmocka_run_group_tests(tests, prepare, remove_folder);
}
