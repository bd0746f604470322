#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Seconds of `fewray render`'s samples (render_s of --stats) before and after a change, and their scaling from one thread to two, as a Markdown table.

    tests/perf/throughput.py --fewray BEFORE [--fewray AFTER] [--runs 5] SCENE.xml...

The programs are measured in turn, so that load of the machine hits both alike; the least of all runs counts. Scaling is the last program's. A benchmark, never a test."""

import argparse
import os
import pathlib
import tempfile

from startup import measure, table

VARIANTS = {
    "path traced": ["--guide", "off", "--denoise", "off"],
    "guided": ["--pilot", "off", "--denoise", "off"],
}


def seconds(programs, scene, options, threads, args, folder):
    width, height = args.size.split("x")
    stats = f"{folder}/stats.json"
    least = measure(programs, ["render", scene, "-o", f"{folder}/out.exr", "--spp", str(args.spp), "--width", width, "--height", height,
                               "--threads", str(threads), "--stats", stats] + options, args.runs, stats)
    return [figures["render_s"] for figures in least]


def change(s):
    return " -> ".join(f"{x:.3f}" for x in s) + (f" ({s[0] / s[-1]:.2f})" if len(s) > 1 else "")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="+", metavar="SCENE.xml")
    parser.add_argument("--fewray", action="append", required=True, help="several: before, after")
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--size", default="700x400")
    parser.add_argument("--spp", type=int, default=4)
    args = parser.parse_args()
    programs = [os.path.abspath(p) for p in args.fewray]
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for scene in args.scenes:
            for variant, options in VARIANTS.items():
                one, two = (seconds(programs, scene, options, threads, args, folder) for threads in (1, 2))
                rows.append([pathlib.Path(scene).resolve().parent.name, variant, change(one), change(two), f"{one[-1] / two[-1]:.2f}"])
    print(f"render_s of {args.size}, {args.spp} spp, seconds (ratio), least of {args.runs} runs:\n")
    table(["scene", "", "1 thread", "2 threads", "scaling"], rows)


if __name__ == "__main__":
    main()
