// SPDX-License-Identifier: Apache-2.0
// The shim over OpenImageIO, the only file that knows it: pictures of any format in. It is the
// module "image". No exception leaves a function of this file.
#include "features/image_module.h"

#include <cstdlib>
#include <cstring>
#include <exception>
#include <memory>
#include <new>
#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <string>

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

int read_pixels(OIIO::ImageInput &input, const char *path, struct fewray_image &image,
                struct fewray_error *error) {
    const OIIO::ImageSpec &spec = input.spec();
    if (!features_size_ok(spec.width, spec.height) || spec.depth > 1 || spec.nchannels < 1)
        return fewray_fail(error, FEWRAY_ERROR_UNSUPPORTED, path, 0,
                           "an image of %d x %d x %d pixels with %d channels can't be used",
                           spec.width, spec.height, spec.depth, spec.nchannels);
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
    if (!input.read_image(0, 0, 0, image.channels,
                          is_bytes ? OIIO::TypeDesc::UINT8 : OIIO::TypeDesc::FLOAT, pixels))
        return fail_read(error, path, input.geterror());
    // Readers of some formats fill what a cut-off file lacks, and tell so only here. Surplus bytes
    // between the segments of a JPEG do no harm.
    const std::string complaint = input.geterror();
    if (!complaint.empty() && complaint.find("extraneous bytes") == std::string::npos)
        return fail_read(error, path, complaint);
    return FEWRAY_OK;
}

// A name whose ending makes OpenImageIO try the format that the first bytes tell.
std::string name_for(const void *bytes, size_t size, const char *path) {
    if (size >= 4 && std::memcmp(bytes, "\x89PNG", 4) == 0)
        return "memory.png";
    if (size >= 3 && std::memcmp(bytes, "\xff\xd8\xff", 3) == 0)
        return "memory.jpg";
    return path;
}

int open_and_read(const char *path, const void *bytes, size_t size, struct fewray_image &image,
                  struct fewray_error *error) {
    set_up_once();
    // Colours as they are stored, not multiplied by alpha.
    OIIO::ImageSpec wish;
    wish.attribute("oiio:UnassociatedAlpha", 1);
    OIIO::Filesystem::IOMemReader memory(const_cast<void *>(bytes), size);
    // The proxy goes by the wish as well, for open() forgets its own where it is given both.
    OIIO::Filesystem::IOProxy *proxy = bytes ? &memory : nullptr;
    if (proxy)
        wish.attribute("oiio:ioproxy", OIIO::TypeDesc::PTR, &proxy);
    const auto input =
        OIIO::ImageInput::open(bytes ? name_for(bytes, size, path) : path, &wish, proxy);
    if (!input)
        return fail_read(error, path, OIIO::geterror());
    const int status = read_pixels(*input, path, image, error);
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
