/* SPDX-License-Identifier: Apache-2.0 */
/* The JSON of `render --stats`, which `fewray composite` shows. */

#include <string.h>

#include "pipeline/stats.h"
#include "tests/fuzz/fuzz.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    char text[200];
    struct fewray_error error = {0};
    const int status =
        stats_read_summary(fuzz_file("stats.json", data, size), text, sizeof(text), &error);
    fuzz_check_error(status, &error);
    FUZZ_CHECK(status || memchr(text, 0, sizeof(text)));
    return 0;
}
