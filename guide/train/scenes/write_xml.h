/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_TRAIN_WRITE_XML_H
#define FEWRAY_TRAIN_WRITE_XML_H

#include "guide/train/scenes/stage.h"

/* Writes a finished stage as Mitsuba 3 XML, a film of width x height pixels. prefix: of the names
 * of the files beside it: PREFIX-sky.exr, textures/PREFIX-K.png, meshes/PREFIX-K.obj. */
int stage_write_xml(const struct stage *stage, int width, int height, const char *path,
                    const char *prefix, struct fewray_error *error);

#endif
