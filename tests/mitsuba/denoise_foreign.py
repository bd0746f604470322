#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Denoises Mitsuba's own pictures by fewray and by Open Image Denoise: with every layer, without normals, without albedo, and
by colour alone.

Needs Mitsuba, OpenEXR, numpy, pyoidn and, for FLIP, flip-evaluator from PyPI. Mitsuba renders the scene as it is, within its
`aov` integrator, and writes the EXR; fewray gets that file, less the layers that are left out, and finds the rest by its
names. Prints a Markdown table: mrse less the reference's own noise, ssim_loss, FLIP, each of the noisy picture, of fewray's and of
OIDN's. OIDN can't use normals without albedo. --out DIR keeps the pictures.
"""
import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

import exr
import oidn

LAYERS = {"albedo": "RGB", "nn": "XYZ", "dd": "T"}
CASES = {"all layers": set(), "no normals": {"nn"}, "no albedo": {"albedo"}, "colour alone": {"albedo", "nn", "dd"}}
METRICS = ("mrse_net", "ssim_loss", "flip")


def render(mi, scene, spp, seed, path):
    aov = mi.load_dict({"type": "aov", "aovs": "albedo:albedo,nn:sh_normal,dd:depth", "image": scene.integrator()})
    mi.render(scene, integrator=aov, spp=spp, seed=seed)
    scene.sensors()[0].film().bitmap().write(str(path))


def without(planes, layers):
    return {name: plane for name, plane in planes.items() if name.split(".")[0] not in layers}


def figures(options, folder, name, noisy, reference, denoise):
    """{case: {"noisy", "fewray", "OIDN": metrics}}"""
    rows = {}
    planes = exr.read(noisy)
    before = exr.measure(options.fewray, noisy, reference)
    for case, missing in CASES.items():
        stem = f"{name}-{case.replace(' ', '-')}"
        source, ours, theirs = (folder / f"{stem}{end}.exr" for end in ("", "-fewray", "-oidn"))
        kept = without(planes, missing)
        exr.write(source, {n: p.astype(np.float16) if options.half else p for n, p in kept.items()})
        subprocess.run([options.fewray, "denoise", source, "-o", ours, "--float"], check=True, stderr=subprocess.DEVNULL)
        albedo, normal = (exr.stacked(kept, *(f"{n}.{c}" for c in LAYERS[n])) for n in ("albedo", "nn"))
        exr.write_rgb(theirs, denoise(exr.stacked(kept, *"RGB"), None if albedo is None else np.clip(albedo, 0, 1), normal))
        rows[case] = {"noisy": before, "fewray": exr.measure(options.fewray, ours, reference),
                      "OIDN": exr.measure(options.fewray, theirs, reference)}
    return rows


def lines(name, spp, rows):
    for case, row in rows.items():
        cells = [" / ".join(f"{row[who][m]:.3g}" for who in ("noisy", "fewray", "OIDN")) for m in METRICS]
        yield f"| {name} | {spp} | {case} | {' | '.join(cells)} |"


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("scenes", nargs="+", metavar="SCENE.xml=REFERENCE.exr")
    p.add_argument("--fewray", default="build/fewray", help="the command")
    p.add_argument("--variant", default="llvm_ad_rgb", help="of Mitsuba")
    p.add_argument("--spp", type=int, nargs="+", default=[4, 8])
    p.add_argument("--seed", type=int, default=1)
    p.add_argument("--half", action="store_true", help="give the denoisers half floats")
    p.add_argument("--out", type=Path, help="folder for the pictures")
    oidn.add_options(p)
    options = p.parse_args()
    import mitsuba as mi
    mi.set_variant(options.variant)
    denoise = oidn.opened(options)
    print("noisy / fewray / OIDN\n\n| scene | spp | layers | mrse_net | ssim_loss | FLIP |\n|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as temporary:
        folder = options.out or Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        for path, reference in (s.split("=") for s in options.scenes):
            name = Path(path).parent.name
            scene = mi.load_file(path)
            for spp in options.spp:
                noisy = folder / f"{name}-{spp}.exr"
                if not noisy.exists():
                    render(mi, scene, spp, options.seed, noisy)
                for line in lines(name, spp, figures(options, folder, f"{name}-{spp}", noisy, reference, denoise)):
                    print(line, flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
