/* SPDX-License-Identifier: Apache-2.0 */
/* The sums that the renderers' manuals promise (their places: layer_aliases.c). */

#include "pipeline/pass_recipes.h"

static const struct pass_term FEWRAY_PARTS[] = {{"direct", 0, 0}, {"indirect", 0, 0}, {0}};

/* Blender's manual, "Passes", "Combining": (direct + indirect) * colour of each lobe. */
static const struct pass_term BLENDER_LOBES[] = {
    {"Diffuse Direct|DiffDir", "Diffuse Color|DiffCol", 0},
    {"Diffuse Indirect|DiffInd", "Diffuse Color|DiffCol", 0},
    {"Glossy Direct|GlossDir", "Glossy Color|GlossCol", 0},
    {"Glossy Indirect|GlossInd", "Glossy Color|GlossCol", 0},
    {"Transmission Direct|TransDir", "Transmission Color|TransCol", 0},
    {"Transmission Indirect|TransInd", "Transmission Color|TransCol", 0},
    {"Subsurface Direct|SubsurfaceDir", "Subsurface Color|SubsurfaceCol", 0},
    {"Subsurface Indirect|SubsurfaceInd", "Subsurface Color|SubsurfaceCol", 0},
    {"Volume Direct|VolumeDir", 0, 0},
    {"Volume Indirect|VolumeInd", 0, 0},
    {0}};
static const struct pass_term BLENDER_LIGHTS[] = {{"Combined_*", 0, 0}, {0}};

static const struct pass_term ARNOLD_BOUNCES[] = {{"direct", 0, 0}, {"indirect", 0, 0}, {0}};
static const struct pass_term ARNOLD_LOBES[] = {{"diffuse", 0, "diffuse_direct"},
                                                {"diffuse_direct", 0, 0},
                                                {"diffuse_indirect", 0, 0},
                                                {"specular", 0, "specular_direct"},
                                                {"specular_direct", 0, 0},
                                                {"specular_indirect", 0, 0},
                                                {"coat", 0, "coat_direct"},
                                                {"coat_direct", 0, 0},
                                                {"coat_indirect", 0, 0},
                                                {"sheen", 0, "sheen_direct"},
                                                {"sheen_direct", 0, 0},
                                                {"sheen_indirect", 0, 0},
                                                {"transmission", 0, "transmission_direct"},
                                                {"transmission_direct", 0, 0},
                                                {"transmission_indirect", 0, 0},
                                                {"sss", 0, "sss_direct"},
                                                {"sss_direct", 0, 0},
                                                {"sss_indirect", 0, 0},
                                                {"volume", 0, "volume_direct"},
                                                {"volume_direct", 0, 0},
                                                {"volume_indirect", 0, 0},
                                                {0}};
static const struct pass_term ARNOLD_LIGHTS[] = {{"RGBA_*", 0, 0}, {0}};

static const struct pass_term RENDERMAN_DENOISE[] = {{"diffuse", 0, 0}, {"specular", 0, 0}, {0}};
static const struct pass_term RENDERMAN_PARTS[] = {{"directDiffuse", 0, 0},
                                                   {"indirectDiffuse", 0, 0},
                                                   {"directSpecular", 0, 0},
                                                   {"indirectSpecular", 0, 0},
                                                   {"subsurface", 0, 0},
                                                   {"transmissive", 0, 0},
                                                   {0}};
static const struct pass_term RENDERMAN_LOBES[] = {{"directDiffuseLobe", 0, 0},
                                                   {"indirectDiffuseLobe", 0, 0},
                                                   {"directSpecularPrimaryLobe", 0, 0},
                                                   {"indirectSpecularPrimaryLobe", 0, 0},
                                                   {"directSpecularRoughLobe", 0, 0},
                                                   {"indirectSpecularRoughLobe", 0, 0},
                                                   {"directSpecularClearcoatLobe", 0, 0},
                                                   {"indirectSpecularClearcoatLobe", 0, 0},
                                                   {"directSpecularGlassLobe", 0, 0},
                                                   {"indirectSpecularGlassLobe", 0, 0},
                                                   {"subsurfaceLobe", 0, 0},
                                                   {"transmissiveGlassLobe", 0, 0},
                                                   {0}};

/* docs.chaos.com, "Back to Beauty". */
static const struct pass_term VRAY_ELEMENTS[] = {
    {"VRayGlobalIllumination|gi|globalIllumination", 0, 0},
    {"VRayLighting|lighting|light", 0, 0},
    {"VRayReflection|reflection|reflect", 0, 0},
    {"VRayRefraction|refraction|refract", 0, 0},
    {"VRaySpecular|specular", 0, 0},
    {"VRaySSS2|sss|sss2", 0, 0},
    {"VRayCaustics|caustics", 0, 0},
    {"VRayAtmosphere|atmosphere|atmospheric_effects", 0, 0},
    {0}};
static const struct pass_term VRAY_LIGHTS[] = {{"VRayLightSelect*|light_select*", 0, 0}, {0}};

static const struct pass_term KARMA_LOBES[] = {
    {"combineddiffuse", 0, "directdiffuse"},
    {"directdiffuse", 0, 0},
    {"indirectdiffuse", 0, 0},
    {"combinedglossyreflection", 0, "directglossyreflection"},
    {"directglossyreflection", 0, 0},
    {"indirectglossyreflection", 0, 0},
    {"glossytransmission", 0, 0},
    {"coat", 0, 0},
    {"sss", 0, 0},
    {"combinedvolume", 0, "directvolume"},
    {"directvolume", 0, 0},
    {"indirectvolume", 0, 0},
    {"combinedemission", 0, 0},
    {0}};
static const struct pass_term KARMA_LIGHTS[] = {{"C_*", 0, 0}, {0}};

static const struct pass_recipe RECIPES[] = {
    {NAMING_FEWRAY, "direct and indirect light", false, true, FEWRAY_PARTS},
    {NAMING_BLENDER, "lobes", true, false, BLENDER_LOBES},
    {NAMING_BLENDER, "light groups", false, false, BLENDER_LIGHTS},
    {NAMING_ARNOLD, "direct and indirect light", true, false, ARNOLD_BOUNCES},
    {NAMING_ARNOLD, "lobes", true, false, ARNOLD_LOBES},
    {NAMING_ARNOLD, "light groups", false, false, ARNOLD_LIGHTS},
    {NAMING_RENDERMAN, "diffuse and specular light", false, false, RENDERMAN_DENOISE},
    {NAMING_RENDERMAN, "direct and indirect light", true, false, RENDERMAN_PARTS},
    {NAMING_RENDERMAN, "lobes", true, false, RENDERMAN_LOBES},
    {NAMING_VRAY, "elements", true, false, VRAY_ELEMENTS},
    {NAMING_VRAY, "lights", false, false, VRAY_LIGHTS},
    {NAMING_KARMA, "lobes", false, false, KARMA_LOBES},
    {NAMING_KARMA, "light groups", false, false, KARMA_LIGHTS},
};

const struct pass_recipe *pass_recipes(int *count) {
    *count = (int)(sizeof RECIPES / sizeof *RECIPES);
    return RECIPES;
}
