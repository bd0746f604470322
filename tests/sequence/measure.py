#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""How much a denoised camera move flickers, and how far it is from the truth, with and without the frames before.

    python3 tests/sequence/measure.py SCENE.xml --fewray build/fewray --out DIR [--dolly 0.4] [--pan 6] [--frames 12]

The scene's camera drives forward by --dolly, sideways by --truck (scene units) and turns by --pan (degrees) over the frames. The
reference of each frame has --reference-spp samples and is denoised by itself: its own noise would hide that of the frames. With
d = (picture - reference) / sqrt(reference^2 + 0.01), as mrse has it:

    error     mean of d^2
    flicker   mean of (d of a frame - d of the frame before at the same pixel)^2

A picture that errs the same in every frame has an error and no flicker. "99 %" leaves out the worst 1 % of the pixels, which are
edges, glass and fireflies of references. References are kept in DIR and used again. Needs numpy and OpenEXR.
"""
import argparse
import json
import os
import re
import subprocess
import sys

import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "mitsuba"))
from exr import read  # noqa: E402


def unit(v):
    return v / np.linalg.norm(v)


def numbers(text):
    return np.array([float(x) for x in text.replace(",", " ").split()])


def camera_matrix(transform):
    """Of a sensor's to_world that is one lookat or one matrix."""
    matrix = re.search(r'<matrix\s+value="([^"]*)"', transform)
    if matrix:
        return numbers(matrix.group(1)).reshape(4, 4)
    origin, target, up = (numbers(re.search(name + r'="([^"]*)"', transform).group(1)) for name in ("origin", "target", "up"))
    m = np.eye(4)
    m[:3, 2] = unit(target - origin)
    m[:3, 0] = unit(np.cross(up, m[:3, 2]))
    m[:3, 1] = np.cross(m[:3, 2], m[:3, 0])
    m[:3, 3] = origin
    return m


def moved(m, dolly, truck, pan):
    c, s = np.cos(np.radians(pan)), np.sin(np.radians(pan))
    turn = np.array([[c, 0, s, 0], [0, 1, 0, 0], [-s, 0, c, 0], [0, 0, 0, 1.0]])
    there = m @ turn
    there[:3, 3] += dolly * m[:3, 2] + truck * m[:3, 0]
    return there


def write_move(args, path):
    text = open(args.scene).read()
    sensor = re.search(r"<sensor.*?</sensor>", text, re.S)
    transform = re.search(r'<transform name="to_world">.*?</transform>', sensor.group(0), re.S)
    first = camera_matrix(transform.group(0))
    keys = [(0, first), ((args.frames - 1) / 24, moved(first, args.dolly, args.truck, args.pan))]
    animation = '<animation name="to_world">' + "".join(
        '<transform time="%.9g"><matrix value="%s"/></transform>' % (t, " ".join("%.9g" % x for x in m.ravel())) for t, m in keys) + "</animation>"
    text = text.replace(transform.group(0), animation, 1)
    folder = os.path.dirname(os.path.abspath(args.scene))
    text = re.sub(r"(<scene[^>]*>)", lambda m: m.group(1) + '<path value="%s"/>' % folder, text, count=1)
    open(path, "w").write(text)


def render(args, scene, name, *options):
    command = [args.fewray, "render", scene, "-o", name, "--frames", "0..%d" % (args.frames - 1), "--width", str(args.width), "--float", *options]
    subprocess.run(command, check=True)


def load(pattern, frame):
    planes = read(pattern.replace("####", "%04d" % frame))
    return np.stack([planes[c] for c in "RGB"], -1).astype(np.float64)


def means(squares):
    """Mean over the pixels, and over the best 99 % of them."""
    pixels = np.sort(squares.mean(-1).ravel())
    return pixels.mean(), pixels[: int(0.99 * len(pixels))].mean()


def measure(args, pattern, references):
    error, flicker, before = [], [], None
    for t in range(args.frames):
        r = references[t]
        d = (load(pattern, t) - r) / np.sqrt(r * r + 0.01)
        error.append(means(d * d))
        if before is not None:
            flicker.append(means((d - before) ** 2))
        before = d
    return {name + part: float(np.mean(values, 0)[k]) for name, values in (("error", error), ("flicker", flicker))
            for k, part in enumerate(("", " 99 %"))}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene")
    parser.add_argument("--fewray", default="build/fewray")
    parser.add_argument("--out", required=True)
    parser.add_argument("--frames", type=int, default=12)
    parser.add_argument("--width", type=int, default=350)
    parser.add_argument("--spp", type=int, default=4)
    parser.add_argument("--reference-spp", type=int, default=256)
    parser.add_argument("--dolly", type=float, default=0.4)
    parser.add_argument("--truck", type=float, default=0)
    parser.add_argument("--pan", type=float, default=6)
    parser.add_argument("--seed", type=int, default=0)
    args = parser.parse_args()
    os.makedirs(args.out, exist_ok=True)
    scene = os.path.join(args.out, "move.xml")
    write_move(args, scene)
    reference = os.path.join(args.out, "reference.####.exr")
    render(args, scene, reference, "--spp", str(args.reference_spp), "--temporal", "off", "--skip-existing", "--seed", "1000")
    references = [load(reference, t) for t in range(args.frames)]
    results = {}
    for switch in ("off", "on"):
        name = os.path.join(args.out, "temporal-%s.####.exr" % switch)
        render(args, scene, name, "--spp", str(args.spp), "--temporal", switch, "--seed", str(args.seed))
        results[switch] = measure(args, name, references)
    for key in results["off"]:
        off, on = results["off"][key], results["on"][key]
        print("%-16s off %.6f   on %.6f   on / off %.3f" % (key, off, on, on / off))
    json.dump(results, open(os.path.join(args.out, "result.json"), "w"), indent=2)


if __name__ == "__main__":
    main()
