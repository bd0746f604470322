#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The paper's table 1 on our renderer: noise of path tracing, the paper's guide trained by L1 alone
(NoGAN) and with the discriminator (ODIS), practical path guiding (PPG) and ours.

trimmed: mrse without the worst 0.01 % of the pixels; untrimmed: mrse; medians over the seeds.
seconds: look, guide and render, the least. Lower is better."""
import study

LINES = {"trimmed": "mrse_trimmed", "untrimmed": "mrse", "seconds": "seconds"}


def main():
    args = study.parser(__doc__, [4, 8, 64], 5, "table").parse_args()
    s = study.Study(args)
    s.run(study.METHODS)
    text = f"Medians of {args.seeds} seeds; lower is better.\n"
    for spp in args.spp:
        text += f"\n{spp} samples a pixel\n\n" + study.head("scene", "", *study.METHODS)
        for scene in map(lambda pair: study.scene_name(pair.partition("=")[0]), args.scenes):
            for line, metric in LINES.items():
                cells = [study.number(s.median(m, scene, spp, metric)) for m in study.METHODS]
                text += study.row(scene, line, *cells)
    return s.finish(text)


if __name__ == "__main__":
    study.start(main)
