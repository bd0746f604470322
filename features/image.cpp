// SPDX-License-Identifier: Apache-2.0
// The shim over OpenImageIO, the only file that knows it: pictures of any format in. It is the
// module "image". No exception leaves a function of this file.
#include "features/image_module.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <memory>
#include <new>
#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <string>
#include <string_view>
#include <strings.h>

#include "features/features_private.h"

namespace {

// OpenImageIO's settings are global. Loaders call it from threads of their own, so its pools would
// only add threads; and it may not print errors that nobody asked for.
void set_up_once() {
    static const bool done = [] {
        OIIO::attribute("threads", 1);
        OIIO::attribute("exr_threads", -1);
        OIIO::attribute("oiio:print_uncaught_errors", 0);
        return true;
    }();
    (void)done;
}

int fail_read(struct fewray_error *error, const char *path, const std::string &reason) {
    return fewray_fail(error, FEWRAY_ERROR_FORMAT, path, 0, "can't read the image: %s",
                       reason.empty() ? "it is damaged or of an unknown format" : reason.c_str());
}

// Which of the file's channels are kept: grey, RGB or RGBA.
int channels_kept(const OIIO::ImageSpec &spec) {
    if (spec.nchannels < 3)
        return 1;
    return spec.nchannels == 3 || (spec.nchannels > 4 && spec.alpha_channel != 3) ? 3 : 4;
}

// Some rows at a time, up to the first failure: OpenImageIO collects a message of each strip or
// tile, and ends the program where they come to 16 MB.
bool read_rows(OIIO::ImageInput &input, const struct fewray_image &image, OIIO::TypeDesc type,
               void *pixels) {
    const OIIO::ImageSpec &spec = input.spec();
    const bool tiled = spec.tile_width > 0;
    const size_t row_bytes =
        static_cast<size_t>(image.width) * static_cast<size_t>(image.channels) * type.size();
    const int rows = tiled ? spec.tile_height : 1024;
    if (rows < 1)
        return false;
    bool good = true;
    for (int y = 0; y < image.height && good; y += std::min(rows, image.height - y)) {
        void *to = static_cast<char *>(pixels) + static_cast<size_t>(y) * row_bytes;
        const int begin = spec.y + y, end = begin + std::min(rows, image.height - y);
        good = tiled ? input.read_tiles(0, 0, spec.x, spec.x + spec.width, begin, end, spec.z,
                                        spec.z + 1, 0, image.channels, type, to)
                     : input.read_scanlines(0, 0, begin, end, spec.z, 0, image.channels, type, to);
    }
    return good;
}

int read_pixels(OIIO::ImageInput &input, const char *path, struct fewray_image &image,
                struct fewray_error *error) {
    const OIIO::ImageSpec &spec = input.spec();
    image.width = spec.width;
    image.height = spec.height;
    image.channels = channels_kept(spec);
    const size_t values = static_cast<size_t>(spec.width) * static_cast<size_t>(spec.height) *
                          static_cast<size_t>(image.channels);
    const bool is_bytes = spec.format == OIIO::TypeDesc::UINT8;
    void *pixels = std::calloc(values, is_bytes ? sizeof(uint8_t) : sizeof(float));
    if (!pixels)
        return fewray_fail(error, FEWRAY_ERROR_MEMORY, path, 0, "out of memory");
    if (is_bytes)
        image.bytes = static_cast<uint8_t *>(pixels);
    else
        image.floats = static_cast<float *>(pixels);
    if (!read_rows(input, image, is_bytes ? OIIO::TypeDesc::UINT8 : OIIO::TypeDesc::FLOAT, pixels))
        return fail_read(error, path, input.geterror());
    // Readers of some formats fill what a cut-off file lacks, and tell so only here. Surplus bytes
    // between the segments of a JPEG do no harm.
    const std::string complaint = input.geterror();
    if (!complaint.empty() && complaint.find("extraneous bytes") == std::string::npos)
        return fail_read(error, path, complaint);
    return FEWRAY_OK;
}

// What a file may be, by its first bytes. OpenImageIO would try one reader after the other, old
// and little used ones too, on a file that nobody knows.
struct format {
    const char *reader;
    std::string_view magic;
    bool bounded; // makes at most FEATURES_MAX_RATIO bytes of one
};
using namespace std::string_view_literals;
const format formats[] = {
    {"png", "\x89PNG"sv, true},     {"jpeg", "\xff\xd8\xff"sv, false},
    {"openexr", "v/1\x01"sv, true}, {"hdr", "#?"sv, true},
    {"tiff", "II*\0"sv, true},      {"tiff", "MM\0*"sv, true},
    {"tiff", "II+\0"sv, true},      {"bmp", "BM"sv, true},
    {"webp", "RIFF"sv, false},      {"pnm", "P1"sv, true},
    {"pnm", "P2"sv, true},          {"pnm", "P3"sv, true},
    {"pnm", "P4"sv, true},          {"pnm", "P5"sv, true},
    {"pnm", "P6"sv, true},          {"pnm", "Pf"sv, true},
    {"pnm", "PF"sv, true},
};
const format targa = {"targa", ""sv, true}; // has no first bytes of its own

bool ends_in_tga(std::string_view path) {
    return path.size() >= 4 && !strcasecmp(path.data() + path.size() - 4, ".tga");
}

const format *find_format(const char *path, const void *bytes, size_t size) {
    char first[8] = {};
    if (bytes) {
        std::memcpy(first, bytes, std::min(size, sizeof first));
    } else if (std::FILE *file = std::fopen(path, "rbe")) {
        size = std::fread(first, 1, sizeof first, file);
        std::fclose(file);
    }
    const std::string_view start(first, std::min(size, sizeof first));
    for (const format &each : formats)
        if (start.substr(0, each.magic.size()) == each.magic)
            return &each;
    return ends_in_tga(path) ? &targa : nullptr;
}

// Refuses what the file can't hold and what would fill the memory, before any of it is allocated.
int check_size(const OIIO::ImageSpec &spec, const char *path, const format &format, size_t size,
               struct fewray_error *error) {
    if (!features_size_ok(spec.width, spec.height) || spec.depth > 1 || spec.nchannels < 1)
        return fewray_fail(error, FEWRAY_ERROR_UNSUPPORTED, path, 0,
                           "an image of %d x %d x %d pixels with %d channels can't be used",
                           spec.width, spec.height, spec.depth, spec.nchannels);
    const double pixels = static_cast<double>(spec.width) * spec.height;
    const double raw = pixels * static_cast<double>(spec.pixel_bytes(true));
    // OpenImageIO counts a byte where a file has a bit.
    if (format.bounded && raw / 8 > static_cast<double>(size) * FEATURES_MAX_RATIO)
        return fewray_fail(error, FEWRAY_ERROR_FORMAT, path, 0,
                           "damaged or cut off: the file can't hold %d x %d pixels", spec.width,
                           spec.height);
    const std::string what = "an image of " + std::to_string(spec.width) + " x " +
                             std::to_string(spec.height) + " pixels";
    return fewray_memory_check(path, what.c_str(), raw + pixels * 4 * channels_kept(spec), error);
}

int open_and_read(const char *path, const void *bytes, size_t size, struct fewray_image &image,
                  struct fewray_error *error) {
    set_up_once();
    const format *format = find_format(path, bytes, size);
    if (!format)
        return fewray_fail(error, FEWRAY_ERROR_UNSUPPORTED, path, 0,
                           "can't read the image: it is no PNG, JPEG, HDR, EXR, TIFF, TGA, BMP, "
                           "PNM or WebP file");
    // Colours as they are stored, not multiplied by alpha.
    OIIO::ImageSpec wish, spec;
    wish.attribute("oiio:UnassociatedAlpha", 1);
    OIIO::Filesystem::IOMemReader memory(const_cast<void *>(bytes), size);
    OIIO::Filesystem::IOProxy *proxy = bytes ? &memory : nullptr;
    if (proxy)
        wish.attribute("oiio:ioproxy", OIIO::TypeDesc::PTR, &proxy);
    const auto input = OIIO::ImageInput::create(format->reader);
    if (!input)
        return fail_read(error, path, OIIO::geterror());
    if (!input->open(path, spec, wish))
        return fail_read(error, path, input->geterror());
    int status = check_size(input->spec(), path, *format, size, error);
    if (status == FEWRAY_OK)
        status = read_pixels(*input, path, image, error);
    input->close();
    input->geterror();
    return status;
}

// Runs work, which may throw, and turns what it throws into an error about path.
template <typename Work> int guarded(const char *path, struct fewray_error *error, Work work) {
    try {
        return work();
    } catch (const std::bad_alloc &) {
        return fewray_fail(error, FEWRAY_ERROR_MEMORY, path, 0, "out of memory");
    } catch (const std::exception &e) {
        return fewray_fail(error, FEWRAY_ERROR_FORMAT, path, 0, "%s", e.what());
    } catch (...) {
        return fewray_fail(error, FEWRAY_ERROR_FORMAT, path, 0, "unknown failure");
    }
}

int read(const char *path, const void *bytes, size_t size, struct fewray_image *image,
         struct fewray_error *error) {
    return guarded(path, error, [&] { return open_and_read(path, bytes, size, *image, error); });
}

} // namespace

const struct image_module fewray_image_module = {read};
