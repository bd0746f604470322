/* SPDX-License-Identifier: Apache-2.0 */
/* Files of a render's state. */

#include "pipeline/checkpoint.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

#include "guide/odis/maps.h"
#include "guide/odis/probes.h"
#include "guide/trace/film.h"

#define MAGIC     "FEWRAYCP"
#define VERSION   1
#define CHUNK     ((size_t)1 << 20) /* bytes read or written at once */
#define REMOVE_OR "remove it to start anew"

struct header {
    char magic[8];
    uint32_t version, crc; /* of the bytes after it */
    uint64_t bytes;        /* after the header */
};
#define CRC_FROM offsetof(struct header, bytes)

void checkpoint_info_init(struct checkpoint_info *info) {
    const size_t sizes[] = {sizeof(struct pixel_group),    sizeof(struct map),
                            sizeof(struct look_record),    sizeof(struct look_second),
                            sizeof(struct probe),          map_sums_bytes(),
                            sizeof(struct voxel_table),    sizeof(struct fewray_render_stats),
                            sizeof(struct checkpoint_info)};
    memset(info, 0, sizeof *info); /* its padding, too */
    info->layout = (uint32_t)crc32(0, (const Bytef *)sizes, sizeof sizes);
    snprintf(info->program, sizeof info->program, "%s", FEWRAY_VERSION);
}

/* --- out */

struct output {
    FILE *file;
    uint32_t crc;
    uint64_t bytes;
};

static bool put(void *user, const void *bytes, size_t size) {
    struct output *out = user;
    out->crc = (uint32_t)crc32_z(out->crc, bytes, size);
    out->bytes += size;
    return fwrite(bytes, 1, size, out->file) == size;
}

/* The CRC begins with the number of bytes, which is known in the end: CRCs can be combined. */
static bool put_all(FILE *file, const struct checkpoint_info *info, checkpoint_body body,
                    void *user) {
    struct header header = {.magic = MAGIC, .version = VERSION};
    struct output out = {.file = file};
    if (fwrite(&header, sizeof header, 1, file) != 1 || !put(&out, info, sizeof *info) ||
        !body(user, put, &out))
        return false;
    header.bytes = out.bytes;
    const uLong head = crc32_z(0, (const Bytef *)&header + CRC_FROM, sizeof header - CRC_FROM);
    header.crc = (uint32_t)crc32_combine(head, out.crc, (z_off_t)out.bytes);
    return !fseek(file, 0, SEEK_SET) && fwrite(&header, sizeof header, 1, file) == 1 &&
           !fflush(file) && !fsync(fileno(file));
}

static void sync_file(const char *path, int kind) {
    const int fd = open(path, O_RDONLY | O_CLOEXEC | kind);
    if (fd < 0)
        return;
    fsync(fd);
    close(fd);
}

/* A name is safe only when its folder is. */
void checkpoint_sync(const char *path) {
    const char *slash = strrchr(path, '/');
    char *folder = slash ? strndup(path, (size_t)(slash - path) + 1) : strdup(".");
    sync_file(path, O_NONBLOCK);
    if (folder)
        sync_file(folder, O_DIRECTORY);
    free(folder);
}

int checkpoint_write(const char *path, const struct checkpoint_info *info, checkpoint_body body,
                     void *user, struct fewray_error *error) {
    char *temporary = fewray_temporary_name(path);
    if (!temporary)
        return fewray_fail(error, FEWRAY_ERROR_MEMORY, path, 0, "no memory for a file name");
    errno = 0;
    FILE *file = fopen(temporary, "wbxe");
    bool written = file != NULL;
    if (file) {
        setvbuf(file, NULL, _IOFBF, CHUNK);
        written = put_all(file, info, body, user);
    }
    int fault = written ? 0 : errno;
    if (file && fclose(file) && written) {
        written = false;
        fault = errno;
    }
    int status;
    if (written) {
        status = fewray_commit_file(temporary, path, error);
    } else {
        fewray_discard_file(temporary);
        status = fewray_fail(error, FEWRAY_ERROR_IO, path, 0, "can't write the checkpoint: %s",
                             strerror(fault ? fault : EIO));
    }
    if (!status)
        checkpoint_sync(path);
    free(temporary);
    return status;
}

/* --- in */

static int damaged(const char *path, const char *what, struct fewray_error *error) {
    return fewray_fail(error, FEWRAY_ERROR_FORMAT, path, 0,
                       "the checkpoint is damaged (%s); " REMOVE_OR, what);
}

/* All bytes after the header, by their CRC. */
static int check_bytes(FILE *file, const char *path, const struct header *header,
                       struct fewray_error *error) {
    unsigned char *chunk = malloc(CHUNK);
    if (!chunk)
        return fewray_fail(error, FEWRAY_ERROR_MEMORY, path, 0, "no memory for the checkpoint");
    uLong crc = crc32_z(0, (const Bytef *)header + CRC_FROM, sizeof *header - CRC_FROM);
    uint64_t bytes = 0;
    for (size_t got; (got = fread(chunk, 1, CHUNK, file)) > 0; bytes += got)
        crc = crc32_z(crc, chunk, got);
    const int fault = ferror(file) ? errno : 0;
    free(chunk);
    if (fault)
        return fewray_fail(error, FEWRAY_ERROR_IO, path, 0, "can't read the checkpoint: %s",
                           strerror(fault));
    if (bytes != header->bytes)
        return damaged(path, bytes < header->bytes ? "it is cut off" : "bytes follow its end",
                       error);
    return crc == header->crc ? FEWRAY_OK : damaged(path, "its checksum differs", error);
}

static bool is_text(const char *text, size_t size) {
    return memchr(text, 0, size) != NULL;
}

