// SPDX-License-Identifier: Apache-2.0
/* EXRs of any make, written and compared by OpenImageIO. */

#include "foreign_file.h"

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

#include <OpenImageIO/deepdata.h>
#include <OpenImageIO/imageio.h>

namespace {

std::vector<std::string> split(const std::string &text) {
    std::vector<std::string> parts;
    std::string part;
    for (const char c : text + ",") {
        if (c != ',')
            part += c;
        else if (!part.empty())
            parts.push_back(part), part.clear();
    }
    return parts;
}

OIIO::TypeDesc type_of(const std::string &name) {
    return name == "half" ? OIIO::TypeHalf : name == "uint" ? OIIO::TypeUInt : OIIO::TypeFloat;
}

void add_attributes(OIIO::ImageSpec &spec) {
    static const float matrix[16] = {1, 0, 0, 0, 0, 0.5f, 0.25f, 0, 0, -1, 1, 0, 3, 4, 5, 1};
    static const float chromaticities[8] = {0.7f, 0.3f, 0.2f, 0.8f, 0.1f, 0.05f, 0.31f, 0.33f};
    static const float vector[3] = {1.5f, -2, 3};
    static const uint32_t timecode[2] = {0x01234516u, 7};
    spec.attribute("comments", "what the artist wrote");
    spec.attribute("capDate", "2026:01:02 03:04:05");
    spec.attribute("cryptomatte/542cafa/manifest", std::string(3000, 'm'));
    spec.attribute("cycles.ViewLayer.synchronization_time", "00:00.01");
    spec.attribute("samples", 64);
    spec.attribute("exposure", 1.25f);
    spec.attribute("worldToCamera", OIIO::TypeMatrix, matrix);
    spec.attribute("chromaticities", OIIO::TypeDesc(OIIO::TypeDesc::FLOAT, 8), chromaticities);
    spec.attribute("eye", OIIO::TypeVector, vector);
    spec.attribute("smpte:TimeCode", OIIO::TypeTimeCode, timecode);
}

OIIO::ImageSpec spec_of(const foreign_make &make, const foreign_part &part) {
    OIIO::ImageSpec spec(part.window[2], part.window[3], 0, OIIO::TypeHalf);
    spec.x = part.window[0];
    spec.y = part.window[1];
    spec.full_x = make.display[0];
    spec.full_y = make.display[1];
    spec.full_width = make.display[2];
    spec.full_height = make.display[3];
    spec.tile_width = spec.tile_height = make.tile;
    for (const std::string &channel : split(part.channels)) {
        const size_t colon = channel.find(':');
        spec.channelnames.push_back(channel.substr(0, colon));
        spec.channelformats.push_back(type_of(channel.substr(colon + 1)));
    }
    spec.nchannels = static_cast<int>(spec.channelnames.size());
    spec.attribute("compression", make.compression);
    if (make.line_order)
        spec.attribute("openexr:lineOrder", make.line_order);
    if (part.name)
        spec.attribute("oiio:subimagename", part.name);
    add_attributes(spec);
    return spec;
}

std::vector<uint8_t> pixels_of(const OIIO::ImageSpec &spec, int part) {
    std::vector<float> values;
    for (int i = 0; i < spec.width * spec.height; i++)
        for (int c = 0; c < spec.nchannels; c++)
            values.push_back(0.015625f * static_cast<float>(1 + part * 8 + c + 16 * (i % 7)));
    std::vector<uint8_t> bytes(spec.image_bytes(true));
    uint8_t *to = bytes.data();
    for (size_t k = 0; k < values.size(); k++) {
        const OIIO::TypeDesc type = spec.channelformat(static_cast<int>(k) % spec.nchannels);
        const uint32_t id = 0xfffffff0u - static_cast<uint32_t>(k); /* no float holds it */
        if (type == OIIO::TypeUInt)
            std::memcpy(to, &id, sizeof id);
        else
            OIIO::convert_types(OIIO::TypeFloat, &values[k], type, to, 1);
        to += type.size();
    }
    return bytes;
}

std::vector<uint8_t> channel_bits(OIIO::ImageInput &file, int part, int c,
                                  const OIIO::ImageSpec &spec) {
    const OIIO::TypeDesc type = spec.channelformat(c);
    std::vector<uint8_t> bytes(spec.image_pixels() * type.size());
    if (!file.read_image(part, 0, c, c + 1, type, bytes.data()))
        bytes.clear();
    return bytes;
}

std::string compare_specs(const OIIO::ImageSpec &a, const OIIO::ImageSpec &b) {
    if (a.x != b.x || a.y != b.y || a.width != b.width || a.height != b.height)
        return "data window";
    if (a.full_x != b.full_x || a.full_y != b.full_y || a.full_width != b.full_width ||
        a.full_height != b.full_height)
        return "display window";
    if (a.tile_width != b.tile_width || a.tile_height != b.tile_height)
        return "tiles";
    for (const auto &attribute : a.extra_attribs) {
        const OIIO::ParamValue *other = b.find_attribute(attribute.name().string());
        if (attribute.name() == "openexr:lineOrder" || attribute.name() == "openexr:chunkCount")
            continue;
        if (!other || other->type() != attribute.type() ||
            other->get_string(0) != attribute.get_string(0))
            return "attribute " + attribute.name().string();
    }
    return "";
}

std::string compare_channels(OIIO::ImageInput &a, OIIO::ImageInput &b, int part,
                             const std::vector<std::string> &changed) {
    const OIIO::ImageSpec &of_a = a.spec(part), &of_b = b.spec(part);
    for (int c = 0; c < of_a.nchannels; c++) {
        const std::string &name = of_a.channelnames[static_cast<size_t>(c)];
        const int other = of_b.channelindex(name);
        if (other < 0 || of_a.channelformat(c) != of_b.channelformat(other))
            return "type of " + name;
        if (std::find(changed.begin(), changed.end(), name) == changed.end() &&
            channel_bits(a, part, c, of_a) != channel_bits(b, part, other, of_b))
            return "pixels of " + name;
    }
    return "";
}

} // namespace

