/* SPDX-License-Identifier: Apache-2.0 */
/* The table of channel names, and where each renderer's are written down. */

#include "pipeline/layer_aliases.h"

/* Blender 5.0 (files that its Cycles wrote; "Render Passes" in its manual): channels begin with the
 * name of the view layer, which may be anything. Long pass names are those of Blender 5. Depth of a
 * miss: 1e10. Normals in world space.
 *
 * Mitsuba 3 (plugin reference, "aov" and "moment"): names of AOVs are the scene author's; these are
 * the ones of its documentation and of common scenes. Depth of a miss: 0.
 *
 * pbrt-v4 (pbr-book.org 4ed, 5.4.2 GBufferFilm; film.cpp): without a dot in its first years. No
 * depth but the place P, in camera space unless the scene says otherwise. Variance is that of the
 * samples.
 *
 * Arnold (Arnold User Guide, "Light Path Expression AOVs", "AOVs", "Arnold Denoiser"): RGBA, N, Z,
 * denoise_albedo before albedo. Depth of a miss: 1e30 or infinite, by the filter.
 *
 * RenderMan (rmanwiki.pixar.com, "Denoising", required channels): Ci, mse (the error of the pixel's
 * mean), albedo, normal in camera space, zfiltered. Depth of a miss: 1e30.
 *
 * V-Ray (docs.chaos.com, "Render Elements", default channel names): diffuse, diffuse_filter and
 * VRayDiffuseFilter are the colour of the surface; `diffuse` is asked for alone, as it is light for
 * Arnold, except with channels called red, green, blue. Z-depth elements (VRayZDepth) are cut to a
 * range and may be turned over, so that only the plain Z is taken. Normals in screen space.
 *
 * Karma (sidefx.com, Solaris, "AOVs"): C, N or hitN, albedo. */
