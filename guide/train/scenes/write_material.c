/* SPDX-License-Identifier: Apache-2.0 */
/* Materials as Mitsuba 3 XML. */

#include "guide/train/scenes/write_material.h"

static void write_float(FILE *file, const char *name, float value) {
    fprintf(file, "<float name=\"%s\" value=\"%.4g\"/>", name, (double)value);
}

void write_rgb(FILE *file, const char *name, struct vec3 c) {
    fprintf(file, "<rgb name=\"%s\" value=\"%.5g, %.5g, %.5g\"/>", name, (double)c.x, (double)c.y,
            (double)c.z);
}

static void write_color(FILE *file, const struct material *m, const char *name,
                        const char *prefix) {
    struct vec3 difference = sub(m->color0, m->color1);
    if (m->picture >= 0) {
        fprintf(file,
                "<texture name=\"%s\" type=\"bitmap\"><string name=\"filename\" "
                "value=\"textures/%s-%d.png\"/>",
                name, prefix, m->picture);
    } else if (dot(difference, difference) > 0) {
        fprintf(file, "<texture name=\"%s\" type=\"checkerboard\">", name);
        write_rgb(file, "color0", m->color0);
        write_rgb(file, "color1", m->color1);
    } else {
        write_rgb(file, name, m->color0);
        return;
    }
    fprintf(file, "<transform name=\"to_uv\"><scale x=\"%.4g\" y=\"%.4g\"/></transform></texture>",
            (double)m->scale_u, (double)m->scale_v);
}

static void write_roughness(FILE *file, const struct material *m) {
    fprintf(file, "<string name=\"distribution\" value=\"%s\"/>", m->ggx ? "ggx" : "beckmann");
    write_float(file, "alpha", m->alpha);
}

static void write_plastic(FILE *file, const struct material *m, const char *prefix) {
    write_color(file, m, "diffuse_reflectance", prefix);
    write_float(file, "int_ior", m->ior);
    fprintf(file, "<boolean name=\"nonlinear\" value=\"%s\"/>", m->nonlinear ? "true" : "false");
    if (m->kind == MATERIAL_ROUGH_PLASTIC)
        write_roughness(file, m);
}

static void write_conductor(FILE *file, const struct material *m, const char *prefix) {
    fprintf(file, "<string name=\"material\" value=\"%s\"/>", m->metal);
    write_color(file, m, "specular_reflectance", prefix);
    if (m->kind == MATERIAL_ROUGH_CONDUCTOR)
        write_roughness(file, m);
}

static void write_principled(FILE *file, const struct material *m, const char *prefix) {
    write_color(file, m, "base_color", prefix);
    write_float(file, "roughness", m->alpha);
    write_float(file, "specular", m->specular);
    if (m->metallic > 0)
        write_float(file, "metallic", m->metallic);
    if (m->clearcoat > 0)
        write_float(file, "clearcoat", m->clearcoat);
    if (m->sheen > 0)
        write_float(file, "sheen", m->sheen);
}

static void write_glass(FILE *file, const struct material *m, const char *prefix) {
    write_color(file, m, "specular_transmittance", prefix);
    write_float(file, "int_ior", m->ior);
    if (m->kind == MATERIAL_ROUGH_DIELECTRIC)
        write_roughness(file, m);
}

void write_material(FILE *file, const struct material *m, int index, const char *prefix) {
    static const char *const names[] = {"diffuse",    "plastic",         "roughplastic",
                                        "conductor",  "roughconductor",  "principled",
                                        "dielectric", "roughdielectric", "thindielectric"};
    bool glass = material_transmits(m);
    if (glass)
        fprintf(file, "  <bsdf type=\"%s\" id=\"m%d\">", names[m->kind], index);
    else
        fprintf(file, "  <bsdf type=\"twosided\" id=\"m%d\"><bsdf type=\"%s\">", index,
                names[m->kind]);
    switch (m->kind) {
    case MATERIAL_DIFFUSE:
        write_color(file, m, "reflectance", prefix);
        break;
    case MATERIAL_PLASTIC:
    case MATERIAL_ROUGH_PLASTIC:
        write_plastic(file, m, prefix);
        break;
    case MATERIAL_CONDUCTOR:
    case MATERIAL_ROUGH_CONDUCTOR:
        write_conductor(file, m, prefix);
        break;
    case MATERIAL_PRINCIPLED:
        write_principled(file, m, prefix);
        break;
    default:
        write_glass(file, m, prefix);
    }
    fprintf(file, glass ? "</bsdf>\n" : "</bsdf></bsdf>\n");
}
