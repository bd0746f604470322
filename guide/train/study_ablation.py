#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What each part of the guide is worth: noise of path tracing over that of the guide with parts
switched off or set otherwise, at the same samples a pixel.

Cells: mrse of path tracing / mrse of the row, trimmed / untrimmed, of medians over the seeds;
higher is better, below 1 the guide harms. time: seconds of look, guide and render, the least, over
path tracing's; the mean over the scenes. Other networks are added by --weights NAME=FILE."""
import study

PATH = "path tracing"
ROWS = {
    "default": [],
    "no probes": ["--probes", "off"],
    "look weight 0": ["--look-weight", "0"],
    "look weight 0.3": ["--look-weight", "0.3"],
    "look weight 0.6": ["--look-weight", "0.6"],
    "look weight 1": ["--look-weight", "1"],
    "BSDF fraction 0.1": ["--bsdf-fraction", "0.1"],
    "BSDF fraction 0.25": ["--bsdf-fraction", "0.25"],
    "BSDF fraction 0.5": ["--bsdf-fraction", "0.5"],
    "a map for every block": ["--share-maps", "off"],
    "no refinement": ["--refine", "off"],
    "16 x 16 bins": ["--map-bins", "16"],
    "8 x 8 bins": ["--map-bins", "8"],
    "paper": ["--guide", "paper"],
    "paper, NoGAN": ["--guide", "paper", "--guide-weights", str(study.NOGAN)],
    "paper, BSDF fraction 0.25": ["--guide", "paper", "--bsdf-fraction", "0.25"],
    "paper, look weight 0.6": ["--guide", "paper", "--look-weight", "0.6"],
    "path guiding": ["--guide", "ppg"],
}


def ratio(s, kind, scene, spp, metric):
    a, b = (s.median(k, scene, spp, metric) for k in (PATH, kind))
    return None if a is None or not b else a / b


def arguments():
    p = study.parser(__doc__, [4], 3, "ablation")
    p.add_argument("--weights", action="append", default=[], metavar="NAME=FILE",
                   help="a row with this network in the default guide")
    p.add_argument("--only", type=lambda text: text.split(","), metavar="ROW,ROW",
                   help="these rows alone, of: " + ", ".join(ROWS))
    args = p.parse_args()
    unknown = set(args.only or []) - set(ROWS)
    if unknown:
        p.error(f"--only: no row is called {', '.join(sorted(unknown))}")
    return args


def main():
    args = arguments()
    kinds = {name: ROWS[name] for name in args.only or ROWS}
    for pair in args.weights:
        name, _, file = pair.partition("=")
        kinds[name] = ["--guide-weights", file]
    s = study.Study(args)
    s.run({PATH: ["--guide", "off"], **kinds})
    scenes = [study.scene_name(pair.partition("=")[0]) for pair in args.scenes]
    text = "Noise of path tracing / noise of the row, trimmed / untrimmed; medians of " \
           f"{args.seeds} seeds; higher is better.\n"
    for spp in args.spp:
        text += f"\n{spp} samples a pixel\n\n" + study.head("", *scenes, "time")
        for kind in kinds:
            cells = [" / ".join(study.number(ratio(s, kind, scene, spp, metric))
                                for metric in ("mrse_trimmed", "mrse")) for scene in scenes]
            times = [ratio(s, kind, scene, spp, "seconds") for scene in scenes]
            known = [1 / t for t in times if t]
            cells.append(study.number(sum(known) / len(known) if known else None))
            text += study.row(kind, *cells)
    return s.finish(text)


if __name__ == "__main__":
    study.start(main)
