/* SPDX-License-Identifier: Apache-2.0 */
/* `fewray info` says what a denoiser finds in a file, what is missing, what sums up, and metadata.
 */

#include "tests/unit/check.h"

#include <jansson.h>
#include <stdio.h>
#include <string.h>

#define FOREIGN TEST_DATA "/foreign/"

static char said[65536];

static const char *info(const char *arguments) {
    char line[1000];
    snprintf(line, sizeof line, "%s info %s", FEWRAY_COMMAND, arguments);
    FILE *pipe = popen(line, "r");
    assert_non_null(pipe);
    said[fread(said, 1, sizeof said - 1, pipe)] = 0;
    assert_int_equal(pclose(pipe), 0);
    return said;
}

static void test_layers_and_lacks_are_told(void **state) {
    (void)state;
    static const struct {
        const char *file, *lines[8];
    } cases[] = {
        {FOREIGN "cycles-denoised.exr",
         {"EXR, 32x24 pixels, 60 channels in 20 parts, ZIP\n",
          "  beauty     ViewLayer.Noisy Image.R, ViewLayer.Noisy Image.G, ViewLayer.Noisy Image.B "
          "(blender names); the result replaces ViewLayer.Combined.R\n",
          "  depth      ViewLayer.Denoising Depth.Z (blender names)\n",
          "  emission   ViewLayer.Emission.R, ViewLayer.Emission.G, ViewLayer.Emission.B (blender "
          "names), and ViewLayer.Environment.R\n",
          "  variance   missing: the noise is judged by the picture itself\n",
          "sum of 6 passes and the emission equals the picture to 0.0",
          "kept as they are: ViewLayer.Depth, ViewLayer.Normal, ViewLayer.Vector",
          "cryptomatte/542cafa/manifest {\"floor\":"}},
        {FOREIGN "mitsuba-aovs.exr",
         {"EXR, 32x32 pixels, 21 channels, PIZ\n",
          "  normal     nn.X, nn.Y, nn.Z (mitsuba names)\n",
          "  depth      dd.y.T (mitsuba names)\n",
          "  emission   missing: lamps and windows are guessed from bright, black surfaces\n",
          "kept as they are: img, pos, shape, uv\n", "generatedBy              Mitsuba version",
          NULL}},
    };
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        info(cases[k].file);
        for (int i = 0; i < 8 && cases[k].lines[i]; i++)
            if (!strstr(said, cases[k].lines[i]))
                fail_msg("%s: no '%s' in\n%s", cases[k].file, cases[k].lines[i], said);
    }
}

static void test_json_tells_the_same(void **state) {
    (void)state;
    json_t *object = json_loads(info("--json " FOREIGN "cycles-groups.exr"), 0, NULL);
    assert_non_null(object);
    const json_t *layers = json_object_get(object, "layers");
    const json_t *beauty = json_object_get(json_object_get(layers, "beauty"), "channels");
    assert_string_equal(json_string_value(json_array_get(beauty, 0)), "ViewLayer.Combined.R");
    assert_true(json_is_null(json_object_get(layers, "variance")));
    const json_t *sums = json_object_get(object, "sums");
    assert_int_equal(json_array_size(sums), 2);
    for (size_t s = 0; s < 2; s++) {
        const json_t *sum = json_array_get(sums, s);
        assert_true(json_is_true(json_object_get(sum, "equals_picture")));
        assert_true(json_real_value(json_object_get(sum, "relative_error")) < 0.001);
    }
    const json_t *note = json_object_get(json_object_get(object, "metadata"), "Note");
    assert_string_equal(json_string_value(note), "two boxes");
    assert_int_equal(json_integer_value(json_object_get(object, "parts")), 21);
    json_decref(object);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_layers_and_lacks_are_told),
        cmocka_unit_test(test_json_tells_the_same),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
