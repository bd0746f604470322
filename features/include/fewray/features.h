/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_FEATURES_H
#define FEWRAY_FEATURES_H

/* Pictures as named float planes, read from and written to OpenEXR; textures through
 * OpenImageIO. This folder knows no other. OpenImageIO stands in a module, the shared object
 * fewray_image.so, which is opened by the first image: a program that links this library and reads
 * images has it beside itself, in the installed lib/fewray, or in the folder that the
 * environment variable FEWRAY_MODULE_PATH names (features/module.h). */

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#ifdef __cplusplus
extern "C" {
#endif

#define FEWRAY_API __attribute__((visibility("default")))

/* Every function that can fail returns one of these; 0 is success. */
enum fewray_status {
    FEWRAY_OK = 0,
    FEWRAY_ERROR_IO = -1,          /* a file can't be opened, read or written */
    FEWRAY_ERROR_FORMAT = -2,      /* a file's content is damaged or not what it should be */
    FEWRAY_ERROR_UNSUPPORTED = -3, /* valid, but fewray can't do it */
    FEWRAY_ERROR_MEMORY = -4,
    FEWRAY_ERROR_ARGUMENT = -5, /* the caller asked for something impossible */
    FEWRAY_ERROR_CANCELLED = -6,
};

/* What went wrong, where, and what to do. file is empty and line 0 where they say nothing. */
struct fewray_error {
    char file[512];
    int line;
    char what[512];
};

/* Fills *error (may be NULL) from a printf format and returns status, so that a failing function
 * can `return fewray_fail(...)`. file may be NULL, line 0. Newlines in the text become spaces. */
FEWRAY_API int fewray_fail(struct fewray_error *error, enum fewray_status status, const char *file,
                           int line, const char *format, ...) __attribute__((format(printf, 5, 6)));

/* Writes "FILE:LINE: what" (or "FILE: what", or "what") into text, cut at size bytes; returns text.
 */
FEWRAY_API const char *fewray_error_text(const struct fewray_error *error, char *text, size_t size);

/* --- memory */

/* Bytes that this process may have: the least of the machine's memory, its control group's and its
 * own limits (ulimit -v, -d). */
FEWRAY_API uint64_t fewray_memory_limit(void);
/* Refuses what a file or an option announces, "a film of 65536 x 65536 pixels" say, where its bytes
 * are more than that, so that nothing is allocated for it. path: for the message, may be NULL. */
FEWRAY_API int fewray_memory_check(const char *path, const char *what, double bytes,
                                   struct fewray_error *error);

/* --- frame: the named float planes of one picture */

#define FEWRAY_NAME_MAX 64

struct fewray_plane {
    char name[FEWRAY_NAME_MAX]; /* EXR channel name, "R" or "albedo.R" */
    float *data;                /* (height, width), row 0 on top; owned by the frame */
    uint16_t *half; /* data's place in a compact plane, whose data is NULL: IEEE binary16, finite */
};

/* A text that a file's header carries. */
struct fewray_attribute {
    char name[FEWRAY_NAME_MAX]; /* "fewray.seed" */
    char *text;                 /* owned by the frame */
};

struct fewray_frame {
    int width, height; /* pixels */
    int spp;           /* samples a pixel, where a file's header tells (samplesPerPixel); else 0 */
    size_t plane_count;
    struct fewray_plane *planes;
    size_t attribute_count;
    struct fewray_attribute *attributes;
};

/* The layers fewray writes (radiance: W/(m^2 sr) in the scene's units, Rec. 709 primaries). */
enum fewray_layer {
    FEWRAY_COLOR,    /* R G B: the result */
    FEWRAY_NOISY,    /* noisy.R/G/B: the render before the denoiser */
    FEWRAY_VARIANCE, /* variance.R/G/B of the pixel's mean, radiance^2 */
    /* Of the first vertex: the first surface on the camera ray that isn't perfectly specular. */
    FEWRAY_ALBEDO, /* albedo.R/G/B, 0..1, times what mirrors and glass before let through; 0 where
                      the camera ray misses */
    FEWRAY_SHADED_ALBEDO, /* shaded_albedo.R/G/B: of the very samples that the colour is made of;
                             albedo itself may come from more camera rays */
    FEWRAY_NORMAL,        /* normal.X/Y/Z, world space, mean over the pixel's samples */
    FEWRAY_DEPTH,         /* depth.Z: the way to there in scene units, 0 = miss */
    FEWRAY_EMISSION,   /* emission.R/G/B: radiance emitted on the way to there and by it, or by the
                          background */
    FEWRAY_IRRADIANCE, /* irradiance.R/G/B / pi: the guide's estimate of (radiosity / albedo)
                          there */
    FEWRAY_IRRADIANCE_CONFIDENCE, /* irradiance.confidence: 0 = no estimate, to 1 = as good as
                                     known: I^2 / (I^2 + variance of I) */
    FEWRAY_LAYER_COUNT
};

/* Channel names of a layer; *count gets 3, or 1 for depth. The strings are static. */
FEWRAY_API const char *const *fewray_layer_channels(enum fewray_layer layer, int *count);

/* A frame without planes. *out is owned by the caller: fewray_frame_destroy(). */
FEWRAY_API int fewray_frame_create(int width, int height, struct fewray_frame **out,
                                   struct fewray_error *error);
FEWRAY_API void fewray_frame_destroy(struct fewray_frame **frame);

/* Adds a plane of zeros and returns its data (owned by the frame, 64-byte aligned); the existing
 * data where a plane of that name exists; NULL without memory, with too long a name or where the
 * plane is compact. Earlier returned pointers stay valid. */
FEWRAY_API float *fewray_frame_add(struct fewray_frame *frame, const char *name);
/* The data of a plane, or NULL; compact planes have none. */
FEWRAY_API float *fewray_frame_plane(const struct fewray_frame *frame, const char *name);
/* Removes a plane, where there is one of that name. */
FEWRAY_API void fewray_frame_remove(struct fewray_frame *frame, const char *name);
/* Sets a text of the header, for fewray_frame_write_exr(), replacing an older one; false without
 * memory or with too long a name. Names start with "fewray.": others aren't read back. */
FEWRAY_API bool fewray_frame_set_attribute(struct fewray_frame *frame, const char *name,
                                           const char *text);
/* The text, or NULL. */
FEWRAY_API const char *fewray_frame_attribute(const struct fewray_frame *frame, const char *name);
/* Adds all channels of a layer: planes[0..2] (planes[0] alone for depth). False without memory. */
FEWRAY_API bool fewray_frame_add_layer(struct fewray_frame *frame, enum fewray_layer layer,
                                       float *planes[3]);
/* Finds all channels of a layer; false (and NULLs) where any misses. */
FEWRAY_API bool fewray_frame_layer(const struct fewray_frame *frame, enum fewray_layer layer,
                                   float *planes[3]);

/* Makes the layers that guide a denoiser (all but colour and noisy) compact, where half floats hold
 * each value to the bit, as after reading a file of half floats: half the memory. Other functions
 * of this header take them as missing, but for fewray_frame_write_exr(), for which nothing
 * changes. */
FEWRAY_API void fewray_frame_compact(struct fewray_frame *frame);
/* Finds a layer of compact planes alone, as fewray_frame_layer(). */
FEWRAY_API bool fewray_frame_compact_layer(const struct fewray_frame *frame,
                                           enum fewray_layer layer, const uint16_t *planes[3]);
/* The value of a finite half float. */
static inline float fewray_half_value(uint16_t half) {
    const uint32_t shifted = (uint32_t)(half & 0x7fff) << 13;
    float value;
    memcpy(&value, &shifted, sizeof value);
    value *=
        5192296858534827628530496329220096.f; /* 2^112: exponents of floats have another bias */
    return half & 0x8000 ? -value : value;
}

/* Reads every channel of an EXR file (scanline or tiled, half, float or uint; subsampled channels
 * and deep pictures are refused; no compression, RLE, ZIPS, ZIP, PIZ or PXR24) into a frame of the
 * first part's data window. Of the other parts those of the same window are read, too: their
 * channels go by the part's name, "albedo" and "R" to "albedo.R", unless they have a layer's name
 * before a dot already; of equal names the first part's is taken. Prints nothing. Truncated files
 * are an error. *out is owned by the caller. */
FEWRAY_API int fewray_frame_read_exr(const char *path, struct fewray_frame **out,
                                     struct fewray_error *error);

/* The same without pixels: a frame of the right size, with the attributes and no planes. */
FEWRAY_API int fewray_frame_read_exr_header(const char *path, struct fewray_frame **out,
                                            struct fewray_error *error);

/* Writes all planes as one scanline ZIP part: half floats, or 32-bit floats where float32 is set.
 * As half floats, values are rounded to the nearest even and clamped to +-65504, infinities too, so
 * that no viewer meets one; those below 2^-25 become 0; NaN stays NaN. The file appears whole or
 * not at all: written beside as a temporary file, then renamed; on failure nothing is left and an
 * older file at path is untouched. */
FEWRAY_API int fewray_frame_write_exr(const struct fewray_frame *frame, const char *path,
                                      bool float32, struct fewray_error *error);

/* What the header of an EXR file says of one of its parts. */
struct fewray_exr_channel {
    char *name;
    const char *type; /* "half", "float" or "uint" */
};
struct fewray_exr_attribute {
    char *name, *text; /* the value as people write it, "2/2", "1 0 0 1"; cut after 4000 bytes */
    const char *type;  /* "string", "m44f", ... */
};
struct fewray_exr_part {
    char *name; /* "" where it has none */
    bool tiled, deep;
    const char *compression;               /* "ZIP" */
    int data_window[4], display_window[4]; /* least x, y, greatest x, y */
    int channel_count, attribute_count;
    struct fewray_exr_channel *channels;
    struct fewray_exr_attribute *attributes; /* but for those above and channels */
};
struct fewray_exr_header {
    int part_count;
    struct fewray_exr_part *parts;
};
/* Reads it, also of files whose pixels fewray_frame_read_exr() can't read. *out is owned by the
 * caller. */
FEWRAY_API int fewray_exr_header_read(const char *path, struct fewray_exr_header **out,
                                      struct fewray_error *error);
FEWRAY_API void fewray_exr_header_destroy(struct fewray_exr_header **header);

/* A channel that is new or has new pixels. */
struct fewray_exr_change {
    const char *name;  /* as fewray_frame_read_exr() calls the plane */
    const float *data; /* (height, width) of the first part's data window */
};

/* Copies the EXR file `source` to path with these channels changed. Those that it has keep their
 * type, half floats as fewray_frame_write_exr() makes them, unless float32 is set; the others are
 * added to the part that has the first one, as its type is. All else is kept bit for bit: other
 * channels and parts, also those that a frame has no planes for, every attribute, windows, tiles,
 * compression. Of a part that changes mipmap levels go, and a decreasing order of lines becomes an
 * increasing one. source must be one that fewray_frame_read_exr() reads, without deep parts; path
 * may be source. The file appears whole or not at all. */
FEWRAY_API int fewray_exr_rewrite(const char *source, const struct fewray_exr_change *changes,
                                  int count, bool float32, const char *path,
                                  struct fewray_error *error);

/* What of R, G, B half floats can't show: *clipped gets the number of pixels that have a value
 * above 65504, *lost that of pixels with light that become black. 0 without colour. */
FEWRAY_API void fewray_frame_half_losses(const struct fewray_frame *frame, size_t *clipped,
                                         size_t *lost);

/* Replaces NaN, infinities and (in all layers but normals) negative values of the known layers:
 * colour, noisy, emission by the median of the good pixels around (0 where none), others by 0.
 * Radiance above 1e5 (half floats' own range) is replaced likewise where it stands alone and
 * exceeds 1000 times that median; else it is cut at 1e12. Albedo is cut at 1, normals at +-1,
 * variance at 1e24 and depth at 1e10. Returns the number of pixels with replaced values. The only
 * place where bad pixels of a file are mended. */
FEWRAY_API size_t fewray_frame_repair(struct fewray_frame *frame);

/* The same for one more plane of radiance, the size of the frame's. */
FEWRAY_API void fewray_frame_repair_radiance(const struct fewray_frame *frame, float *data);

/* --- atomic files: for whoever writes an output file that isn't an EXR (stats, PNG) */

/* Name of a temporary file beside path (in the same folder), malloc'd; NULL without memory. */
FEWRAY_API char *fewray_temporary_name(const char *path);
/* Refuses a path that is there and isn't a regular file: none of the writers replaces such. */
FEWRAY_API int fewray_check_replaceable(const char *path, struct fewray_error *error);
/* Renames temporary to path; on failure removes temporary and reports path. */
FEWRAY_API int fewray_commit_file(const char *temporary, const char *path,
                                  struct fewray_error *error);
/* Removes temporary instead, where it is there. errno is kept. */
FEWRAY_API void fewray_discard_file(const char *temporary);
/* Makes path of these bytes, whole or not at all. */
FEWRAY_API int fewray_write_file(const char *path, const void *data, size_t size,
                                 struct fewray_error *error);
/* Removes all temporary files of this process, which is about to end; a signal handler may call
 * it. */
FEWRAY_API void fewray_discard_all_files(void);

/* --- images: read through OpenImageIO (the module "image"), PNG written by libpng */

struct fewray_image {
    int width, height,
        channels;   /* row 0 on top, (height, width, channels), interleaved; channels 1, 3 or 4 */
    uint8_t *bytes; /* 8-bit files; NULL where floats is set */
    float *floats;  /* float, half and 16-bit files, linear as stored; NULL where bytes is set */
};

/* Reads a PNG, JPEG, HDR, EXR, ... Grey+alpha becomes grey. *out is owned by the caller.
 * Thread-safe. */
FEWRAY_API int fewray_image_read(const char *path, struct fewray_image **out,
                                 struct fewray_error *error);
/* The same from the bytes of a PNG, JPEG, ... file in memory; name is for messages. */
FEWRAY_API int fewray_image_read_memory(const char *name, const void *bytes, size_t size,
                                        struct fewray_image **out, struct fewray_error *error);
FEWRAY_API void fewray_image_destroy(struct fewray_image **image);

/* Writes (height, width, 3) bytes, sRGB-encoded, as PNG; whole or not at all. */
FEWRAY_API int fewray_image_write_png(const char *path, int width, int height, const uint8_t *rgb,
                                      struct fewray_error *error);
/* Writes the R, G, B planes of a frame as an 8-bit sRGB PNG (clamped to 0..1). */
FEWRAY_API int fewray_frame_write_png(const struct fewray_frame *frame, const char *path,
                                      struct fewray_error *error);

#ifdef __cplusplus
}
#endif
#endif
