#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The paper's figure 6 on our renderer: error over samples a pixel with true maps of different
resolutions, by fewray-true-maps (true_maps.c).

Trimmed mrse, median over the seeds, divided by path tracing's at the fewest samples, then averaged
over the scenes. 0 bins: path tracing. Lower is better."""
import json
import statistics
import tempfile
from pathlib import Path

import study


def arguments():
    p = study.parser(__doc__, [4, 16, 64, 256], 1, "resolution", resumable=False)
    p.add_argument("--bins", default="8,16,32", help="rows and columns of the maps (8,16,32)")
    p.add_argument("--map", choices=("mean", "moment"), default="mean",
                   help="mean radiance, as in the paper, or the root second moment")
    p.add_argument("--samples", type=int, default=64, help="of the truth, for each bin (64)")
    p.add_argument("--fraction", type=float, default=0, help="of the samples for the BSDF (0)")
    return p.parse_args()


def measure(args):
    """scene -> the program's lines."""
    lines = {}
    threads = ["--threads", args.threads] if args.threads else []
    with tempfile.TemporaryDirectory() as folder:
        for pair in args.scenes:
            scene = study.Scene(pair, args, Path(folder))
            told = study.call(args.build / "fewray-true-maps", "--map", args.map, "--bins",
                              args.bins, "--spp", ",".join(map(str, args.spp)), "--samples",
                              args.samples, "--fraction", args.fraction, "--seeds", args.seeds,
                              "--width", scene.width, *threads, scene.xml, scene.reference)
            lines[scene.name] = [json.loads(line) for line in told.splitlines()]
    return lines


def relative(lines, bins, spp, metric, first):
    """Mean over the scenes of the error as a share of path tracing's at `first` samples."""
    def median(scene, b, n):
        return statistics.median(r[metric] for r in lines[scene] if (r["bins"], r["spp"]) == (b, n))
    return statistics.mean(median(s, bins, spp) / median(s, 0, first) for s in lines)


def main():
    args = arguments()
    lines = measure(args)
    settings = {k: str(v) for k, v in vars(args).items()}
    Path(args.output).parent.mkdir(parents=True, exist_ok=True)
    Path(f"{args.output}.json").write_text(json.dumps({"settings": settings, "results": lines},
                                                      indent=1))
    bins = [0] + [int(b) for b in args.bins.split(",")]
    names = ["Path" if not b else f"{b} x {b}" for b in bins]
    curves = {n: (args.spp, [relative(lines, b, spp, "mrse_trimmed", args.spp[0])
                             for spp in args.spp]) for n, b in zip(names, bins)}
    label = f"trimmed MrSE, relative to Path at {args.spp[0]} spp"
    text = f"{label}; true {args.map} maps, mean of {', '.join(lines)}\n\n"
    text += study.head("spp", *names)
    for k, spp in enumerate(args.spp):
        text += study.row(str(spp), *(study.number(curves[n][1][k]) for n in names))
    study.plot(f"{args.output}.png", [(label, curves)], "samples a pixel")
    Path(f"{args.output}.md").write_text(text)
    print(text)


if __name__ == "__main__":
    study.start(main)
