/* SPDX-License-Identifier: Apache-2.0 */
/* Light tables: which lights there are and how often each is picked. */

#include <stdlib.h>

#include "guide/light/distribution.h"
#include "guide/light/light_source.h"

/* With more sources than this a tree picks them. */
#ifndef LIGHT_TREE_LEAST
#define LIGHT_TREE_LEAST 8
#endif

static bool shines(const struct mesh *mesh) {
    return mesh->emission >= 0 && mesh->group < 0;
}

static size_t count_sources(const struct fewray_scene *scene) {
    size_t n = 0;
    for (int m = 0; m < scene->mesh_count; m++)
        if (shines(&scene->meshes[m]))
            n += scene->meshes[m].kind == MESH_SPHERE ? 1 : scene->meshes[m].triangle_count;
    for (int i = 0; i < scene->light_count; i++)
        n += scene->lights[i].kind == LIGHT_POINT || scene->lights[i].kind == LIGHT_SPOT;
    return n;
}

/* What the build knows of the sources beside the tables. */
struct measures {
    struct light_bounds *bounds; /* (source_count) */
    float *flux;                 /* (source_count) */
};

static void add_source(const struct fewray_scene *scene, struct light_source source, float mean,
                       struct lights *lights, struct measures *measures) {
    size_t i = lights->source_count++;
    double area = source_area(scene, &source);
    source.pdf_area = area > 0 ? (float)(1 / area) : 0;
    measures->bounds[i] = source_bounds(scene, &source, mean, &measures->flux[i]);
    if (!(isfinite(measures->flux[i]) && measures->flux[i] > 0 && isfinite(source.pdf_area)))
        measures->bounds[i].phi = measures->flux[i] = 0;
    lights->sources[i] = source;
}

static void add_sources(const struct fewray_scene *scene, struct lights *lights,
                        struct measures *measures) {
    for (int m = 0; m < scene->mesh_count; m++) {
        const struct mesh *mesh = &scene->meshes[m];
        struct light_source source = {.kind = SOURCE_TRIANGLE, .index = (uint32_t)m};
        lights->first_source[m] = UINT32_MAX;
        if (!shines(mesh))
            continue;
        lights->first_source[m] = (uint32_t)lights->source_count;
        float mean = texture_mean_luminance(&scene->textures[mesh->emission]);
        if (mesh->kind == MESH_SPHERE) {
            source.kind = SOURCE_SPHERE;
            add_source(scene, source, mean, lights, measures);
        }
        for (; mesh->kind == MESH_TRIANGLES && source.triangle < mesh->triangle_count;
             source.triangle++)
            add_source(scene, source, mean, lights, measures);
    }
    for (int i = 0; i < scene->light_count; i++) {
        enum light_kind kind = scene->lights[i].kind;
        if (kind == LIGHT_POINT || kind == LIGHT_SPOT)
            add_source(
                scene,
                (struct light_source){.kind = kind == LIGHT_POINT ? SOURCE_POINT : SOURCE_SPOT,
                                      .index = (uint32_t)i},
                0, lights, measures);
    }
}

/* Fills the distant lights; their power, in W, goes to `power`. */
static void add_distant(const struct fewray_scene *scene,
                        const struct environment_table *environment, double radius,
                        struct lights *lights, float *power) {
    double section = PI_F * radius * radius;
    lights->has_sky = scene->environment.kind != ENVIRONMENT_NONE;
    if (lights->has_sky) {
        power[lights->distant_count] = (float)(environment->power_density * 4 * PI_F * section);
        lights->distant[lights->distant_count++] =
            (struct distant_light){.kind = DISTANT_ENVIRONMENT};
    }
    for (int i = 0; i < scene->light_count; i++) {
        const struct light *light = &scene->lights[i];
        struct distant_light d = {.radiance = light->intensity};
        double irradiance = luminance(light->intensity);
        if (light->kind == LIGHT_DIRECTIONAL) {
            d.kind = DISTANT_DIRECTIONAL;
            d.direction = negate(light->direction);
        } else if (light->kind == LIGHT_SUN) {
            float half = sinf(0.5f * light->cutoff);
            d.kind = DISTANT_SUN;
            lights->has_sky = true;
            d.direction = light->direction;
            d.cone = 2 * half * half;
            irradiance *= 2 * PI_F * d.cone;
        } else {
            continue;
        }
        power[lights->distant_count] = (float)(irradiance * section);
        lights->distant[lights->distant_count++] = d;
    }
}

