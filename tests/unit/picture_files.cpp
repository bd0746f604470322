/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures of several parts for the tests of channel names. */

#include "picture_files.h"

#include <cstdio>
#include <string>
#include <vector>

#include <OpenImageIO/imageio.h>

namespace {

std::vector<std::string> split(const char *channels) {
    std::vector<std::string> names(1);
    for (; *channels; channels++)
        if (*channels == ',')
            names.emplace_back();
        else
            names.back() += *channels;
    return names;
}

OIIO::ImageSpec spec_of(const picture_part &part, int width, int height, bool half, int spp) {
    const std::vector<std::string> names = split(part.channels);
    OIIO::ImageSpec spec(width, height, static_cast<int>(names.size()),
                         half ? OIIO::TypeHalf : OIIO::TypeFloat);
    spec.channelnames = names;
    spec.attribute("compression", "zip");
    if (part.name)
        spec.attribute("oiio:subimagename", part.name);
    if (spp > 0)
        spec.attribute("samplesPerPixel", spp);
    return spec;
}

std::vector<float> pixels_of(int part, int channels, int count) {
    std::vector<float> values;
    for (int i = 0; i < count; i++)
        for (int c = 0; c < channels; c++)
            values.push_back(picture_value(part, c, i));
    return values;
}

} // namespace

bool picture_write(const char *path, int width, int height, bool half, int spp,
                   const picture_part *parts, int part_count) {
    auto file = OIIO::ImageOutput::create(path);
    std::vector<OIIO::ImageSpec> specs;
    for (int p = 0; p < part_count; p++)
        specs.push_back(spec_of(parts[p], width, height, half, spp));
    bool good = file && (part_count == 1 ? file->open(path, specs[0])
                                         : file->open(path, part_count, specs.data()));
    for (int p = 0; good && p < part_count; p++) {
        const std::vector<float> values = pixels_of(p, specs[p].nchannels, width * height);
        good = (p == 0 || file->open(path, specs[p], OIIO::ImageOutput::AppendSubimage)) &&
               file->write_image(OIIO::TypeFloat, values.data());
    }
    good = good && file->close();
    if (!good)
        std::fprintf(stderr, "%s: %s\n", path,
                     file ? file->geterror().c_str() : OIIO::geterror().c_str());
    return good;
}
