#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Makes seeds that no test writes: EXR files of every kind, images, and the weights of a small network.

    pip install OpenEXR pillow numpy
    python3 tests/fuzz/make_seeds.py FOLDER    # FOLDER/exr, FOLDER/texture, FOLDER/weights
"""

import pathlib
import struct
import sys
import zlib

import numpy
import OpenEXR
from PIL import Image

ROOT = pathlib.Path(__file__).resolve().parents[2]
WEIGHTS = ROOT / "denoise/train/weights/kpn_fast.bin"


def channels(width, height, kind=numpy.float16):
    values = (numpy.arange(width * height, dtype=numpy.float32) / 7).reshape(height, width).astype(kind)
    return {name: values for name in ("R", "G", "B", "A", "albedo.R", "albedo.G", "albedo.B")}


def deep(width, height):
    pixels = numpy.empty((height, width), dtype=object)
    for y in range(height):
        for x in range(width):
            pixels[y, x] = numpy.arange(1 + (x + y) % 3, dtype=numpy.float32)
    return {"R": pixels, "Z": pixels}


def write_exr(folder):
    compressions = ["NO", "RLE", "ZIPS", "ZIP", "PIZ", "PXR24", "B44", "DWAA"]
    for name in compressions:
        header = {"compression": getattr(OpenEXR, name + "_COMPRESSION"), "type": OpenEXR.scanlineimage}
        OpenEXR.File(header, channels(9, 11)).write(str(folder / f"scanline-{name.lower()}.exr"))
    for name in ("NO", "ZIP", "PIZ"):
        for mode in ("ONE_LEVEL", "MIPMAP_LEVELS", "RIPMAP_LEVELS"):
            tiles = OpenEXR.TileDescription()
            tiles.xSize, tiles.ySize, tiles.mode = 8, 4, getattr(OpenEXR, mode)
            header = {"compression": getattr(OpenEXR, name + "_COMPRESSION"), "type": OpenEXR.tiledimage,
                      "tiles": tiles}
            try:
                OpenEXR.File(header, channels(13, 7)).write(str(folder / f"tiled-{name.lower()}-{mode.lower()}.exr"))
            except RuntimeError as reason:
                print(f"tiled {mode}: {reason}", file=sys.stderr)
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    for kind in (numpy.float32, numpy.uint32):
        OpenEXR.File(header, channels(5, 6, kind)).write(str(folder / f"scanline-{kind.__name__}.exr"))
    for kind, name in ((OpenEXR.deepscanline, "scanline"), (OpenEXR.deeptile, "tile")):
        header = {"compression": OpenEXR.ZIPS_COMPRESSION, "type": kind}
        if kind == OpenEXR.deeptile:
            header["tiles"] = OpenEXR.TileDescription()
        try:
            OpenEXR.File(header, deep(4, 3)).write(str(folder / f"deep-{name}.exr"))
        except (RuntimeError, TypeError, ValueError) as reason:
            print(f"deep {name}: {reason}", file=sys.stderr)
    parts = [OpenEXR.Part({"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage},
                          {"R": numpy.ones((5, 4), numpy.float16), "G": numpy.ones((5, 4), numpy.float16),
                           "B": numpy.ones((5, 4), numpy.float16)}, name) for name in ("rgb", "albedo", "normal")]
    OpenEXR.File(parts).write(str(folder / "multipart.exr"))
    whole = (folder / "scanline-zip.exr").read_bytes()
    (folder / "truncated.exr").write_bytes(whole[:-20])


def write_images(folder):
    rgb = Image.fromarray((numpy.arange(9 * 7 * 3, dtype=numpy.uint32) % 256).astype(numpy.uint8).reshape(7, 9, 3))
    for name, picture in (("rgb", rgb), ("grey", rgb.convert("L")), ("palette", rgb.convert("P")),
                          ("rgba", rgb.convert("RGBA")), ("bits", rgb.convert("1"))):
        picture.save(folder / f"{name}.png")
    Image.fromarray(numpy.arange(63, dtype=numpy.uint16).reshape(7, 9) * 1000).save(folder / "grey16.png")
    rgb.save(folder / "baseline.jpg", quality=50)
    rgb.save(folder / "progressive.jpg", quality=50, progressive=True)
    rgb.convert("L").save(folder / "grey.jpg", quality=50)
    rgb.convert("CMYK").save(folder / "cmyk.jpg", quality=50)
    for ending in ("bmp", "tga", "ppm"):
        rgb.save(folder / f"rgb.{ending}")
    for compression in (None, "tiff_lzw", "tiff_adobe_deflate", "packbits"):
        rgb.save(folder / f"{compression}.tif", compression=compression)
    rle = b"".join(b"\x02\x02\x00\x09" + b"".join(bytes([0x80 + 9, value]) for value in (90, 60, 30, 129))
                   for _ in range(7))
    (folder / "rle.hdr").write_bytes(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=1\n\n-Y 7 +X 9\n" + rle)
    OpenEXR.File({"compression": OpenEXR.PIZ_COMPRESSION, "type": OpenEXR.scanlineimage},
                 channels(5, 4)).write(str(folder / "piz.exr"))


# Channels of the fast network's levels, and what they are cut to.
NARROW = {16: 2, 32: 3, 48: 2}
# Layers whose outputs have a meaning each.
WHOLE_OUTPUTS = ("scale", "parity", "kernel", "key", "down")


def cut(name, tensor):
    outputs, inputs = tensor.shape[:2]
    if not name.startswith(WHOLE_OUTPUTS):
        outputs = NARROW[outputs]
    if not name.startswith(("scale", "parity")):
        inputs = NARROW.get(inputs, inputs)
    return tensor[:outputs, :inputs]


def write_weights(folder):
    """The fast network with fewer channels in each level."""
    data = WEIGHTS.read_bytes()
    at = 20 + struct.unpack_from("<I", data, 16)[0]
    count, at = struct.unpack_from("<I", data, at)[0], at + 4
    body = struct.pack("<I", 2) + b"{}" + struct.pack("<I", count)
    for _ in range(count):
        name = data[at:at + NAME_BYTES]
        shape = struct.unpack_from("<4I", data, at + NAME_BYTES)
        size = int(numpy.prod(shape))
        at += NAME_BYTES + 16
        narrow = cut(name.decode(), numpy.frombuffer(data, numpy.float16, size, at).reshape(shape))
        body += name + struct.pack("<4I", *narrow.shape) + narrow.tobytes()
        at += 2 * size
    (folder / "narrow.bin").write_bytes(b"FEWRAYNN" + struct.pack("<II", 1, zlib.crc32(body)) + body)


NAME_BYTES = 48


def main():
    out = pathlib.Path(sys.argv[1])
    for name in ("exr", "texture", "weights"):
        (out / name).mkdir(parents=True, exist_ok=True)
    write_exr(out / "exr")
    write_images(out / "texture")
    write_weights(out / "weights")


if __name__ == "__main__":
    main()