/* Chances of the sources and of each distant light. flux: of the sources; power: of the distant
 * lights. */
static void set_chances(struct lights *lights, const float *flux, float *power) {
    double near_power = cdf_build(flux, lights->source_count, lights->cdf), far_power = 0;
    int n = lights->distant_count, lit = 0;
    for (int i = 0; i < n; i++) {
        far_power += power[i];
        lit += power[i] > 0;
    }
    /* A sun is strong where it shines, but the sky reaches into the shadows. */
    for (int i = 0; i < n && lit > 0; i++)
        if (power[i] > 0)
            power[i] = (float)(0.5 * power[i] / far_power + 0.5 / lit);
    cdf_build(power, (size_t)n, lights->distant_cdf);
    /* A huge ground plane must not starve the lamps: the sky gets at most what the lamps get
     * together. */
    double far_share = far_power / (near_power + far_power);
    if (!(near_power > 0))
        far_share = 1;
    else if (!(far_share < 0.5))
        far_share = far_power > 0 ? 0.5 : 0;
    lights->source_chance = (float)(1 - far_share);
    if (!(near_power + far_power > 0))
        lights->source_chance = far_share = 0;
    for (int i = 0; i < n; i++)
        lights->distant[i].chance =
            (float)far_share * (lights->distant_cdf[i + 1] - lights->distant_cdf[i]);
    bool tree = lights->tree.node_count > 0;
    for (size_t i = 0; i < lights->source_count; i++)
        lights->sources[i].chance =
            tree ? lights->source_chance
                 : lights->source_chance * (float)(near_power > 0 ? flux[i] / near_power : 0);
}

static int no_memory(struct lights *lights, size_t n, struct fewray_error *error) {
    lights_clear(lights);
    return fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0, "no memory for %zu lights", n);
}

int lights_create(const struct fewray_scene *scene, const struct environment_table *environment,
                  double radius, struct lights *lights, struct fewray_error *error) {
    size_t n = count_sources(scene), distant = (size_t)scene->light_count + 1;
    *lights = (struct lights){0};
    lights->sources = calloc(n + 1, sizeof(*lights->sources));
    lights->cdf = malloc((n + 2) * sizeof(float));
    lights->first_source = malloc(((size_t)scene->mesh_count + 1) * sizeof(uint32_t));
    lights->distant = calloc(distant, sizeof(*lights->distant));
    lights->distant_cdf = malloc((distant + 1) * sizeof(float));
    struct measures measures = {malloc((n + 1) * sizeof(*measures.bounds)),
                                malloc((n + 1) * sizeof(float))};
    float *power = malloc(distant * sizeof(float));
    int status = FEWRAY_OK;
    if (!lights->sources || !lights->cdf || !lights->first_source || !lights->distant ||
        !lights->distant_cdf || !measures.bounds || !measures.flux || !power) {
        status = no_memory(lights, n, error);
        goto done;
    }
    add_sources(scene, lights, &measures);
    add_distant(scene, environment, radius, lights, power);
    if (n > LIGHT_TREE_LEAST)
        status = light_tree_create(measures.bounds, n, &lights->tree, error);
    if (status)
        lights_clear(lights);
    else
        set_chances(lights, measures.flux, power);
done:
    free(measures.bounds);
    free(measures.flux);
    free(power);
    return status;
}

void lights_clear(struct lights *lights) {
    light_tree_clear(&lights->tree);
    free(lights->sources);
    free(lights->cdf);
    free(lights->first_source);
    free(lights->distant);
    free(lights->distant_cdf);
    *lights = (struct lights){0};
}
