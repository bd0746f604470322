/* SPDX-License-Identifier: Apache-2.0 */
/* Gives stored inputs to a fuzz target, without a fuzzer: replay FILE|FOLDER... */

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/fuzz/fuzz.h"

/* False where there is no such file. */
static bool run_file(const char *path) {
    FILE *file = fopen(path, "rb");
    if (!file)
        return false;
    fseek(file, 0, SEEK_END);
    const long size = ftell(file);
    rewind(file);
    /* Exactly the size, so that a sanitizer sees reads beyond it. */
    uint8_t *data = size < 0 ? NULL : malloc(size ? (size_t)size : 1);
    const bool whole = data && fread(data, 1, (size_t)size, file) == (size_t)size;
    fclose(file);
    if (whole) {
        printf("%s, %ld bytes\n", path, size);
        fflush(stdout); /* the last line names the input that ended the program */
        LLVMFuzzerTestOneInput(data, (size_t)size);
    }
    free(data);
    return whole;
}

/* The number of files run, or -1. */
static int run_folder(const char *path) {
    struct dirent **entries;
    const int count = scandir(path, &entries, NULL, alphasort);
    int run = 0;
    for (int i = 0; i < count; i++) {
        char name[1024];
        snprintf(name, sizeof(name), "%s/%s", path, entries[i]->d_name);
        if (run >= 0 && entries[i]->d_name[0] != '.')
            run = run_file(name) ? run + 1 : -1;
        free(entries[i]);
    }
    if (count >= 0)
        free(entries);
    return count < 0 ? -1 : run;
}

int main(int argc, char **argv) {
    int total = 0;
    for (int i = 1; i < argc; i++) {
        int run = run_folder(argv[i]);
        if (run < 0)
            run = run_file(argv[i]) ? 1 : -1;
        if (run < 0) {
            fprintf(stderr, "%s can't be read\n", argv[i]);
            return 2;
        }
        total += run;
    }
    printf("%d inputs\n", total);
    return total > 0 ? 0 : 1;
}
