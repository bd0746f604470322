#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Renders a scene by Mitsuba 3, guided by fewray: render.py SCENE.xml -o OUT.exr [--spp 4]"""

import argparse
import xml.etree.ElementTree as ET
from pathlib import Path

import mitsuba as mi


def set_child(parent, tag, name, value):
    child = next((c for c in parent.findall(tag) if c.get("name") == name), None)
    if child is None:
        child = ET.SubElement(parent, tag, name=name)
    child.set("value", str(value))


def load(path, width=None, height=None):
    """The scene with a box filter, and the maximum depth of its integrator. width, height: pixels; None: its own."""
    path = Path(path).resolve()
    root = ET.parse(path).getroot()
    depth = next((int(i.get("value")) for i in root.iter("integer") if i.get("name") == "max_depth"), -1)
    film = next(root.iter("film"))
    for name, value in (("width", width), ("height", height)):
        if value:
            set_child(film, "integer", name, value)
    for old in film.findall("rfilter"):
        film.remove(old)
    ET.SubElement(film, "rfilter", type="box")
    mi.file_resolver().prepend(str(path.parent))
    return mi.load_string(ET.tostring(root, encoding="unicode")), depth


def render(scene, integrator, max_depth, spp, seed):
    """A tensor (height, width, 3) of linear RGB, by `path` or `fewray_guided`."""
    made = mi.load_dict({"type": integrator, "max_depth": max_depth})
    return made.render(scene, spp=spp, seed=seed)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scene")
    parser.add_argument("-o", "--output", required=True, help="EXR to write")
    parser.add_argument("--spp", type=int, default=4, help="samples a pixel, one of them the look (4)")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--width", type=int, help="pixels")
    parser.add_argument("--height", type=int, help="pixels")
    parser.add_argument("--integrator", default="fewray_guided", choices=["fewray_guided", "path"])
    parser.add_argument("--variant", default="llvm_ad_rgb", help="of Mitsuba (llvm_ad_rgb)")
    options = parser.parse_args()
    mi.set_variant(options.variant)
    import guided  # noqa: F401  registers the integrator; wants the variant to be set
    scene, depth = load(options.scene, options.width, options.height)
    image = render(scene, options.integrator, depth, options.spp, options.seed)
    mi.Bitmap(image[:, :, :3]).write(options.output)
    print(f"{options.output}: {image.shape[1]}x{image.shape[0]} pixels, {options.spp} samples a pixel")


if __name__ == "__main__":
    main()
