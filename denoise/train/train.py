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
import model as models

BLOTCH = 4  # pixels of the blocks whose means have a loss, too


def loss_terms(x, r):
    """Relative L1 and L2 of each sample. The divisor comes from both pictures and carries no gradient: an outlier in either
    is bounded, and a noisy reference biases the optimum less than dividing by it alone would."""
    d = 0.35 * x.detach() + 0.65 * r
    return ((x - r).abs() / (d + 0.1)).mean((1, 2, 3)), ((x - r) ** 2 / (d * d + 0.01)).mean((1, 2, 3))


def pooled(picture, size):
    """(N, H, W, 3) averaged over blocks: blotches are what a loss of single pixels hardly sees."""
    return F.avg_pool2d(picture.permute(0, 3, 1, 2), size)


def display(picture):
    """(N, H, W, 3) as (N, 3, H, W) of a display: gamma 2.2, clipped to 1."""
    return picture.permute(0, 3, 1, 2).clamp(1e-5, 1) ** (1 / 2.2)


def ssim_loss(x, r):
    """1 - SSIM of each sample as displayed (Wang et al. 2004, equation 13; Gaussian window of 11 pixels, sigma 1.5)."""
    x, r = display(x), display(r)
    window = torch.exp(-torch.arange(-5.0, 6.0) ** 2 / (2 * 1.5**2))
    window = (window / window.sum()).repeat(15, 1)
    maps = torch.cat([x, r, x * x, r * r, x * r], 1)
    maps = F.conv2d(F.conv2d(maps, window.view(15, 1, 11, 1), groups=15), window.view(15, 1, 1, 11), groups=15)
    mean_x, mean_r, xx, rr, xr = maps.chunk(5, 1)
    covariance, variances = xr - mean_x * mean_r, xx - mean_x**2 + rr - mean_r**2
    means = (2 * mean_x * mean_r + 1e-4) / (mean_x**2 + mean_r**2 + 1e-4)
    return 1 - (means * (2 * covariance + 9e-4) / (variances + 9e-4)).mean((1, 2, 3))


def sample_losses(x, r, a):
    """Of each sample, and its relative L1 and L2."""
    l1, l2 = loss_terms(x, r)
    b1, b2 = loss_terms(pooled(x, BLOTCH), pooled(r, BLOTCH))
    return a.l1 * l1 + l2 + a.blotches * (a.l1 * b1 + b2), l1, l2


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
    p.add_argument("--l1", type=float, default=0.15, help="weight of the L1 term: more is sharper, and darker where "
                   "references are noisy")
    p.add_argument("--blotches", type=float, default=0.6, help="weight of the losses of blocks' means")
    p.add_argument("--ssim", type=float, default=0.5, help="weight of the logarithm of 1 - SSIM")
    p.add_argument("--floor", type=float, default=0.01, help="loss below which a sample is good enough")
    p.add_argument("--model", default="default", choices=list(models.WIDTHS))
    p.add_argument("--start", help="checkpoint, of any model, whose weights to start from (with a fresh schedule)")
    a = p.parse_args()
    torch.set_num_threads(a.threads)
    torch.manual_seed(a.seed)

    train, validation = dataset.views(a.data)
    model, average = models.build(a.model), models.build(a.model)
    model = model.to(memory_format=torch.channels_last)
    if a.start:
        models.start_from(model, torch.load(a.start, weights_only=False)["average"])
    average.load_state_dict(model.state_dict())
    is_key = lambda name: name.startswith(("key", "scale"))  # few weights, which start as a prior: they move faster
    groups = [{"params": [v for n, v in model.named_parameters() if is_key(n) == fast], "times": 4 if fast else 1}
              for fast in (False, True)]
    optimizer = torch.optim.Adam(groups, lr=a.rate, betas=(0.9, 0.99))
    steps, elapsed, log = 0, 0.0, []
    out = Path(a.out)
    if out.exists():
        state = torch.load(out, weights_only=False)
        if state.get("network", "default") != a.model:
            p.error(f"{out} holds the model {state.get('network', 'default')}, not {a.model}")
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
            save(out, {"network": a.model, "model": model.state_dict(), "average": average.state_dict(), "steps": steps,
                       "log": log, "optimizer": optimizer.state_dict(), "elapsed": elapsed, "arguments": vars(a),
                       "views": [len(train), len(validation)]})
            last_report, sums, count = time.time(), [0.0, 0.0], 0
        if done:
            return
        progress = elapsed / (a.minutes * 60)
        rate = a.rate * min(1, (steps + 1) / 200) * (0.01 + 0.99 * 0.5 * (1 + math.cos(math.pi * progress)))
        for group in optimizer.param_groups:
            group["lr"] = rate * group["times"]
        f, e, m, emission, r = loader.next()
        with torch.autocast("cpu", torch.bfloat16, enabled=a.bf16):
            filtered = model(f, e)
        x = filtered.float() * m + emission
        loss, l1, l2 = sample_losses(x, r, a)
        optimizer.zero_grad(set_to_none=True)
        # The geometric mean over samples: one of little noise counts as much as one of a lot.
        total = torch.log(loss + a.floor).mean()
        if a.ssim:
            total = total + a.ssim * torch.log(ssim_loss(x, r) + 0.02).mean()
        total.backward()
        torch.nn.utils.clip_grad_norm_(model.parameters(), 1.0)
        optimizer.step()
        decay = min(0.999, (steps + 1) / (steps + 10))
        with torch.no_grad():
            for mean, value in zip(average.parameters(), model.parameters()):
                mean.lerp_(value, 1 - decay)
        steps, count = steps + 1, count + 1
        sums[0] += l1.mean().item()
        sums[1] += l2.mean().item()


if __name__ == "__main__":
    main()
