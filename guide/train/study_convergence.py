#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The paper's figure 9 on our renderer: error over samples a pixel of the table's methods.

Trimmed mrse and 1 - SSIM, medians over the seeds, divided by path tracing's at the fewest samples,
then averaged over the scenes. Lower is better."""
import study

METRICS = {"trimmed MrSE": "mrse_trimmed", "1 - SSIM": "ssim_loss"}


def curve(s, method, metric, scenes, counts):
    """(samples, relative errors) where all scenes have been measured."""
    xs, ys = [], []
    for spp in counts:
        shares = []
        for scene in scenes:
            value = s.median(method, scene, spp, metric)
            unit = s.median("Path", scene, counts[0], metric)
            if value is not None and unit:
                shares.append(value / unit)
        if len(shares) == len(scenes):
            xs.append(spp)
            ys.append(sum(shares) / len(shares))
    return xs, ys


def main():
    args = study.parser(__doc__, [2 ** k for k in range(1, 11)], 1, "convergence").parse_args()
    s = study.Study(args)
    s.run(study.METHODS)
    scenes = [study.scene_name(pair.partition("=")[0]) for pair in args.scenes]
    text, panels = "", []
    for title, metric in METRICS.items():
        curves = {m: curve(s, m, metric, scenes, args.spp) for m in study.METHODS}
        label = f"{title}, relative to Path at {args.spp[0]} spp"
        panels.append((label, curves))
        text += f"{label}; mean of {', '.join(scenes)}\n\n" + study.head("spp", *study.METHODS)
        for spp in args.spp:
            known = {m: dict(zip(*curves[m])) for m in curves}
            text += study.row(str(spp), *(study.number(known[m].get(spp)) for m in curves))
        text += "\n"
    study.plot(f"{args.output}.png", panels, "samples a pixel")
    return s.finish(text)


if __name__ == "__main__":
    study.start(main)
