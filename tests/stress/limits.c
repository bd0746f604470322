/* SPDX-License-Identifier: Apache-2.0 */
/* Files made to hang the command or to eat its memory, and scenes that would write somewhere. Each
 * is given to the built command. The bounds of every case: it ends by itself with the exit code and
 * one line on stderr; it takes at most MEMORY_MOST, where what the file announces is more than
 * twice that; and at most CPU_MOST, which stands for "hangs", for each takes well below a second.
 */

#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>
#include <zlib.h>

#include "fewray/denoise.h"
#include "pipeline/stats.h"
#include "tests/unit/sanitized.h"
#include "tests/unit/scratch_folder.h"

enum { MEMORY_MOST = 512 }; /* MiB resident */
enum { CPU_MOST = 30 };     /* s of one process */

#define SENSOR "<sensor type='perspective'><film type='hdrfilm'/></sensor>"
#define SHAPE(type, file)                                                                          \
    "<scene version='3.0.0'>" SENSOR "<shape type='" type "'><string name='filename' value='" file \
    "'/></shape></scene>"
#define TEXTURE(file)                                                                              \
    "<scene version='3.0.0'>" SENSOR "<shape type='rectangle'><bsdf type='diffuse'>"               \
    "<texture type='bitmap' name='reflectance'><string name='filename' value='" file               \
    "'/></texture></bsdf></shape></scene>"
#define FILM(size)                                                                                 \
    "<scene version='3.0.0'><sensor type='perspective'><film type='hdrfilm'>"                      \
    "<integer name='width' value='" size "'/><integer name='height' value='" size                  \
    "'/></film></sensor></scene>"

static const char *path_of(const char *name) {
    static char path[256];
    snprintf(path, sizeof(path), "%s/%s", folder, name);
    return path;
}

static void write_file(const char *name, const void *data, size_t size) {
    FILE *file = fopen(path_of(name), "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(data, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
}

static FILE *open_new(const char *name) {
    FILE *file = fopen(path_of(name), "wb");
    assert_non_null(file);
    return file;
}

/* The command in the folder, its memory bounded by the system where mebibytes isn't 0. Returns the
 * exit code. */
static int run(char *const arguments[], long mebibytes, char *messages, size_t size) {
    int ends[2], status;
    assert_int_equal(pipe(ends), 0);
    const pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        const struct rlimit cpu = {CPU_MOST, CPU_MOST}, none = {0, 0};
        const struct rlimit memory = {(rlim_t)mebibytes << 20, (rlim_t)mebibytes << 20};
        setrlimit(RLIMIT_CPU, &cpu);
        setrlimit(RLIMIT_CORE, &none);
        if (mebibytes)
            setrlimit(RLIMIT_AS, &memory);
        dup2(ends[1], STDERR_FILENO);
        dup2(open("/dev/null", O_RDWR), STDOUT_FILENO);
        if (!chdir(folder))
            execv(FEWRAY_COMMAND, arguments);
        _exit(127);
    }
    close(ends[1]);
    size_t length = 0;
    for (ssize_t got;
         length < size - 1 && (got = read(ends[0], messages + length, size - 1 - length)) > 0;)
        length += (size_t)got;
    messages[length] = 0;
    close(ends[0]);
    struct rusage usage;
    assert_int_equal(wait4(child, &status, 0, &usage), child);
    if (!WIFEXITED(status))
        fail_msg("%s %s: ended by signal %d", arguments[1], arguments[2], WTERMSIG(status));
    if (!SANITIZED && usage.ru_maxrss > MEMORY_MOST * 1024L)
        fail_msg("%s %s: took %ld MiB", arguments[1], arguments[2], usage.ru_maxrss >> 10);
    return WEXITSTATUS(status);
}

static void expect_line(const char *name, int got, int expected, const char *messages,
                        const char *what) {
    const char *end = strchr(messages, '\n');
    if (got != expected)
        fail_msg("%s: exit code %d: %s", name, got, messages);
    if (strncmp(messages, "fewray: ", 8) || !end || end[1])
        fail_msg("%s: not one line: %s", name, messages);
    if (!strstr(messages, what))
        fail_msg("%s: '%s' lacks '%s'", name, messages, what);
}

/* --- scenes and pictures that are refused */

