/* SPDX-License-Identifier: Apache-2.0 */
/* A stage as Mitsuba 3 XML: only the plugins and parameters that fewray's loader knows as well. */

#include "guide/train/scenes/write_xml.h"

#include <stdio.h>

#include "guide/train/scenes/write_material.h"

static void write_matrix(FILE *file, const struct xform *x) {
    fprintf(file, "<transform name=\"to_world\"><matrix value=\"");
    for (int i = 0; i < 12; i++)
        fprintf(file, "%.7g ", (double)x->m[i]);
    fprintf(file, "0 0 0 1\"/></transform>\n");
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

/* Mitsuba's to_world of a cylinder must be free of shear, even of rounding's: points instead. */
static void write_cylinder(FILE *file, const struct shape *shape) {
    const float *m = shape->to_world.m;
    struct vec3 from = xform_point(&shape->to_world, vec(0, 0, 0)),
                to = xform_point(&shape->to_world, vec(0, 0, 1));
    fprintf(file, "<point name=\"p0\" value=\"%.7g, %.7g, %.7g\"/>", (double)from.x, (double)from.y,
            (double)from.z);
    fprintf(file, "<point name=\"p1\" value=\"%.7g, %.7g, %.7g\"/>", (double)to.x, (double)to.y,
            (double)to.z);
    fprintf(file, "<float name=\"radius\" value=\"%.6g\"/>", (double)length(vec(m[0], m[4], m[8])));
}

static void write_shape(FILE *file, const struct stage *stage, const struct shape *shape,
                        const char *prefix) {
    static const char *const names[] = {"rectangle", "disk", "cube", "sphere", "cylinder", "obj"};
    fprintf(file, "  <shape type=\"%s\"><ref id=\"m%d\"/>", names[shape->kind], shape->material);
    if (luminance(shape->radiance) > 0) {
        fprintf(file, "<emitter type=\"area\">");
        write_rgb(file, "radiance", shape->radiance);
        fprintf(file, "</emitter>");
    }
    fprintf(file, "\n    ");
    if (shape->kind == SHAPE_MESH)
        fprintf(file,
                "<string name=\"filename\" value=\"meshes/%s-%d.obj\"/><boolean "
                "name=\"face_normals\" value=\"%s\"/>",
                prefix, shape->mesh, stage->meshes[shape->mesh]->smooth ? "false" : "true");
    if (shape->kind == SHAPE_CYLINDER)
        write_cylinder(file, shape);
    else
        write_matrix(file, &shape->to_world);
    fprintf(file, "  </shape>\n");
}

static void write_lamp(FILE *file, const struct lamp *lamp) {
    struct vec3 p = lamp->position, d = normalize(lamp->direction);
    fprintf(file, "  <emitter type=\"%s\">", lamp->spot ? "spot" : "point");
    write_rgb(file, "intensity", lamp->intensity);
    if (lamp->spot) {
        struct vec3 up = fabsf(d.y) < 0.9f ? vec(0, 1, 0) : vec(1, 0, 0);
        struct vec3 u = normalize(cross(up, d)), v = cross(d, u);
        struct xform to_world = {{u.x, v.x, d.x, p.x, u.y, v.y, d.y, p.y, u.z, v.z, d.z, p.z}};
        fprintf(file,
                "<float name=\"cutoff_angle\" value=\"%.4g\"/><float name=\"beam_width\" "
                "value=\"%.4g\"/>",
                (double)lamp->cutoff, (double)lamp->beam);
        write_matrix(file, &to_world);
    } else {
        fprintf(file, "<point name=\"position\" value=\"%.7g, %.7g, %.7g\"/>", (double)p.x,
                (double)p.y, (double)p.z);
    }
    fprintf(file, "  </emitter>\n");
}

static void write_sky(FILE *file, const struct sky *sky, const char *prefix) {
    if (sky->kind == SKY_CONSTANT) {
        fprintf(file, "  <emitter type=\"constant\">");
        write_rgb(file, "radiance", scale(sky->horizon, sky->strength));
        fprintf(file, "</emitter>\n");
    } else if (sky->kind == SKY_MAP) {
        fprintf(file,
                "  <emitter type=\"envmap\"><string name=\"filename\" "
                "value=\"%s-sky.exr\"/></emitter>\n",
                prefix);
    }
}

int stage_write_xml(const struct stage *stage, int width, int height, const char *path,
                    const char *prefix, struct fewray_error *error) {
    FILE *file = fopen(path, "w");
    if (!file)
        return fewray_fail(error, FEWRAY_ERROR_IO, path, 0,
                           "can't be written: does its folder exist?");
    fprintf(file, "<scene version=\"3.0.0\">\n");
    fprintf(file,
            "  <integrator type=\"path\"><integer name=\"max_depth\" value=\"%d\"/></integrator>\n",
            stage->mixed ? 8 : 3);
    write_camera(file, &stage->camera, width, height);
    for (int i = 0; i < stage->material_count; i++)
        write_material(file, &stage->materials[i], i, prefix);
    for (int i = 0; i < stage->shape_count; i++)
        write_shape(file, stage, &stage->shapes[i], prefix);
    for (int i = 0; i < stage->lamp_count; i++)
        write_lamp(file, &stage->lamps[i]);
    write_sky(file, &stage->sky, prefix);
    fprintf(file, "</scene>\n");
    bool bad = ferror(file) != 0;
    bad |= fclose(file) != 0;
    return bad ? fewray_fail(error, FEWRAY_ERROR_IO, path, 0, "can't be written: is the disk full?")
               : FEWRAY_OK;
}
