#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""IN.exr OUT.exr: the colour of a picture that `fewray render --float` wrote, with stderr.R/G/B, the standard error of each pixel's mean,
as references by other renderers have it: the root of its variance."""
import array
import math
import struct
import sys
import zlib


def attributes(data):
    """(name -> value bytes, where the header ends)"""
    at, found = 8, {}
    while data[at]:
        name, kind = data[at:].split(b"\0", 2)[:2]
        at += len(name) + len(kind) + 2
        size, = struct.unpack_from("<I", data, at)
        found[name.decode()] = data[at + 4:at + 4 + size]
        at += 4 + size
    return found, at + 1


def unzip(packed, size):
    if len(packed) == size:
        return packed
    coded = bytearray(zlib.decompress(packed))
    for i in range(1, size):  # differences
        coded[i] = (coded[i] + coded[i - 1] - 128) & 255
    plain = bytearray(size)  # even bytes first, then odd ones
    plain[0::2], plain[1::2] = coded[:(size + 1) // 2], coded[(size + 1) // 2:]
    return bytes(plain)


def read(path):
    """(width, height, name -> rows of floats)"""
    data = open(path, "rb").read()
    header, at = attributes(data)
    x0, y0, x1, y1 = struct.unpack("<4i", header["dataWindow"])
    width, height = x1 - x0 + 1, y1 - y0 + 1
    names, rest = [], header["channels"]
    while rest[0]:
        name, rest = rest.split(b"\0", 1)
        names.append(name.decode())
        rest = rest[16:]
    planes = {name: [] for name in names}
    at += 8 * ((height + 15) // 16)
    for top in range(0, height, 16):
        _, size = struct.unpack_from("<iI", data, at)
        rows = min(16, height - top)
        block = unzip(data[at + 8:at + 8 + size], rows * len(names) * width * 4)
        at += 8 + size
        for k in range(rows * len(names)):
            planes[names[k % len(names)]].append(array.array("f", block[4 * width * k:4 * width * (k + 1)]))
    return width, height, planes


def write(path, width, height, planes):
    def attribute(name, kind, value):
        return name + b"\0" + kind + b"\0" + struct.pack("<I", len(value)) + value

    names = sorted(planes)
    channels = b"".join(name.encode() + b"\0" + struct.pack("<iIii", 2, 0, 1, 1) for name in names) + b"\0"
    window = struct.pack("<4i", 0, 0, width - 1, height - 1)
    header = b"\x76\x2f\x31\x01\x02\0\0\0" + attribute(b"channels", b"chlist", channels) + \
        attribute(b"compression", b"compression", b"\0") + attribute(b"dataWindow", b"box2i", window) + \
        attribute(b"displayWindow", b"box2i", window) + attribute(b"lineOrder", b"lineOrder", b"\0") + \
        attribute(b"pixelAspectRatio", b"float", struct.pack("<f", 1)) + \
        attribute(b"screenWindowCenter", b"v2f", struct.pack("<2f", 0, 0)) + \
        attribute(b"screenWindowWidth", b"float", struct.pack("<f", 1)) + b"\0"
    size = 4 * width * len(names)
    with open(path, "wb") as file:
        file.write(header)
        for y in range(height):
            file.write(struct.pack("<Q", len(header) + 8 * height + y * (8 + size)))
        for y in range(height):
            file.write(struct.pack("<iI", y, size) + b"".join(planes[name][y].tobytes() for name in names))


def main():
    width, height, planes = read(sys.argv[1])
    out = {name: planes[name] for name in "RGB"}
    for name in "RGB":
        out["stderr." + name] = [array.array("f", map(math.sqrt, row)) for row in planes["variance." + name]]
    write(sys.argv[2], width, height, out)


if __name__ == "__main__":
    main()
