/* SPDX-License-Identifier: Apache-2.0 */
/* Procedural skies: clear, cloudy, overcast, low sun, and studios of bright panels. */

#include "guide/train/scenes/sky.h"

#include "guide/train/scenes/noise.h"

#define MAP_WIDTH      256
#define MAP_HEIGHT     128
#define MAP_SUBSAMPLES 4

static struct vec3 mix(struct vec3 a, struct vec3 b, float t) {
    return add(scale(a, 1 - t), scale(b, t));
}

static struct vec3 direction(struct random *r, float low_y, float high_y) {
    float y = uniform(r, low_y, high_y), azimuth = uniform(r, 0, 2 * PI_F),
          rho = sqrtf(fmaxf(0, 1 - y * y));
    return vec(rho * cosf(azimuth), y, rho * sinf(azimuth));
}

static void studio(struct sky *sky, struct random *r) {
    sky->zenith = sky->horizon = sky->ground = scale(vec(1, 1, 1), log_uniform(r, 0.01f, 0.3f));
    sky->panel_count = between(r, 1, SKY_PANELS);
    for (int i = 0; i < sky->panel_count; i++) {
        float radius = log_uniform(r, 0.03f, 0.5f);
        sky->panel_cos[i] = cosf(radius);
        sky->panel_dir[i] = direction(r, -0.1f, 1);
        float strength =
            log_uniform(r, 0.5f, 2) / (1 - sky->panel_cos[i]) / (float)sky->panel_count;
        struct vec3 tint = vec(uniform(r, 0.7f, 1), uniform(r, 0.7f, 1), uniform(r, 0.7f, 1));
        sky->panel[i] = scale(tint, strength);
    }
}

static void daylight(struct sky *sky, struct random *r) {
    float blue = uniform(r, 0.1f, 0.9f);
    sky->zenith = mix(vec(0.9f, 0.9f, 0.95f), vec(0.25f, 0.5f, 1.1f), blue);
    sky->horizon = scale(mix(vec(1, 1, 1), vec(0.8f, 0.95f, 1.1f), blue), uniform(r, 0.8f, 1.6f));
    struct vec3 earth = chance(r, 0.5f) ? vec(0.25f, 0.3f, 0.12f) : vec(0.4f, 0.35f, 0.3f);
    sky->ground = scale(earth, uniform(r, 0.3f, 1.2f));
    sky->sun_dir = direction(r, 0.08f, 0.95f);
    float low = 1 - fminf(1, sky->sun_dir.y * 2);
    struct vec3 sun_tint = mix(vec(1, 0.95f, 0.88f), vec(1, 0.6f, 0.3f), low);
    if (low > 0.5f)
        sky->horizon = mul(sky->horizon, mix(vec(1, 1, 1), vec(1.3f, 0.8f, 0.5f), low));
    if (chance(r, 0.75f)) {
        float radius = log_uniform(r, 0.006f, 0.08f);
        sky->sun_cos = cosf(radius);
        /* Strength by irradiance, as the disc's size says nothing about it: up to ten times the
         * sky's. */
        float irradiance = log_uniform(r, 0.3f, 30);
        sky->sun = scale(sun_tint, irradiance / (PI_F * radius * radius));
    }
    sky->glow = chance(r, 0.7f) ? log_uniform(r, 0.3f, 8) : 0;
    sky->glow_power = log_uniform(r, 4, 200);
    sky->cloud = chance(r, 0.6f) ? uniform(r, 0.1f, 0.9f) : 0;
    sky->cloud_scale = log_uniform(r, 1.5f, 8);
    sky->cloud_light = uniform(r, 0.6f, 2.5f);
    sky->skyline = chance(r, 0.6f) ? uniform(r, 0.02f, 0.5f) : 0;
    sky->skyline_scale = log_uniform(r, 2, 14);
}

void sky_random(struct sky *sky, struct random *r) {
    *sky = (struct sky){.kind = SKY_MAP, .strength = 1, .sun_dir = {0, 1, 0}, .sun_cos = 2};
    sky->noise_seed = random_bits(r);
    if (chance(r, 0.15f))
        studio(sky, r);
    else
        daylight(sky, r);
}