bool foreign_write(const char *path, const foreign_make *make) {
    auto file = OIIO::ImageOutput::create(path);
    std::vector<OIIO::ImageSpec> specs;
    for (int p = 0; p < 4 && make->parts[p].channels; p++)
        specs.push_back(spec_of(*make, make->parts[p]));
    const int count = static_cast<int>(specs.size());
    bool good =
        file && (count == 1 ? file->open(path, specs[0]) : file->open(path, count, specs.data()));
    for (int p = 0; good && p < count; p++) {
        const std::vector<uint8_t> bytes = pixels_of(specs[static_cast<size_t>(p)], p);
        good = (p == 0 || file->open(path, specs[static_cast<size_t>(p)],
                                     OIIO::ImageOutput::AppendSubimage)) &&
               file->write_image(OIIO::TypeUnknown, bytes.data());
    }
    good = good && file->close();
    if (!good)
        std::fprintf(stderr, "%s: %s\n", make->what,
                     file ? file->geterror().c_str() : OIIO::geterror().c_str());
    return good;
}

bool foreign_write_deep(const char *path, int width, int height) {
    auto file = OIIO::ImageOutput::create(path);
    OIIO::ImageSpec spec(width, height, 3, OIIO::TypeFloat);
    spec.channelnames = {"A", "Z", "ZBack"};
    spec.deep = true;
    OIIO::DeepData deep(spec);
    for (int i = 0; i < width * height; i++)
        deep.set_samples(i, i % 3);
    return file && file->open(path, spec) && file->write_deep_image(deep) && file->close();
}

bool foreign_is_kept(const char *a, const char *b, const char *changed, char *why, size_t size) {
    auto of_a = OIIO::ImageInput::open(a), of_b = OIIO::ImageInput::open(b);
    std::string fault = of_a && of_b ? "" : "one of them can't be opened";
    int part = 0;
    for (; fault.empty() && of_a->seek_subimage(part, 0); part++) {
        if (!of_b->seek_subimage(part, 0))
            fault = "parts";
        if (fault.empty())
            fault = compare_specs(of_a->spec(part), of_b->spec(part));
        if (fault.empty())
            fault = compare_channels(*of_a, *of_b, part, split(changed));
    }
    if (fault.empty() && of_b->seek_subimage(part, 0))
        fault = "more parts";
    std::snprintf(why, size, "part %d: %s", part - 1, fault.c_str());
    return fault.empty();
}
