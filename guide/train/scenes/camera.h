/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_TRAIN_CAMERA_H
#define FEWRAY_TRAIN_CAMERA_H

#include "guide/train/scenes/stage.h"

/* Finds a camera that sees something, and scales all lights so that its picture's mean is right.
 * False where none of many tries is good: build another scene. */
bool choose_camera(struct stage *stage, float aspect);

#endif