static const struct layer_alias ALIASES[] = {
    {NAMING_BLENDER, FEWRAY_COLOR, "Noisy Image.", "RGB", false},
    {NAMING_BLENDER, FEWRAY_COLOR, "Combined.", "RGB", false},
    {NAMING_BLENDER, FEWRAY_ALBEDO, "Denoising Albedo.", "RGB", false},
    {NAMING_BLENDER, FEWRAY_ALBEDO, "DiffCol.", "RGB", false},
    {NAMING_BLENDER, FEWRAY_ALBEDO, "Diffuse Color.", "RGB", false},
    {NAMING_BLENDER, FEWRAY_NORMAL, "Denoising Normal.", "XYZ", false},
    {NAMING_BLENDER, FEWRAY_NORMAL, "Normal.", "XYZ", false},
    {NAMING_BLENDER, FEWRAY_DEPTH, "Denoising Depth.", "Z", false},
    {NAMING_BLENDER, FEWRAY_DEPTH, "Denoising Depth.", "V", false},
    {NAMING_BLENDER, FEWRAY_DEPTH, "Depth.", "Z", false},
    {NAMING_BLENDER, FEWRAY_DEPTH, "Depth.", "V", false},
    {NAMING_BLENDER, FEWRAY_EMISSION, "Emit.", "RGB", false},
    {NAMING_BLENDER, FEWRAY_EMISSION, "Emission.", "RGB", false},

    {NAMING_MITSUBA, FEWRAY_COLOR, "img.", "RGB", false},
    {NAMING_MITSUBA, FEWRAY_COLOR, "image.", "RGB", false},
    {NAMING_AUTO, FEWRAY_ALBEDO, "albedo.", "RGB", false},
    {NAMING_MITSUBA, FEWRAY_ALBEDO, "alb.", "RGB", false},
    {NAMING_MITSUBA, FEWRAY_ALBEDO, "aa.", "RGB", false},
    {NAMING_MITSUBA, FEWRAY_ALBEDO, "albedo.", "XYZ", false},
    {NAMING_MITSUBA, FEWRAY_NORMAL, "sh_normal.", "XYZ", false},
    {NAMING_MITSUBA, FEWRAY_NORMAL, "nn.", "XYZ", false},
    {NAMING_AUTO, FEWRAY_NORMAL, "normal.", "XYZ", false},
    {NAMING_AUTO, FEWRAY_NORMAL, "normals.", "XYZ", false},
    {NAMING_MITSUBA, FEWRAY_NORMAL, "shading_normal.", "XYZ", false},
    {NAMING_MITSUBA, FEWRAY_NORMAL, "geo_normal.", "XYZ", false},
    {NAMING_MITSUBA, FEWRAY_NORMAL, "sh_normal.", "RGB", false},
    {NAMING_AUTO, FEWRAY_NORMAL, "normal.", "RGB", false},
    {NAMING_MITSUBA, FEWRAY_DEPTH, "depth.", "T", false},
    {NAMING_MITSUBA, FEWRAY_DEPTH, "dd.y.", "T", false},
    {NAMING_MITSUBA, FEWRAY_DEPTH, "dd.", "T", false},
    {NAMING_MITSUBA, FEWRAY_DEPTH, "depth.", "Y", false},

    {NAMING_PBRT, FEWRAY_ALBEDO, "Albedo.", "RGB", false},
    {NAMING_PBRT, FEWRAY_NORMAL, "Ns.", "XYZ", false},
    {NAMING_PBRT, FEWRAY_NORMAL, "Ns", "xyz", false},
    {NAMING_PBRT, FEWRAY_NORMAL, "N", "xyz", false},
    {NAMING_PBRT, FEWRAY_NORMAL, "N.", "XYZ", true},
    {NAMING_PBRT, FEWRAY_VARIANCE, "Variance.", "RGB", false},

    {NAMING_ARNOLD, FEWRAY_ALBEDO, "denoise_albedo.", "RGB", false},
    {NAMING_ARNOLD, FEWRAY_ALBEDO, "diffuse_albedo.", "RGB", false},
    {NAMING_ARNOLD, FEWRAY_NORMAL, "N.", "XYZ", false},
    {NAMING_ARNOLD, FEWRAY_NORMAL, "N.", "RGB", false},
    {NAMING_ARNOLD, FEWRAY_VARIANCE, "RGBA_variance.", "RGB", false},
    {NAMING_ARNOLD, FEWRAY_VARIANCE, "variance.", "RGB", true},
    {NAMING_ARNOLD, FEWRAY_EMISSION, "emission.", "RGB", true},

    {NAMING_RENDERMAN, FEWRAY_COLOR, "Ci.", "RGB", false},
    {NAMING_RENDERMAN, FEWRAY_NORMAL, "Nn.", "XYZ", false},
    {NAMING_RENDERMAN, FEWRAY_NORMAL, "Nn.", "RGB", false},
    {NAMING_RENDERMAN, FEWRAY_DEPTH, "zfiltered", "", false},
    {NAMING_RENDERMAN, FEWRAY_DEPTH, "zfiltered.", "Z", false},
    {NAMING_RENDERMAN, FEWRAY_VARIANCE, "mse.", "RGB", false},
    {NAMING_RENDERMAN, FEWRAY_EMISSION, "emissive.", "RGB", false},

    {NAMING_VRAY, FEWRAY_ALBEDO, "VRayDiffuseFilter.", "RGB", false},
    {NAMING_VRAY, FEWRAY_ALBEDO, "diffuse_filter.", "RGB", false},
    {NAMING_VRAY, FEWRAY_ALBEDO, "diffuseFilter.", "RGB", false},
    {NAMING_VRAY, FEWRAY_ALBEDO, "diffuse.", "red,green,blue", false},
    {NAMING_VRAY, FEWRAY_ALBEDO, "diffuse.", "RGB", true},
    {NAMING_VRAY, FEWRAY_NORMAL, "VRayBumpNormals.", "XYZ", false},
    {NAMING_VRAY, FEWRAY_NORMAL, "bump_normals.", "XYZ", false},
    {NAMING_VRAY, FEWRAY_NORMAL, "bumpnormals.", "XYZ", false},
    {NAMING_VRAY, FEWRAY_NORMAL, "VRayNormals.", "XYZ", false},
    {NAMING_VRAY, FEWRAY_NORMAL, "VRayNormals.", "RGB", false},
    {NAMING_VRAY, FEWRAY_NORMAL, "normals.", "RGB", false},
    {NAMING_VRAY, FEWRAY_EMISSION, "VRaySelfIllumination.", "RGB", false},
    {NAMING_VRAY, FEWRAY_EMISSION, "selfIllumination.", "RGB", false},
    {NAMING_VRAY, FEWRAY_EMISSION, "self_illumination.", "red,green,blue", false},
    {NAMING_VRAY, FEWRAY_EMISSION, "self_illumination.", "RGB", false},

    {NAMING_KARMA, FEWRAY_NORMAL, "hitN.", "XYZ", false},
    {NAMING_KARMA, FEWRAY_NORMAL, "hitN.", "RGB", false},
    {NAMING_KARMA, FEWRAY_NORMAL, "N.", "RGB", true},
    {NAMING_KARMA, FEWRAY_ALBEDO, "basecolor.", "RGB", false},

    {NAMING_AUTO, FEWRAY_COLOR, "rgba.", "RGB", false},
    {NAMING_AUTO, FEWRAY_COLOR, "rgb.", "RGB", false},
    {NAMING_AUTO, FEWRAY_COLOR, "beauty.", "RGB", false},
    {NAMING_AUTO, FEWRAY_COLOR, "color.", "RGB", false},
    {NAMING_AUTO, FEWRAY_COLOR, "C.", "RGB", false},
    {NAMING_AUTO, FEWRAY_COLOR, "subimage00.", "RGB", false},
    {NAMING_AUTO, FEWRAY_COLOR, "", "RGB", false},        /* written in small letters */
    {NAMING_AUTO, FEWRAY_EMISSION, "Env.", "RGB", false}, /* nothing else shines: backgrounds */
    {NAMING_AUTO, FEWRAY_EMISSION, "Environment.", "RGB", false},
    {NAMING_AUTO, FEWRAY_EMISSION, "background.", "RGB", false},
    {NAMING_AUTO, FEWRAY_EMISSION, "VRayBackground.", "RGB", false},
    {NAMING_AUTO, FEWRAY_DEPTH, "", "Z", false},
    {NAMING_AUTO, FEWRAY_DEPTH, "Z.", "Z", false},
    {NAMING_AUTO, FEWRAY_DEPTH, "Z.", "R", false},
    {NAMING_AUTO, FEWRAY_DEPTH, "depth.", "R", false},
};

static const char *const BACKGROUNDS[] = {"Env.", "Environment.", "background.", "VRayBackground.",
                                          NULL};

const struct layer_alias *layer_aliases(int *count) {
    *count = (int)(sizeof ALIASES / sizeof *ALIASES);
    return ALIASES;
}

const char *const *layer_backgrounds(void) {
    return BACKGROUNDS;
}
