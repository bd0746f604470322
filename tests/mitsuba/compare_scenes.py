#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Compares fewray with Mitsuba 3 on whole scenes: are the pictures the same but for noise, and how long do they take?

Needs Mitsuba, OpenEXR, numpy and Pillow from PyPI (pip install mitsuba OpenEXR numpy Pillow) and, for Mitsuba's llvm variants,
LLVM 16 or newer (DRJIT_LIBLLVM_PATH). Prints a Markdown table, one row a scene:

  ratio      mean radiance, fewray over Mitsuba, and one standard error of it
  z          blocks of --block pixels: difference of the means over its standard error, both from the spread over the
             seeds. Given are the standard deviation of z and the share of |z| > 3. Where only noise differs z has Student's
             distribution with n = 2 (seeds - 1) degrees of freedom: a deviation of sqrt(n / (n - 2)), 1 % beyond 3 for n = 14
  load       s until the first ray: reading files, building the acceleration structure; the lesser of two. Mitsuba's is mi.load_file()
             and its first render's kernel compilation isn't counted
  4 spp      s of rendering 4 samples a pixel at the scene's own size, without guide and denoiser; the least of three, interleaved

--out DIR leaves for each scene both pictures side by side with the error map (red: fewray brighter, blue: darker; full
colour at 10 % of the local mean or 5 standard errors, whichever is more).
"""
import argparse
import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np


def read_rgb(path):
    import OpenEXR
    channels = OpenEXR.File(str(path), separate_channels=True).channels()
    return np.stack([np.asarray(channels[c].pixels, dtype=np.float64) for c in "RGB"], axis=2)


class Fewray:
    def __init__(self, command, scene, folder, options):
        self.command, self.scene, self.folder, self.options = command, scene, Path(folder), options

    def render(self, spp, seed, size=None, guide="off"):
        out, stats = self.folder / "f.exr", self.folder / "f.json"
        size = ["--width", str(size[0]), "--height", str(size[1])] if size else []
        subprocess.run([self.command, "render", self.scene, "-o", out, "--stats", stats, "--guide", guide, "--denoise", "off",
                        "--float", "--spp", str(spp), "--seed", str(seed), *size, *self.options],
                       check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        return read_rgb(out), json.loads(stats.read_text())


class Mitsuba:
    def __init__(self, variant, scene):
        import mitsuba as mi
        self.mi = mi
        if mi.variant() is None:
            mi.set_variant(variant)
        begin = time.perf_counter()
        self.scene = mi.load_file(str(scene))
        self.load_s = time.perf_counter() - begin
        self.own_size = tuple(int(n) for n in self.scene.sensors()[0].film().size())

    def resize(self, size):
        params = self.mi.traverse(self.scene)
        key = next(k for k in params.keys() if k.endswith("film.size"))
        params[key] = list(size)
        crop = key.replace("film.size", "film.crop_size")
        if crop in params:
            params[crop] = list(size)
        params.update()

    def render(self, spp, seed):
        begin = time.perf_counter()
        image = np.array(self.mi.render(self.scene, spp=spp, seed=seed), dtype=np.float64)[:, :, :3]
        return image, time.perf_counter() - begin


def blocks(image, size):
    """Mean over blocks of size x size pixels and over RGB; what is left over at the right and below is dropped."""
    h, w = image.shape[0] // size, image.shape[1] // size
    return image[:h * size, :w * size].reshape(h, size, w, size, 3).mean(axis=(1, 3, 4))


def statistics(ours, theirs, size):
    """ours, theirs: pictures (seeds, H, W, 3) -> figures and the difference of the means with its error, per block."""
    n = len(ours)
    a = np.array([blocks(i, size) for i in ours])
    b = np.array([blocks(i, size) for i in theirs])
    difference = a.mean(0) - b.mean(0)
    error = np.sqrt((a.var(0, ddof=1) + b.var(0, ddof=1)) / n)
    lit = error > 0
    z = difference[lit] / error[lit]
    means = np.array([i.mean() for i in ours]), np.array([i.mean() for i in theirs])
    ratio = means[0].mean() / means[1].mean()
    ratio_error = ratio * np.sqrt(sum((m.std(ddof=1) / m.mean()) ** 2 for m in means) / n)
    return {"ratio": ratio, "ratio_error": ratio_error, "z_deviation": z.std(), "z_beyond_3": (abs(z) > 3).mean(),
            "blocks": int(lit.sum()), "largest_z": float(abs(z).max())}, difference, error, b.mean(0)


def tone(image):
    image = image / (4 * np.median(image.mean(2)) + 1e-6)
    image = image / (1 + image) * 1.25
    return np.clip(np.where(image <= 0.0031308, 12.92 * image, 1.055 * np.clip(image, 1e-9, None) ** (1 / 2.4) - 0.055), 0, 1)


def write_picture(path, ours, theirs, difference, error, mean, size):
    from PIL import Image
    signed = np.clip(difference / np.maximum(0.1 * mean, 5 * error + 1e-9), -1, 1).repeat(size, 0).repeat(size, 1)
    h, w = signed.shape
    heat = np.stack([1 + np.minimum(signed, 0), 1 - abs(signed), 1 - np.maximum(signed, 0)], axis=2)
    parts = [tone(ours[:h, :w]), tone(theirs[:h, :w]), heat]
    Image.fromarray((np.concatenate(parts, axis=1) * 255 + 0.5).astype(np.uint8)).save(path)


def compare(options, path, folder):
    ours = Fewray(options.fewray, path, folder, options.option)
    theirs = Mitsuba(options.variant, path)
    row = {"scene": f"{path.parent.name}/{path.name}", "mitsuba_load_s": min(theirs.load_s, Mitsuba(options.variant, path).load_s)}
    if not options.no_times:
        theirs.render(4, 0)
        times = []
        for seed in range(3):
            stats = ours.render(4, seed)[1]
            times.append((stats["load_s"] + stats["bvh_s"], stats["initial_s"] + stats["guide_s"] + stats["render_s"],
                          theirs.render(4, seed)[1]))
        row["load_s"], row["render_s"], row["mitsuba_render_s"] = (min(t) for t in zip(*times))
    if options.spp:
        width = min(options.width, theirs.own_size[0])
        size = width, round(width * theirs.own_size[1] / theirs.own_size[0])
        theirs.resize(size)
        mine = [ours.render(options.spp, seed, size, options.guide)[0] for seed in range(options.seeds)]
        other = [theirs.render(options.spp, 1000 + seed)[0] for seed in range(options.seeds)]
        figures, difference, error, mean = statistics(mine, other, options.block)
        row.update(figures)
        if options.out:
            name = f"{path.parent.name}-{path.stem}.png"
            write_picture(Path(options.out) / name, np.mean(mine, axis=0), np.mean(other, axis=0), difference, error, mean,
                          options.block)
    return row


HEADER = """| scene | mean, fewray / Mitsuba | z: deviation, beyond 3, blocks | load, s: fewray, Mitsuba | 4 spp, s: fewray, Mitsuba |
|---|---|---|---|---|"""


def line(r):
    mean = f"{r['ratio']:.4f} +- {r['ratio_error']:.4f}" if "ratio" in r else "-"
    z = f"{r['z_deviation']:.2f}, {100 * r['z_beyond_3']:.1f} %, {r['blocks']}" if "ratio" in r else "-"
    load = f"{r['load_s']:.2f}, {r['mitsuba_load_s']:.2f}" if "load_s" in r else "-"
    times = f"{r['render_s']:.2f}, {r['mitsuba_render_s']:.2f}" if "load_s" in r else "-"
    return f"| {r['scene']} | {mean} | {z} | {load} | {times} |"


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("scenes", nargs="+", type=Path, metavar="SCENE.xml")
    p.add_argument("--fewray", default="build/fewray", help="the command")
    p.add_argument("--variant", default="llvm_ad_rgb", help="of Mitsuba")
    p.add_argument("--spp", type=int, default=64, help="samples a pixel and seed of the comparison; 0: times alone")
    p.add_argument("--seeds", type=int, default=8)
    p.add_argument("--width", type=int, default=320, help="pixels, of the comparison")
    p.add_argument("--block", type=int, default=16, help="pixels")
    p.add_argument("--guide", default="off", help="of fewray's pictures in the comparison")
    p.add_argument("--no-times", action="store_true")
    p.add_argument("--option", action="append", default=[], help="further option for fewray render; may be repeated")
    p.add_argument("--out", help="folder for the pictures")
    p.add_argument("--json", help="write the figures here, too")
    options = p.parse_args()
    if options.out:
        Path(options.out).mkdir(parents=True, exist_ok=True)
    rows = []
    print(HEADER)
    with tempfile.TemporaryDirectory() as folder:
        for path in options.scenes:
            rows.append(compare(options, path, folder))
            print(line(rows[-1]), flush=True)
    if options.json:
        Path(options.json).write_text(json.dumps(rows, indent=1) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
