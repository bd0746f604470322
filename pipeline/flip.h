/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_PIPELINE_FLIP_H
#define FEWRAY_PIPELINE_FLIP_H

/* LDR-FLIP: the difference that a person sees who flips between two pictures (Andersson, Nilsson,
 * Akenine-Moeller, Oskarsson, Astrom, Fairchild 2020, "FLIP: A Difference Evaluator for Alternating
 * Images"). C++, inside the module "opencv". */

#include <opencv2/core.hpp>

/* Mean FLIP, 0..1, of two pictures seen at 67 pixels per degree: (height, width, 3) floats each,
 * RGB as a display emits it, linear in 0..1. Throws what OpenCV throws. */
double flip_mean(const cv::Mat &test, const cv::Mat &reference);

#endif
