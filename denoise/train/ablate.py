#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What each feature is worth: the validation views denoised with layers switched off at inference, by one checkpoint that
was trained with layers missing at random. Prints a table of geometric means of mrse, and of its ratio to that with all."""
import argparse
import math

import torch

import dataset
import model as models
import ops
from train import mrse

SETS = [
    ("all layers", dataset.ALL_LAYERS),
    ("no guide (irradiance, confidence)", dataset.ALL_LAYERS & ~ops.GUIDE),
    ("no variance", dataset.ALL_LAYERS & ~ops.VARIANCE),
    ("no albedo", dataset.ALL_LAYERS & ~ops.ALBEDO),
    ("no normals", dataset.ALL_LAYERS & ~ops.NORMAL),
    ("no depth", dataset.ALL_LAYERS & ~ops.DEPTH),
    ("no emission", dataset.ALL_LAYERS & ~ops.EMISSION),
    ("albedo and normals alone", ops.ALBEDO | ops.NORMAL),
    ("colour alone", 0),
]


def error(model, view, i, layers):
    f, e, m, emission, r = dataset.collate([dataset.whole(view, i, layers=layers)])
    with torch.no_grad():
        x = (model(f, e) * m + emission) * view.gain
    return mrse(x, r * view.gain)


def main():
    p = argparse.ArgumentParser(description=__doc__)
    p.add_argument("checkpoint")
    p.add_argument("data", help="folder of views made by make_data.py")
    p.add_argument("--spp", type=int, default=4)
    p.add_argument("--threads", type=int, default=2)
    a = p.parse_args()
    torch.set_num_threads(a.threads)
    model = models.from_checkpoint(torch.load(a.checkpoint, weights_only=False))
    _, views = dataset.views(a.data)
    columns = []
    for guide in ("odis", "off"):
        pictures = [(v, i) for v in views for i, spp in enumerate(v.spp) if spp == a.spp and v.guides[i] == guide]
        logs = [[math.log(max(error(model, v, i, layers), 1e-9)) for v, i in pictures] for _, layers in SETS]
        columns.append((guide, len(pictures), [math.exp(sum(column) / max(len(column), 1)) for column in logs]))
    print("| layers | " + " | ".join(f"{count} pictures, guide {guide}: mrse | ratio" for guide, count, _ in columns) + " |")
    print("|" + "---|" * (1 + 2 * len(columns)))
    for row, (name, _) in enumerate(SETS):
        print(f"| {name} | " + " | ".join(f"{c[row]:.4f} | {c[row] / c[0]:.2f}" for _, _, c in columns) + " |")


if __name__ == "__main__":
    main()
