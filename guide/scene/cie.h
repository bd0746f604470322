/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_SCENE_CIE_H
#define FEWRAY_GUIDE_SCENE_CIE_H

/* Colour matching functions of the CIE's standard observer of 1931 (2 degrees), x, y, z, and the
 * spectral power of its illuminant D65 (100 at 560 nm). */

#define CIE_FIRST 360 /* nm */
#define CIE_STEP  5
#define CIE_COUNT 95

extern const double cie_curves[CIE_COUNT][4];

#endif
