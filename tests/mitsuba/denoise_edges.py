#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""How much of the denoised error sits in the worst pixels, at edges, and what more camera rays than paths do against it.

Needs OpenEXR, numpy, pyoidn and, for FLIP, flip-evaluator from PyPI. fewray renders each scene with its default camera rays
and with as many as paths (--camera-rays SPP); each picture is denoised by fewray and by Open Image Denoise. Prints a Markdown
table: mrse less the reference's own noise, and the share of mrse in the worst 1 % of the pixels. --out DIR keeps the pictures.
"""
import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

import exr
import oidn


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("scenes", nargs="+", metavar="SCENE.xml=REFERENCE.exr")
    p.add_argument("--fewray", default="build/fewray", help="the command")
    p.add_argument("--spp", type=int, default=4)
    p.add_argument("--seed", type=int, default=1)
    p.add_argument("--guide", nargs="+", default=["odis", "off"])
    p.add_argument("--out", type=Path, help="folder for the pictures")
    oidn.add_options(p)
    options = p.parse_args()
    denoise = oidn.opened(options)
    print("fewray / OIDN\n\n| scene | guide | camera rays | mrse_net | share of mrse in the worst 1 % | ssim_loss | FLIP |\n"
          "|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as temporary:
        folder = options.out or Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        for path, reference in (s.split("=") for s in options.scenes):
            name = Path(path).parent.name
            for guide in options.guide:
                for rays in ([], ["--camera-rays", str(options.spp)]):
                    many = "default" if not rays else rays[1]
                    ours, theirs = (folder / f"{name}-{guide}-{many}-{who}.exr" for who in ("fewray", "oidn"))
                    subprocess.run([options.fewray, "render", path, "-o", ours, "--float", "--spp", str(options.spp), "--seed",
                                    str(options.seed), "--guide", guide, *rays], check=True, stderr=subprocess.DEVNULL)
                    planes = exr.read(ours)
                    layers = (exr.stacked(planes, *(f"{n}.{c}" for c in axes))
                              for n, axes in (("noisy", "RGB"), ("albedo", "RGB"), ("normal", "XYZ")))
                    exr.write_rgb(theirs, denoise(*layers))
                    rows = [exr.measure(options.fewray, picture, reference) for picture in (ours, theirs)]
                    cells = [" / ".join(f"{row[m]:.3g}" for row in rows) for m in ("mrse_net", "mrse_top1", "ssim_loss", "flip")]
                    print(f"| {name} | {guide} | {many} | {' | '.join(cells)} |", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
