/* SPDX-License-Identifier: Apache-2.0 */
#define BUNDLE_NAME bundle_plain
#include "guide/trace/bundle.inc.h"
