/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_ZIP_H
#define FEWRAY_ZIP_H

/* The blocks of EXR's ZIP and ZIPS compression: bytes at even places before those at odd ones,
 * differences of neighbours (modulo 256, plus 128), and a zlib stream of these (OpenEXR file
 * layout, "Compression"). By libdeflate, which is two to three times as fast as zlib. */

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct libdeflate_compressor;
struct libdeflate_decompressor;

/* What one thread needs for its blocks, used again by the next one; 0-initialised. */
struct zip_worker {
    struct libdeflate_compressor *compressor;
    struct libdeflate_decompressor *decompressor;
    uint8_t *filtered, *packed;
    size_t filtered_size, packed_size; /* bytes that there is room for */
};
void zip_worker_clear(struct zip_worker *worker);

/* Compresses a block. *packed (in worker, or raw itself where nothing is gained) and *packed_size
 * are what a file gets. False without memory. */
bool zip_pack(struct zip_worker *worker, const uint8_t *raw, size_t size, const uint8_t **packed,
              size_t *packed_size);

enum zip_result { ZIP_OK, ZIP_DAMAGED, ZIP_NO_MEMORY };

/* The block's `size` bytes from what zip_pack() made shorter. */
enum zip_result zip_unpack(struct zip_worker *worker, const uint8_t *packed, size_t packed_size,
                           uint8_t *raw, size_t size);

#endif
