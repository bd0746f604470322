/* SPDX-License-Identifier: Apache-2.0 */
/* Opens the module "opencv". */

#include "pipeline/opencv.h"

#include "features/module.h"

const struct opencv *opencv_open(struct fewray_error *error) {
    return fewray_module_symbol("opencv", "fewray_opencv", error);
}
