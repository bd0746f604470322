#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Trains the kernel-predicting network on the records of make_data.py for a given wall time."""
import argparse
import json
import math
import os
import time
from pathlib import Path

import torch
import torch.nn.functional as F

import dataset
from model import KPN


def loss_terms(x, r):
    """Relative L1 and L2. The divisor comes from both pictures and carries no gradient: an outlier in either is bounded,
    and a noisy reference biases the optimum less than dividing by it alone would."""
    d = 0.35 * x.detach() + 0.65 * r
    return ((x - r).abs() / (d + 0.1)).mean(), ((x - r) ** 2 / (d * d + 0.01)).mean()


def pooled(picture, size=4):
    """(N, H, W, 3) averaged over blocks: blotches are what a loss of single pixels hardly sees."""
    return F.avg_pool2d(picture.permute(0, 3, 1, 2), size)


def mrse(x, r):
    return float(((x - r) ** 2 / (r * r + 0.01)).mean())


def validate(model, views, size=256):
    """Geometric means over the views at 4 spp (or their first picture) of mrse before and after."""
    before, after = [], []
    for view in views[:16]:
        i = view.spp.index(4) if 4 in view.spp else 0
        f, e, m, emission, r = dataset.collate([dataset.whole(view, i, size)])
        gain = view.gain
        with torch.no_grad():
            x = (model(f, e) * m + emission) * gain
        before.append(mrse((e * m + emission) * gain, r * gain))
        after.append(mrse(x, r * gain))
    mean = lambda v: math.exp(sum(math.log(max(a, 1e-9)) for a in v) / len(v))
    return mean(before), mean(after)


def start_from(model, weights):
    """Takes another model's weights over. One that knew fewer features didn't see the last ones: their weights are 0."""
    first = weights["enc0a.weight"]
    missing = model.enc0a.in_channels - first.shape[1]
    weights["enc0a.weight"] = F.pad(first, (0, 0, 0, 0, 0, missing))
    model.load_state_dict(weights)


def save(path, state):
    torch.save(state, str(path) + ".part")
    os.replace(str(path) + ".part", path)


def main():
    p = argparse.ArgumentParser(description=__doc__)
    p.add_argument("data", help="folder of views made by make_data.py")
    p.add_argument("-o", "--out", required=True, help="checkpoint; training goes on from it where it exists")
    p.add_argument("--minutes", type=float, default=60, help="wall time of the whole training, earlier runs included")
    p.add_argument("--batch", type=int, default=8)
    p.add_argument("--crop", type=int, default=128)
    p.add_argument("--rate", type=float, default=1e-3)
    p.add_argument("--seed", type=int, default=1)
    p.add_argument("--threads", type=int, default=2)
    p.add_argument("--bf16", action="store_true", help="convolutions of the trunk in bfloat16: faster, less exact")
    p.add_argument("--l1", type=float, default=0.5, help="weight of the L1 term: more is sharper, and darker where "
                   "references are noisy")
    p.add_argument("--blotches", type=float, default=1, help="weight of the loss of 4x4 means")
    p.add_argument("--start", help="checkpoint whose weights to start from (with a fresh schedule)")
    a = p.parse_args()
    torch.set_num_threads(a.threads)
    torch.manual_seed(a.seed)

    train, validation = dataset.views(a.data)
    model, average = KPN(), KPN()
    model = model.to(memory_format=torch.channels_last)
    if a.start:
        start_from(model, torch.load(a.start, weights_only=False)["average"])
    average.load_state_dict(model.state_dict())
    optimizer = torch.optim.Adam(model.parameters(), lr=a.rate, betas=(0.9, 0.99))
    steps, elapsed, log = 0, 0.0, []
    out = Path(a.out)
    if out.exists():
        state = torch.load(out, weights_only=False)
        model.load_state_dict(state["model"])
        average.load_state_dict(state["average"])
        optimizer.load_state_dict(state["optimizer"])
        steps, elapsed, log = state["steps"], state["elapsed"], state["log"]
    print(f"{len(train)} training views, {len(validation)} validation views, from step {steps}", flush=True)

    loader = dataset.Loader(a.data, train, a.batch, a.crop, a.seed + steps)
    start, last_report, sums, count = time.time() - elapsed, time.time(), [0.0, 0.0], 0
    while True:
        elapsed = time.time() - start
        done = elapsed >= a.minutes * 60
        if done or time.time() - last_report > (30 if steps < 500 else 120):
            before, after = validate(average, validation)
            log.append({"seconds": round(elapsed), "steps": steps, "loss": [s / max(count, 1) for s in sums],
                        "noisy": before, "denoised": after, "ratio": before / after})
            print(json.dumps(log[-1]), flush=True)
            save(out, {"model": model.state_dict(), "average": average.state_dict(), "steps": steps, "log": log,
                       "optimizer": optimizer.state_dict(), "elapsed": elapsed, "arguments": vars(a),
                       "views": [len(train), len(validation)]})
            last_report, sums, count = time.time(), [0.0, 0.0], 0
        if done:
            return
        progress = elapsed / (a.minutes * 60)
        rate = a.rate * min(1, (steps + 1) / 200) * (0.01 + 0.99 * 0.5 * (1 + math.cos(math.pi * progress)))
        for group in optimizer.param_groups:
            group["lr"] = rate
        f, e, m, emission, r = loader.next()
        with torch.autocast("cpu", torch.bfloat16, enabled=a.bf16):
            filtered = model(f, e)
        x = filtered.float() * m + emission
        l1, l2 = loss_terms(x, r)
        blotches = loss_terms(pooled(x), pooled(r))
        optimizer.zero_grad(set_to_none=True)
        (a.l1 * (l1 + a.blotches * blotches[0]) + l2 + a.blotches * blotches[1]).backward()
        torch.nn.utils.clip_grad_norm_(model.parameters(), 1.0)
        optimizer.step()
        decay = min(0.999, (steps + 1) / (steps + 10))
        with torch.no_grad():
            for mean, value in zip(average.parameters(), model.parameters()):
                mean.lerp_(value, 1 - decay)
        steps, count = steps + 1, count + 1
        sums[0] += l1.item()
        sums[1] += l2.item()


if __name__ == "__main__":
    main()
