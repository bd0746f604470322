#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Whether the planner's promises hold: its estimate of the error, its seconds, and what uneven samples bring.

Needs nothing but fewray and references of the scenes' own size. Prints three Markdown tables (those in guide/NOTES.md):
`--error` with the estimated and the true mrse (less the reference's own noise), as many samples evenly and by need, and
`--time` with the seconds of the whole command.
"""
import argparse
import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path


class Render:
    """One run of `fewray render`; its mrse where there is a reference."""

    def __init__(self, options, scene, seed, *arguments):
        path, reference = scene.split("=")
        self.name = Path(path).parent.name
        with tempfile.TemporaryDirectory() as folder:
            out, stats = Path(folder, "out.exr"), Path(folder, "stats.json")
            start = time.monotonic()
            subprocess.run([options.fewray, "render", path, "-o", out, "--float", "--stats", stats, "--seed", str(seed), *arguments],
                           check=True, stderr=subprocess.DEVNULL)
            self.seconds = time.monotonic() - start
            self.stats = json.loads(stats.read_text())
            self.plan = self.stats["plan"]
            compared = subprocess.run([options.fewray, "compare", out, reference, "--json"], check=True, capture_output=True)
            errors = json.loads(compared.stdout)
            self.error = errors.get("mrse_net", errors["mrse"])  # net where the reference tells its own noise


def number(x):
    return "-" if x is None else f"{x:.3g}"


def honesty(options):
    print("| scene | --error | estimated | true | true / estimated | spp | of tiles | seconds |\n|---|---|---|---|---|---|---|---|")
    for scene in options.scenes:
        for wanted in options.errors:
            for seed in options.seeds:
                r = Render(options, scene, seed, "--error", wanted)
                estimate = r.plan["estimated_error"]
                print(f"| {r.name} | {wanted} | {number(estimate)} | {r.error:.3g} | {r.error / estimate:.2f} | {r.plan['spp']:.1f} | "
                      f"{r.plan['least_spp']} to {r.plan['most_spp']} | {r.seconds:.1f} |", flush=True)


def uneven(options):
    print("\n| scene | spp | seed | true error, evenly | by need | ratio |\n|---|---|---|---|---|---|")
    for scene in options.scenes:
        for spp in options.spp:
            for seed in options.seeds:
                # an error out of reach: both go through the same passes
                even, need = (Render(options, scene, seed, "--error", "1e-6", "--max-spp", spp, "--adaptive", adaptive)
                              for adaptive in ("off", "on"))
                print(f"| {even.name} | {spp} | {seed} | {even.error:.3g} | {need.error:.3g} | {need.error / even.error:.2f} |", flush=True)


def punctuality(options):
    print("\n| scene | --time, s | taken | over | spp | estimated error | true |\n|---|---|---|---|---|---|---|")
    for scene in options.scenes:
        for wanted in options.times:
            r = Render(options, scene, options.seeds[0], "--time", wanted)
            over = 100 * (r.seconds / float(wanted) - 1)
            print(f"| {r.name} | {wanted} | {r.seconds:.2f} | {over:+.0f} % | {r.plan['spp']:.1f} | "
                  f"{number(r.plan['estimated_error'])} | {r.error:.3g} |", flush=True)


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("scenes", nargs="+", metavar="SCENE.xml=REFERENCE.exr")
    p.add_argument("--fewray", default="build/fewray", help="the command")
    p.add_argument("--errors", nargs="*", default=["0.05", "0.02", "0.01"])
    p.add_argument("--spp", nargs="*", default=["16"])
    p.add_argument("--times", nargs="*", default=["2", "5", "20"])
    p.add_argument("--seeds", nargs="+", type=int, default=[1])
    options = p.parse_args()
    honesty(options)
    uneven(options)
    punctuality(options)
    return 0


if __name__ == "__main__":
    sys.exit(main())