static int read_info(FILE *file, const char *path, const struct header *header,
                     struct checkpoint_info *info, struct fewray_error *error) {
    struct checkpoint_info own;
    checkpoint_info_init(&own);
    if (header->bytes < sizeof *info || fseek(file, sizeof *header, SEEK_SET) ||
        fread(info, sizeof *info, 1, file) != 1)
        return damaged(path, "it is cut off", error);
    const struct part_label *label = &info->label;
    if (!is_text(info->program, sizeof info->program) ||
        !is_text(label->seed, sizeof label->seed) ||
        !is_text(label->fingerprint, sizeof label->fingerprint) ||
        !is_text(label->scene, sizeof label->scene) ||
        !is_text(label->settings, sizeof label->settings))
        return damaged(path, "a text has no end", error);
    if (strcmp(info->program, own.program) || info->layout != own.layout)
        return fewray_fail(error, FEWRAY_ERROR_UNSUPPORTED, path, 0,
                           "the checkpoint was written by another build of fewray (%s); go on with "
                           "that one, or " REMOVE_OR,
                           info->program);
    return FEWRAY_OK;
}

static int read_head(FILE *file, const char *path, struct checkpoint_file *out,
                     struct fewray_error *error) {
    struct header header;
    const size_t got = fread(&header, 1, sizeof header, file);
    if (got < sizeof header.magic || memcmp(header.magic, MAGIC, sizeof header.magic))
        return fewray_fail(error, FEWRAY_ERROR_FORMAT, path, 0,
                           "this is no checkpoint; give another name");
    if (got < sizeof header)
        return damaged(path, "it is cut off", error);
    if (header.version != VERSION)
        return fewray_fail(error, FEWRAY_ERROR_UNSUPPORTED, path, 0,
                           "the checkpoint is of version %" PRIu32 ", only %d is known; " REMOVE_OR,
                           header.version, VERSION);
    int status = check_bytes(file, path, &header, error);
    if (!status)
        status = read_info(file, path, &header, &out->info, error);
    out->left = header.bytes - sizeof out->info;
    return status;
}

int checkpoint_open(const char *path, bool must_exist, struct checkpoint_file *out,
                    struct fewray_error *error) {
    *out = (struct checkpoint_file){.path = path};
    const int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (fd < 0 && errno == ENOENT && !must_exist)
        return FEWRAY_OK;
    if (fd < 0)
        return fewray_fail(error, FEWRAY_ERROR_IO, path, 0, "can't open the checkpoint: %s",
                           strerror(errno));
    struct stat about;
    FILE *file = NULL;
    if (fstat(fd, &about) || !S_ISREG(about.st_mode) || !(file = fdopen(fd, "rb"))) {
        close(fd);
        return fewray_fail(error, FEWRAY_ERROR_IO, path, 0, "the checkpoint is no regular file");
    }
    out->file = file;
    const int status = read_head(file, path, out, error);
    if (status)
        checkpoint_close(out);
    return status;
}

void checkpoint_close(struct checkpoint_file *file) {
    if (file->file)
        fclose(file->file);
    file->file = NULL;
}

bool checkpoint_read(void *user, void *bytes, size_t size) {
    struct checkpoint_file *in = user;
    return size == 0 || fread(bytes, size, 1, in->file) == 1;
}

/* --- whose state it is */

/* The first "name=value" in which two lists of the same names differ. */
static const char *first_difference(const char *a, const char *b, int *length_a, int *length_b) {
    size_t word = 0, i = 0;
    for (; a[i] && a[i] == b[i]; i++)
        if (a[i] == ' ')
            word = i + 1;
    *length_a = (int)strcspn(a + word, " ");
    *length_b = (int)strcspn(b + word, " ");
    return a + word;
}

static void describe_part(const struct part_label *label, char *text, size_t size) {
    if (label->parts)
        snprintf(text, size, "part %d of %d", label->part, label->parts);
    else
        snprintf(text, size, "a whole picture");
}

/* What the checkpoint is of, and what it should be of; empty where they are the same. */
static void describe_difference(const struct part_label *found, const struct part_label *wanted,
                                char *text, size_t size) {
    int old_length, length;
    char old_part[48], part[48];
    text[0] = 0;
    if (strcmp(found->fingerprint, wanted->fingerprint)) {
        snprintf(text, size, "another scene, or one that has changed since: %.150s", found->scene);
    } else if (found->width != wanted->width || found->height != wanted->height) {
        snprintf(text, size, "%dx%d pixels, not %dx%d", found->width, found->height, wanted->width,
                 wanted->height);
    } else if (found->part != wanted->part || found->parts != wanted->parts) {
        describe_part(found, old_part, sizeof old_part);
        describe_part(wanted, part, sizeof part);
        snprintf(text, size, "%s, not %s", old_part, part);
    } else if (strcmp(found->seed, wanted->seed)) {
        snprintf(text, size, "seed %s, not %s", found->seed, wanted->seed);
    } else if (strcmp(found->settings, wanted->settings)) {
        const char *old = first_difference(found->settings, wanted->settings, &old_length, &length);
        const char *now = wanted->settings + (old - found->settings);
        snprintf(text, size, "%.*s, not %.*s", old_length < 100 ? old_length : 100, old,
                 length < 100 ? length : 100, now);
    }
}

int checkpoint_check(const struct checkpoint_file *file, const struct part_label *label,
                     struct fewray_error *error) {
    char difference[300];
    describe_difference(&file->info.label, label, difference, sizeof difference);
    return difference[0]
               ? fewray_fail(error, FEWRAY_ERROR_ARGUMENT, file->path, 0,
                             "the checkpoint is of %s; give the same options, or " REMOVE_OR,
                             difference)
               : FEWRAY_OK;
}