static struct vec3 below_skyline(const struct sky *sky, struct vec3 dir) {
    struct vec3 at = scale(dir, 12);
    at.y *= 1 / fmaxf(0.15f, fabsf(dir.y));
    return scale(sky->ground, 0.4f + 1.2f * noise_fractal(sky->noise_seed + 77, at));
}

struct vec3 sky_radiance(const struct sky *sky, struct vec3 dir, bool with_sun) {
    if (sky->kind == SKY_NONE)
        return vec(0, 0, 0);
    if (sky->kind == SKY_CONSTANT)
        return scale(sky->horizon, sky->strength);
    float rho = sqrtf(fmaxf(1e-6f, 1 - dir.y * dir.y));
    struct vec3 around = scale(vec(dir.x, 0, dir.z), sky->skyline_scale / rho);
    float hills = sky->skyline > 0 ? sky->skyline * noise_fractal(sky->noise_seed + 31, around) : 0;
    struct vec3 radiance;
    if (dir.y < hills && sky->panel_count == 0) {
        radiance = below_skyline(sky, dir);
    } else {
        radiance = mix(sky->horizon, sky->zenith, powf(fmaxf(0, dir.y), 0.5f));
        float toward = fmaxf(0, dot(dir, sky->sun_dir));
        radiance =
            add(radiance, scale(vec(1, 0.95f, 0.85f), sky->glow * powf(toward, sky->glow_power)));
        if (sky->cloud > 0) {
            struct vec3 at =
                scale(vec(dir.x, 0.3f, dir.z), sky->cloud_scale / (0.2f + fmaxf(0, dir.y)));
            float cover = fminf(
                1, fmaxf(0, (noise_fractal(sky->noise_seed, at) - 1 + sky->cloud) * 5 + 0.5f));
            radiance = mix(radiance, scale(vec(1, 1, 1), sky->cloud_light), cover * 0.9f);
        }
        if (with_sun && toward > sky->sun_cos)
            radiance = add(radiance, sky->sun);
    }
    for (int i = 0; i < sky->panel_count; i++)
        if (dot(dir, sky->panel_dir[i]) > sky->panel_cos[i])
            radiance = add(radiance, sky->panel[i]);
    return scale(radiance, sky->strength);
}

/* Mitsuba: u = atan2(x, -z) / 2 pi, v = acos(y) / pi. */
static struct vec3 pixel_direction(float u, float v) {
    float phi = 2 * PI_F * u, theta = PI_F * v;
    return vec(sinf(theta) * sinf(phi), cosf(theta), -sinf(theta) * cosf(phi));
}

int sky_write(const struct sky *sky, const char *path, struct fewray_error *error) {
    struct fewray_frame *frame = NULL;
    float *rgb[3], greatest = 0;
    int status = fewray_frame_create(MAP_WIDTH, MAP_HEIGHT, &frame, error);
    if (status < 0)
        return status;
    if (!fewray_frame_add_layer(frame, FEWRAY_COLOR, rgb)) {
        status = fewray_fail(error, FEWRAY_ERROR_MEMORY, path, 0, "out of memory");
        goto done;
    }
    for (int i = 0; i < MAP_WIDTH * MAP_HEIGHT; i++) {
        struct vec3 sum = vec(0, 0, 0);
        for (int s = 0; s < MAP_SUBSAMPLES * MAP_SUBSAMPLES; s++) {
            float dx = ((float)(s % MAP_SUBSAMPLES) + 0.5f) / MAP_SUBSAMPLES;
            float dy = ((float)(s / MAP_SUBSAMPLES) + 0.5f) / MAP_SUBSAMPLES;
            float u = ((float)(i % MAP_WIDTH) + dx) / MAP_WIDTH,
                  v = ((float)(i / MAP_WIDTH) + dy) / MAP_HEIGHT;
            sum = add(sum, sky_radiance(sky, pixel_direction(u, v), true));
        }
        sum = scale(sum, 1.0f / (MAP_SUBSAMPLES * MAP_SUBSAMPLES));
        rgb[0][i] = sum.x, rgb[1][i] = sum.y, rgb[2][i] = sum.z;
        greatest = fmaxf(greatest, max_component(sum));
    }
    status = fewray_frame_write_exr(frame, path, greatest > 60000, error);
done:
    fewray_frame_destroy(&frame);
    return status;
}
