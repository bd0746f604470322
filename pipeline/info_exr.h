/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_PIPELINE_INFO_EXR_H
#define FEWRAY_PIPELINE_INFO_EXR_H

/* What `fewray info` says of an EXR. */

#include "fewray/features.h"

/* Prints on stdout: size, channels and their values, what `fewray denoise` takes each layer from
 * and what it lacks, which passes sum up to the picture, other layers, metadata; as one JSON object
 * where as_json is set. */
int info_exr(const char *path, bool as_json, struct fewray_error *error);

#endif
