/* SPDX-License-Identifier: Apache-2.0 */
/* A stage as Mitsuba 3 XML: only the plugins and parameters that fewray's loader knows as well. */

#include "guide/train/scenes/write_xml.h"

#include <stdio.h>

static void write_matrix(FILE *file, const struct xform *x) {
    fprintf(file, "<transform name=\"to_world\"><matrix value=\"");
    for (int i = 0; i < 12; i++)
        fprintf(file, "%.7g ", (double)x->m[i]);
    fprintf(file, "0 0 0 1\"/></transform>\n");
}

static void write_rgb(FILE *file, const char *name, struct vec3 c) {
    fprintf(file, "<rgb name=\"%s\" value=\"%.5g, %.5g, %.5g\"/>", name, (double)c.x, (double)c.y,
            (double)c.z);
}

static void write_camera(FILE *file, const struct camera_pose *camera, int width, int height) {
    struct vec3 forward = normalize(sub(camera->target, camera->eye));
    struct vec3 left = normalize(cross(camera->up, forward)), up = cross(forward, left),
                eye = camera->eye;
    struct xform to_world = {{left.x, up.x, forward.x, eye.x, left.y, up.y, forward.y, eye.y,
                              left.z, up.z, forward.z, eye.z}};
    fprintf(file, "  <sensor type=\"perspective\">\n    <float name=\"fov\" value=\"%.4g\"/>\n",
            (double)camera->fov);
    fprintf(file, "    <string name=\"fov_axis\" value=\"x\"/>\n    ");
    write_matrix(file, &to_world);
    fprintf(file, "    <sampler type=\"independent\"><integer name=\"sample_count\" "
                  "value=\"4\"/></sampler>\n");
    fprintf(file,
            "    <film type=\"hdrfilm\"><integer name=\"width\" value=\"%d\"/><integer "
            "name=\"height\" value=\"%d\"/>"
            "<string name=\"pixel_format\" value=\"rgb\"/><rfilter type=\"box\"/></film>\n  "
            "</sensor>\n",
            width, height);
}

static void write_material(FILE *file, const struct material *m, int index) {
    fprintf(file, "  <bsdf type=\"twosided\" id=\"m%d\"><bsdf type=\"diffuse\">", index);
    struct vec3 difference = sub(m->color0, m->color1);
    if (dot(difference, difference) > 0) {
        fprintf(file, "<texture name=\"reflectance\" type=\"checkerboard\">");
        write_rgb(file, "color0", m->color0);
        write_rgb(file, "color1", m->color1);
        fprintf(file,
                "<transform name=\"to_uv\"><scale x=\"%.4g\" y=\"%.4g\"/></transform></texture>",
                (double)m->scale_u, (double)m->scale_v);
    } else {
        write_rgb(file, "reflectance", m->color0);
    }
    fprintf(file, "</bsdf></bsdf>\n");
}

static void write_shape(FILE *file, const struct shape *shape) {
    static const char *const names[] = {"rectangle", "disk", "cube", "sphere"};
    fprintf(file, "  <shape type=\"%s\"><ref id=\"m%d\"/>", names[shape->kind], shape->material);
    if (luminance(shape->radiance) > 0) {
        fprintf(file, "<emitter type=\"area\">");
        write_rgb(file, "radiance", shape->radiance);
        fprintf(file, "</emitter>");
    }
    fprintf(file, "\n    ");
    write_matrix(file, &shape->to_world);
    fprintf(file, "  </shape>\n");
}

static void write_sky(FILE *file, const struct sky *sky, const char *sky_name) {
    if (sky->kind == SKY_CONSTANT) {
        fprintf(file, "  <emitter type=\"constant\">");
        write_rgb(file, "radiance", scale(sky->horizon, sky->strength));
        fprintf(file, "</emitter>\n");
    } else if (sky->kind == SKY_MAP) {
        fprintf(file,
                "  <emitter type=\"envmap\"><string name=\"filename\" value=\"%s\"/></emitter>\n",
                sky_name);
    }
}

int stage_write_xml(const struct stage *stage, int width, int height, const char *path,
                    const char *sky_name, struct fewray_error *error) {
    FILE *file = fopen(path, "w");
    if (!file)
        return fewray_fail(error, FEWRAY_ERROR_IO, path, 0,
                           "can't be written: does its folder exist?");
    fprintf(file, "<scene version=\"3.0.0\">\n");
    fprintf(file,
            "  <integrator type=\"path\"><integer name=\"max_depth\" value=\"3\"/></integrator>\n");
    write_camera(file, &stage->camera, width, height);
    for (int i = 0; i < stage->material_count; i++)
        write_material(file, &stage->materials[i], i);
    for (int i = 0; i < stage->shape_count; i++)
        write_shape(file, &stage->shapes[i]);
    write_sky(file, &stage->sky, sky_name);
    fprintf(file, "</scene>\n");
    bool bad = ferror(file) != 0;
    bad |= fclose(file) != 0;
    return bad ? fewray_fail(error, FEWRAY_ERROR_IO, path, 0, "can't be written: is the disk full?")
               : FEWRAY_OK;
}
