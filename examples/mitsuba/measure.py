#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Noise of Mitsuba 3's path tracer with and without fewray's guide:

    measure.py SCENE.xml=REFERENCE.exr...       # medians of several seeds, as a table
    measure.py --means 32 SCENE.xml...          # whether the guided mean is the plain one, block by block

Noise is mrse = mean of (x - r)^2 / (r^2 + 0.01) over pixels and channels, trimmed of the 0.01 % of the pixels that have
the highest error, and untrimmed.
"""

import argparse
import time
from pathlib import Path

import mitsuba as mi
import numpy as np
from render import load, render

INTEGRATORS = "path", "fewray_guided"
BLOCK = 20  # pixels a side


def noise(x, r):
    """Trimmed and untrimmed mrse."""
    error = np.sort(((x - r) ** 2 / (r * r + 0.01)).mean(2), axis=None)
    worst = int(np.ceil(error.size * 1e-4))
    return error[:-worst].mean(), error.mean()


def measure(path, reference, spp, seeds):
    layers = dict(mi.Bitmap(reference).split())
    r = np.array(layers["<root>"], dtype=np.float32)[:, :, :3]
    scene, depth = load(path, r.shape[1], r.shape[0])
    found = {}
    for integrator in INTEGRATORS:
        rows = []
        for seed in range(1, seeds + 1):
            start = time.perf_counter()
            image = np.array(render(scene, integrator, depth, spp, seed))[:, :, :3]
            rows.append(noise(image, r) + (time.perf_counter() - start,))
        found[integrator] = np.median(rows, axis=0)
    plain, guided = (found[name] for name in INTEGRATORS)
    name = Path(path).parent.name
    print(f"| {name} | {plain[0]:.3g} | {guided[0]:.3g} | **{plain[0] / guided[0]:.2f}** | {plain[1]:.3g} | "
          f"{guided[1]:.3g} | {plain[1] / guided[1]:.2f} | {plain[2]:.2f} | {guided[2]:.2f} |", flush=True)


def blocks(image):
    h, w = (n // BLOCK * BLOCK for n in image.shape[:2])
    return image[:h, :w].reshape(h // BLOCK, BLOCK, w // BLOCK, BLOCK, 3).mean((1, 3))


def compare_means(path, renders, spp):
    scene, depth = load(path, 120, 80)
    means, errors = [], []
    for k, integrator in enumerate(INTEGRATORS):
        pictures = [blocks(np.array(render(scene, integrator, depth, spp, 1000 * (k + 1) + seed))[:, :, :3])
                    for seed in range(renders)]
        means.append(np.mean(pictures, axis=0))
        errors.append(np.std(pictures, axis=0, ddof=1) / np.sqrt(renders))
    z = (means[1] - means[0]) / np.hypot(*errors)
    print(f"| {Path(path).parent.name} | {means[1].mean() / means[0].mean():.4f} | {z.mean():.2f} | {z.std():.2f} | "
          f"{(abs(z) > 3).sum()} of {z.size} |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="+", metavar="SCENE.xml[=REFERENCE.exr]")
    parser.add_argument("--spp", type=int, default=4, help="samples a pixel, the look included (4)")
    parser.add_argument("--seeds", type=int, default=3, help="renders whose median counts (3)")
    parser.add_argument("--means", type=int, metavar="RENDERS", help="compare means of so many renders at 120x80 pixels")
    parser.add_argument("--variant", default="llvm_ad_rgb", help="of Mitsuba (llvm_ad_rgb)")
    options = parser.parse_args()
    mi.set_variant(options.variant)
    import guided  # noqa: F401  registers the integrator; wants the variant to be set
    if options.means:
        print("| scene | guided / plain mean | mean z | deviation of z | blocks beyond 3 standard errors |\n"
              "|---|---|---|---|---|")
        for scene in options.scenes:
            compare_means(scene, options.means, options.spp)
        return
    print(f"| scene, {options.spp} samples a pixel | path | guided | ratio | path, untrimmed | guided | ratio | "
          "path [s] | guided [s] |\n|---|---|---|---|---|---|---|---|---|")
    for pair in options.scenes:
        measure(*pair.split("=", 1), options.spp, options.seeds)


if __name__ == "__main__":
    main()
