/* SPDX-License-Identifier: Apache-2.0 */
/* The page from its first byte to its last: page.html, with each {{name}} replaced by what belongs
 * there. */

#include "pipeline/page/page.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "denoise/nn/embed.h"

size_t page_html_size(void);
size_t page_css_size(void);
size_t page_js_size(void);
NN_EMBED(page_html, PAGE_HTML)
NN_EMBED(page_css, PAGE_CSS)
NN_EMBED(page_js, PAGE_JS)

/* The last part of the folder's real name, of "." too. */
static void put_title(const struct page *page) {
    char real[PATH_MAX];
    const char *slash = realpath(page->options->folder, real) ? strrchr(real, '/') : NULL;
    html_text(page->file, page->options->title ? page->options->title
                          : slash && slash[1]  ? slash + 1
                                               : page->options->folder);
}

/* Fills the place of one name of the template. */
static int put_part(struct page *page, const char *name, size_t length,
                    struct fewray_error *error) {
    char part[16] = "";
    memcpy(part, name, length < sizeof part ? length : sizeof part - 1);
    if (!strcmp(part, "title"))
        put_title(page);
    else if (!strcmp(part, "version"))
        fputs(FEWRAY_VERSION, page->file);
    else if (!strcmp(part, "style"))
        fwrite(page_css, 1, page_css_size(), page->file);
    else if (!strcmp(part, "script"))
        fwrite(page_js, 1, page_js_size(), page->file);
    else if (!strcmp(part, "pictures"))
        return page_pictures(page, error);
    else if (!strcmp(part, "table"))
        page_table(page);
    else if (!strcmp(part, "curves"))
        page_curves(page);
    else if (!strcmp(part, "made"))
        page_made(page);
    else
        fprintf(page->file, "{{%s}}", part);
    return FEWRAY_OK;
}

/* Copies the template, and fills its places. */
static int put_page(struct page *page, struct fewray_error *error) {
    const char *rest = (const char *)page_html, *end = rest + page_html_size();
    int status = FEWRAY_OK;
    while (!status && !ferror(page->file)) {
        const char *open = memmem(rest, (size_t)(end - rest), "{{", 2);
        const char *close = open ? memmem(open, (size_t)(end - open), "}}", 2) : NULL;
        fwrite(rest, 1, (size_t)((close ? open : end) - rest), page->file);
        if (!close)
            break;
        status = put_part(page, open + 2, (size_t)(close - open - 2), error);
        rest = close + 2;
    }
    return status;
}

/* What the page's stream writes to. */
struct sink {
    int descriptor;
    int reason; /* errno of the first failure; 0 */
};

static ssize_t sink_write(void *cookie, const char *data, size_t size) {
    struct sink *sink = cookie;
    size_t done = 0;
    while (done < size && !sink->reason) {
        const ssize_t part = write(sink->descriptor, data + done, size - done);
        if (part > 0)
            done += (size_t)part;
        else if (part == 0 || errno != EINTR)
            sink->reason = part == 0 ? ENOSPC : errno;
    }
    return (ssize_t)done; /* less than size is a failure to the stream */
}

static int sink_close(void *cookie) {
    struct sink *sink = cookie;
    if (close(sink->descriptor) && !sink->reason)
        sink->reason = errno;
    return sink->reason ? EOF : 0;
}

/* Opens the page's stream onto a new file; false, with the reason, where that can't be. */
static bool open_sink(struct page *page, struct sink *sink, const char *path) {
    const cookie_io_functions_t calls = {.write = sink_write, .close = sink_close};
    sink->descriptor = open(path, O_CREAT | O_EXCL | O_WRONLY | O_CLOEXEC, 0666);
    page->file = sink->descriptor < 0 ? NULL : fopencookie(sink, "w", calls);
    if (page->file)
        return true;
    sink->reason = errno;
    if (sink->descriptor >= 0)
        close(sink->descriptor);
    return false;
}

/* Writes beside the page's place, then renames. */
static int put_file(struct page *page, const char *path, struct fewray_error *error) {
    struct sink sink = {-1, 0};
    int status = fewray_check_replaceable(path, error);
    char *temporary = status ? NULL : fewray_temporary_name(path);
    if (!temporary)
        return status ? status
                      : fewray_fail(error, FEWRAY_ERROR_MEMORY, path, 0, "no memory for its name");
    if (open_sink(page, &sink, temporary)) {
        status = put_page(page, error);
        fclose(page->file);
    }
    if (!status && sink.reason)
        status = fewray_fail(error, FEWRAY_ERROR_IO, path, 0, "can't write the file: %s",
                             strerror(sink.reason));
    if (!status)
        status = fewray_commit_file(temporary, path, error);
    fewray_discard_file(temporary);
    free(temporary);
    return status;
}

static void release(struct page *page) {
    page_folder_release(&page->folder);
    fewray_frame_destroy(&page->reference);
    for (int i = 0; i <= PAGE_FILES_MAX; i++)
        json_decref(page->stats[i]);
    json_decref(page->bench);
    free(page->rows);
}

int page_write(const struct page_options *options, struct fewray_error *error) {
    struct page page = {.options = options, .noisy_row = -1};
    char path[PAGE_PATH_MAX];
    int status = page_folder_read(options, &page.folder, error);
    if (!status)
        status = page_join(options->folder, "report.html", path, error);
    if (!status && page.folder.bench[0])
        status = page_read_json(page.folder.bench, &page.bench, error);
    if (!status && !(page.rows = calloc(PAGE_ROWS_MAX, sizeof *page.rows)))
        status = fewray_fail(error, FEWRAY_ERROR_MEMORY, path, 0, "no memory for the rows");
    if (!status)
        status = put_file(&page, options->output ? options->output : path, error);
    release(&page);
    return status;
}