static const struct refused {
    const char *name; /* of the file, by whose ending it is read */
    const char *text; /* NULL: made by make_files() */
    const char *what; /* in the line */
} refused[] = {
    {"laughs.xml",
     "<!DOCTYPE s [<!ENTITY a 'ha'><!ENTITY b '&a;&a;&a;&a;&a;&a;&a;&a;'>]><scene>&b;</scene>",
     "entities are not allowed"},
    {"external.xml", "<!DOCTYPE s [<!ENTITY a SYSTEM 'file:///etc/passwd'>]><scene>&a;</scene>",
     "entities are not allowed"},
    {"parameter.xml", "<!DOCTYPE s [<!ENTITY % a SYSTEM 'pipe'> %a;]><scene/>",
     "entities are not allowed"},
    {"doubling.xml", NULL, "longer than 16 MiB together"},
    {"deep.xml", NULL, "nested deeper than 64"},
    {"self.xml", "<scene version='3.0.0'><include filename='self.xml'/></scene>",
     "includes itself"},
    {"level0.xml", NULL, "more than 1000 files are included"},
    {"includes-pipe.xml", "<scene version='3.0.0'><include filename='pipe'/></scene>",
     "isn't a regular file"},
    {"includes-zero.xml", "<scene version='3.0.0'><include filename='/dev/zero'/></scene>",
     "isn't a regular file"},
    {"film.xml", FILM("1000000"), "at most 65536 a side"},
    {"obj-pipe.xml", SHAPE("obj", "pipe"), "can't read the file"},
    {"ply-zero.xml", SHAPE("ply", "/dev/zero"), "can't read the file"},
    {"ply-folder.xml", SHAPE("ply", "/"), "Is a directory"},
    {"serialized-pipe.xml", SHAPE("serialized", "pipe"), "can't read the file"},
    {"texture-pipe.xml", TEXTURE("pipe"), "isn't a regular file"},
    {"texture-zero.xml", TEXTURE("/dev/zero"), "isn't a regular file"},
    {"spectrum-pipe.xml",
     "<scene version='3.0.0'>" SENSOR "<shape type='rectangle'><bsdf type='diffuse'>"
     "<spectrum name='reflectance' filename='pipe'/></bsdf></shape></scene>",
     "can't read the file"},
    {"ply-count.xml", SHAPE("ply", "count.ply"), "truncated within the vertices"},
    {"serialized-name.xml", SHAPE("serialized", "name.serialized"), "name is endless"},
    {"serialized-count.xml", SHAPE("serialized", "count.serialized"), "truncated"},
    {"hdr.xml", TEXTURE("large.hdr"), "the file can't hold 16384 x 16384 pixels"},
    {"ppm.xml", TEXTURE("large.ppm"), "the file can't hold 16384 x 16384 pixels"},
    {"exr.xml", TEXTURE("large.exr"), "large.exr"},
    {"large.exr", NULL, "damaged"},
    {"pipe.gltf",
     "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{}],"
     "\"buffers\":[{\"byteLength\":8,\"uri\":\"pipe\"}]}",
     "isn't a regular file"},
    {"accessor.gltf",
     "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{}],"
     "\"buffers\":[{\"byteLength\":8,\"uri\":\"data:;base64,AAAAAAAAAAA=\"}],"
     "\"bufferViews\":[{\"buffer\":0,\"byteLength\":8}],\"accessors\":[{\"bufferView\":0,"
     "\"componentType\":5126,\"type\":\"VEC3\",\"count\":4000000000}]}",
     "accessor 0 lies beyond its bufferView"},
    {"deep.gltf", NULL, "not a glTF file"},
    {"pipe.obj", "mtllib pipe\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "isn't a regular file"},
    {"pipe", NULL, "isn't a regular file"},
    {"/dev/zero", NULL, "isn't a regular file"},
    {"/", NULL, "isn't a regular file"},
};

/* Version 4 of the format: a mesh of these bytes. */
static void write_serialized(const char *name, const void *mesh, size_t size) {
    uLongf packed = compressBound(size);
    unsigned char *file = calloc(1, 4 + packed + 12);
    assert_non_null(file);
    assert_int_equal(compress2(file + 4, &packed, mesh, size, 9), Z_OK);
    memcpy(file, "\x1c\x04\x04", 3);
    file[4 + packed + 8] = 1;
    write_file(name, file, 4 + packed + 12);
    free(file);
}

static void write_repeated(FILE *file, const char *text, int count) {
    for (int i = 0; i < count; i++)
        fputs(text, file);
}

static void make_xml_files(void) {
    FILE *file = open_new("doubling.xml");
    fputs("<scene version='3.0.0'><default name='a0' value='0123456789'/>", file);
    for (int i = 0; i < 40; i++) /* 10 TiB */
        fprintf(file, "<default name='a%d' value='$a%d$a%d'/>", i + 1, i, i);
    fputs("</scene>", file);
    fclose(file);
    file = open_new("deep.xml");
    fputs("<scene version='3.0.0'>", file);
    write_repeated(file, "<bsdf type='twosided'>", 100000);
    fclose(file);
    for (int level = 0; level < 12; level++) { /* 3^12 files */
        char name[32];
        snprintf(name, sizeof(name), "level%d.xml", level);
        file = open_new(name);
        fputs("<scene version='3.0.0'>", file);
        for (int i = 0; i < 3 && level < 11; i++)
            fprintf(file, "<include filename='level%d.xml'/>", level + 1);
        fputs("</scene>", file);
        fclose(file);
    }
}

static void make_other_files(void) {
    static const char ply[] = "ply\nformat binary_little_endian 1.0\nelement vertex 1000000000\n"
                              "property float x\nproperty float y\nproperty float z\n"
                              "element face 1\nproperty list uchar int vertex_indices\n"
                              "end_header\n";
    static char name[1 << 22];
    static const unsigned char counts[] = {0, 0x10, 0, 0,    0,          /* single, no name */
                                           0, 0,    0, 0x10, 0, 0, 0, 0, /* 2^28 vertices */
                                           1, 0,    0, 0,    0, 0, 0, 0};
    static const char large[] = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 16384 +X 16384\n";
    char deep[20000];
    assert_int_equal(mkfifo(path_of("pipe"), 0600), 0);
    write_file("count.ply", ply, sizeof(ply) - 1);
    memset(name + 4, 'x', sizeof(name) - 4);
    name[1] = 0x10;
    write_serialized("name.serialized", name, sizeof(name));
    write_serialized("count.serialized", counts, sizeof(counts));
    write_file("large.hdr", large, sizeof(large) - 1);
    write_file("large.ppm", "P6\n16384 16384\n255\n", 19);
    memset(deep, '[', sizeof(deep));
    write_file("deep.gltf", deep, sizeof(deep));

    /* A sound picture whose window is made 16384 x 16384. */
    struct fewray_frame *frame = NULL;
    assert_int_equal(fewray_frame_create(4, 4, &frame, NULL), 0);
    float *planes[3];
    assert_true(fewray_frame_add_layer(frame, FEWRAY_COLOR, planes));
    assert_int_equal(fewray_frame_write_exr(frame, path_of("large.exr"), false, NULL), 0);
    fewray_frame_destroy(&frame);
    static unsigned char exr[65536];
    FILE *file = fopen(path_of("large.exr"), "rb");
    const size_t size = fread(exr, 1, sizeof(exr), file);
    fclose(file);
    static const unsigned char small[] = {3, 0, 0, 0, 3, 0, 0, 0};
    static const unsigned char huge[] = {0xff, 0x3f, 0, 0, 0xff, 0x3f, 0, 0};
    int found = 0;
    for (size_t i = 0; i + 8 < size; i++)
        if (!memcmp(exr + i, small, 8) && ++found)
            memcpy(exr + i, huge, 8);
    assert_int_equal(found, 2); /* data window, display window */
    write_file("large.exr", exr, size);
}

static void test_bombs_are_refused_with_a_line(void **state) {
    (void)state;
    make_xml_files();
    make_other_files();
    for (size_t i = 0; i < sizeof(refused) / sizeof(*refused); i++) {
        const struct refused *c = &refused[i];
        char messages[4096];
        if (c->text)
            write_file(c->name, c->text, strlen(c->text));
        char *arguments[] = {"fewray", "info", (char *)c->name, NULL};
        expect_line(c->name, run(arguments, 0, messages, sizeof(messages)), 1, messages, c->what);
    }
}

/* What `denoise` reads, its weights among it. */
static void test_devices_and_pipes_are_no_pictures(void **state) {
    (void)state;
    static const char *const inputs[] = {"pipe", "/dev/zero", ".", "large.exr"};
    char messages[4096];
    for (size_t i = 0; i < sizeof(inputs) / sizeof(*inputs); i++) {
        char *arguments[] = {"fewray", "denoise", (char *)inputs[i], "-o", "out.exr", NULL};
        expect_line(inputs[i], run(arguments, 0, messages, sizeof(messages)), 1, messages,
                    inputs[i]);
    }
    struct fewray_frame *frame = NULL;
    float *planes[3];
    assert_int_equal(fewray_frame_create(4, 4, &frame, NULL), 0);
    assert_true(fewray_frame_add_layer(frame, FEWRAY_COLOR, planes));
    assert_int_equal(fewray_frame_write_exr(frame, path_of("in.exr"), false, NULL), 0);
    fewray_frame_destroy(&frame);
    struct fewray_denoise_options options;
    struct fewray_denoiser *denoiser = NULL;
    struct fewray_error error = {0};
    fewray_denoise_options_init(&options);
    options.weights_path = "/dev/zero";
    assert_int_equal(fewray_denoiser_create(&options, &denoiser, &error), FEWRAY_ERROR_FORMAT);
    assert_non_null(strstr(error.what, "not a fewray weights file"));
}

/* --- what would need more memory than there is */

static void test_a_picture_beyond_memory_is_refused_before_it_is_allocated(void **state) {
    (void)state;
    char messages[4096]; /* 65536 x 65536 x 200 bytes and more: 800 GiB */
    write_file("large.xml", FILM("65536"), strlen(FILM("65536")));
    char *arguments[] = {"fewray", "render", "large.xml", "-o", "out.exr", "--guide", "off", NULL};
    expect_line("film", run(arguments, 0, messages, sizeof(messages)), 1, messages, "would need");
}

/* A file of 20000 triangles, placed 2000 times: 2.5 GiB. */
static void test_a_mesh_placed_too_often_is_refused(void **state) {
    (void)state;
    char messages[4096];
    if (SANITIZED)
        skip(); /* which need more address space than the limit */
    FILE *file = open_new("many.obj");
    for (int i = 0; i < 20000; i++)
        fprintf(file, "v %d 0 0\nv %d 1 0\nv %d 0 1\nf -1 -2 -3\n", i, i, i);
    fclose(file);
    file = open_new("many.xml");
    fputs("<scene version='3.0.0'>" SENSOR, file);
    write_repeated(file, "<shape type='obj'><string name='filename' value='many.obj'/></shape>",
                   2000);
    fputs("</scene>", file);
    fclose(file);
    char *arguments[] = {"fewray", "info", "many.xml", NULL};
    expect_line("meshes", run(arguments, 1024, messages, sizeof(messages)), 1, messages,
                "all meshes together would need");
}

/* --- nothing but the outputs is written */

static void expect_victim(void) {
    char text[16] = "";
    FILE *file = fopen(path_of("victim"), "rb");
    assert_non_null(file);
    assert_int_equal(fread(text, 1, sizeof(text) - 1, file), 4);
    fclose(file);
    assert_string_equal(text, "mine");
}

static void test_a_scene_names_no_output(void **state) {
    (void)state;
    static const char scene[] =
        "<scene version='3.0.0'><sensor type='perspective'><film type='hdrfilm'>"
        "<integer name='width' value='4'/><integer name='height' value='4'/>"
        "<string name='filename' value='victim'/><string name='output_file' value='victim'/>"
        "</film></sensor><shape type='sphere'/></scene>";
    char messages[4096];
    write_file("victim", "mine", 4);
    write_file("names.xml", scene, sizeof(scene) - 1);
    char *arguments[] = {"fewray", "render", "names.xml", "-o", "out.exr", NULL};
    assert_int_equal(run(arguments, 0, messages, sizeof(messages)), 0);
    assert_int_equal(access(path_of("out.exr"), F_OK), 0);
    expect_victim();
}

static void test_links_are_replaced_not_followed(void **state) {
    (void)state;
    char messages[4096], link[256];
    write_file("victim", "mine", 4);
    snprintf(link, sizeof(link), "%s", path_of("link"));
    assert_int_equal(symlink("victim", link), 0);
    char *arguments[] = {"fewray", "denoise", "in.exr", "-o", "link", NULL};
    assert_int_equal(run(arguments, 0, messages, sizeof(messages)), 0);
    struct stat info;
    assert_int_equal(lstat(link, &info), 0);
    assert_true(S_ISREG(info.st_mode));
    expect_victim();
    unlink(link); /* so are files that are written by another way than pictures */
    assert_int_equal(symlink("victim", link), 0);
    struct fewray_run_stats stats = {0};
    assert_int_equal(stats_write(&stats, link, NULL), FEWRAY_OK);
    assert_int_equal(lstat(link, &info), 0);
    assert_true(S_ISREG(info.st_mode));
    expect_victim();
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_bombs_are_refused_with_a_line),
        cmocka_unit_test(test_devices_and_pipes_are_no_pictures),
        cmocka_unit_test(test_a_picture_beyond_memory_is_refused_before_it_is_allocated),
        cmocka_unit_test(test_a_mesh_placed_too_often_is_refused),
        cmocka_unit_test(test_a_scene_names_no_output),
        cmocka_unit_test(test_links_are_replaced_not_followed),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
