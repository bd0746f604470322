// SPDX-License-Identifier: Apache-2.0
// The shim over OpenImageIO, the only file that knows it: pictures of any format in, PNG out.
// No exception leaves a function of this file.
#include "features/features_private.h"

#include <cmath>
#include <cstdlib>
#include <exception>
#include <memory>
#include <new>
#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <string>
#include <vector>

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

int open_and_read(const char *path, struct fewray_image &image, struct fewray_error *error) {
    set_up_once();
    const int readable = file_check_readable(path, error);
    if (readable != FEWRAY_OK)
        return readable;
    if (png_is_damaged(path))
        return fail_read(error, path, "the PNG file is cut off or damaged");
    // Colours as they are stored, not multiplied by alpha.
    OIIO::ImageSpec wish;
    wish.attribute("oiio:UnassociatedAlpha", 1);
    const auto input = OIIO::ImageInput::open(path, &wish);
    if (!input)
        return fail_read(error, path, OIIO::geterror());
    const int status = read_pixels(*input, path, image, error);
    input->close();
    input->geterror();
    return status;
}

int encode_png(const char *path, int width, int height, const uint8_t *rgb,
               std::vector<unsigned char> &file, struct fewray_error *error) {
    set_up_once();
    const auto output = OIIO::ImageOutput::create("png");
    if (!output)
        return fewray_fail(error, FEWRAY_ERROR_UNSUPPORTED, path, 0,
                           "this OpenImageIO can't write PNG: %s", OIIO::geterror().c_str());
    OIIO::Filesystem::IOVecOutput memory(file);
    OIIO::ImageSpec spec(width, height, 3, OIIO::TypeDesc::UINT8);
    spec.attribute("oiio:ColorSpace", "sRGB");
    spec.attribute("Software", "fewray " FEWRAY_VERSION);
    if (!output->set_ioproxy(&memory) || !output->open("memory.png", spec) ||
        !output->write_image(OIIO::TypeDesc::UINT8, rgb) || !output->close())
        return fewray_fail(error, FEWRAY_ERROR_IO, path, 0, "can't encode the PNG: %s",
                           output->geterror().c_str());
    return FEWRAY_OK;
}

// IEC 61966-2-1; NaN becomes black.
uint8_t srgb_byte(float linear) {
    if (!(linear > 0.0f))
        return 0;
    if (linear >= 1.0f)
        return 255;
    const float encoded =
        linear <= 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1.0f / 2.4f) - 0.055f;
    return static_cast<uint8_t>(encoded * 255.0f + 0.5f);
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

} // namespace

int fewray_image_read(const char *path, struct fewray_image **out, struct fewray_error *error) {
    *out = static_cast<struct fewray_image *>(std::calloc(1, sizeof **out));
    if (!*out)
        return fewray_fail(error, FEWRAY_ERROR_MEMORY, path, 0, "out of memory");
    const int status = guarded(path, error, [&] { return open_and_read(path, **out, error); });
    if (status != FEWRAY_OK)
        fewray_image_destroy(out);
    return status;
}

void fewray_image_destroy(struct fewray_image **image) {
    if (!*image)
        return;
    std::free((*image)->bytes);
    std::free((*image)->floats);
    std::free(*image);
    *image = nullptr;
}

int fewray_image_write_png(const char *path, int width, int height, const uint8_t *rgb,
                           struct fewray_error *error) {
    if (!features_size_ok(width, height))
        return fewray_fail(error, FEWRAY_ERROR_ARGUMENT, path, 0,
                           "a picture of %d x %d pixels is impossible", width, height);
    return guarded(path, error, [&] {
        std::vector<unsigned char> file;
        const int status = encode_png(path, width, height, rgb, file, error);
        return status == FEWRAY_OK ? file_write_whole(path, file.data(), file.size(), error)
                                   : status;
    });
}

int fewray_frame_write_png(const struct fewray_frame *frame, const char *path,
                           struct fewray_error *error) {
    float *planes[3];
    if (!fewray_frame_layer(frame, FEWRAY_COLOR, planes))
        return fewray_fail(error, FEWRAY_ERROR_ARGUMENT, path, 0,
                           "the picture has no channels R, G, B");
    return guarded(path, error, [&] {
        const size_t pixels =
            static_cast<size_t>(frame->width) * static_cast<size_t>(frame->height);
        std::vector<uint8_t> rgb(pixels * 3);
        for (size_t i = 0; i < pixels; i++)
            for (size_t c = 0; c < 3; c++)
                rgb[3 * i + c] = srgb_byte(planes[c][i]);
        return fewray_image_write_png(path, frame->width, frame->height, rgb.data(), error);
    });
}
