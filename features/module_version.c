/* SPDX-License-Identifier: Apache-2.0 */
/* Linked into every module: a module of another version has other tables of functions. */
#include "features/module.h"

const char fewray_module_version[] = FEWRAY_VERSION;
