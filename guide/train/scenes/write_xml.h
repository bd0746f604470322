/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_TRAIN_WRITE_XML_H
#define FEWRAY_TRAIN_WRITE_XML_H

#include "guide/train/scenes/stage.h"

/* Writes a finished stage as Mitsuba 3 XML, a film of width x height pixels. sky_name: the sky's
 * file beside it, where the stage has a SKY_MAP. */
int stage_write_xml(const struct stage *stage, int width, int height, const char *path,
                    const char *sky_name, struct fewray_error *error);

#endif
