#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes a checkpoint's averaged weights as the file that denoise/nn reads (nn.h has the format), and tensors of a small
picture by which a C test compares the network with PyTorch. Channel counts are the model's own: the C code reads them."""
import argparse
from pathlib import Path

import numpy as np
import torch

import dataset
import ops
import model as models
from weights_file import container, write_whole

ROOT = Path(__file__).resolve().parents[2]
SHIPPED = {"default": "kpn", "fast": "kpn_fast"}


def test_picture(seed=3, height=32, width=48):
    """Raw planes (23, H, W) of a picture with patches, noise, an emitter and a background."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[0:height, 0:width].astype(np.float32)
    raw = np.zeros((23, height, width), np.float32)
    irradiance = np.stack([1 + 0.5 * np.sin(x / 7), 0.8 + 0 * x, 0.3 + y / height])
    albedo = np.where(x > 20, 0.7, 0.2) * np.array([1, 0.8, 0.3])[:, None, None]
    noise = rng.gamma(4, 0.25, (1, height, width))
    raw[0:3] = irradiance * albedo * noise
    raw[6:9] = (0.5 * irradiance * albedo * noise) ** 2
    raw[9:12] = albedo
    raw[12:15] = np.where(y > 12, np.array([0, 0, 1])[:, None, None], np.array([0, 0.6, -0.8])[:, None, None])
    raw[15] = 3 + x / 20
    raw[16:19] = 1.1 * irradiance
    raw[19] = np.where(x > 8, 0.8, 0)
    raw[20:23] = 0.9 * albedo
    raw[:, :6, :9] = 0
    raw[3:6, 20:24, 30:36] = 12
    raw[0:3] += raw[3:6]
    return raw.astype(np.float16).astype(np.float32)


def test_tensors(model):
    """What the network makes of the test picture, layer by layer. Shapes are (channels, 1, H, W)."""
    raw = test_picture()
    exposure, log2_depth = ops.measure(raw, dataset.ALL_LAYERS)
    f, e = ops.features(raw, dataset.ALL_LAYERS, exposure, log2_depth)
    trace = {}
    with torch.no_grad():
        model(torch.from_numpy(f)[None], torch.from_numpy(e)[None], trace)
    h, w, _ = f.shape
    f = f.reshape(h, w, ops.FEATURES, 2, 2).transpose(2, 0, 3, 1, 4).reshape(ops.FEATURES, 2 * h, 2 * w)
    floats = {"raw": raw, "features": f, "irradiance": np.moveaxis(e, 2, 0)}
    floats.update({name: value[0].contiguous().numpy() for name, value in trace.items()})
    # Kept exact: the halves of each float and of what rounding left of it.
    stored = {}
    for name, value in floats.items():
        high = value.astype(np.float16)
        stored["test." + name] = high[:, None]
        stored["test." + name + ".rest"] = (value - high.astype(np.float32)).astype(np.float16)[:, None]
    return stored


def main():
    p = argparse.ArgumentParser(description=__doc__)
    p.add_argument("checkpoint", help="by train.py")
    p.add_argument("--as", dest="shipped", choices=list(SHIPPED), help="which of the library's models this is "
                   "(its own name where that is one of them, else default)")
    p.add_argument("-o", "--out", help="denoise/train/weights/kpn.bin or kpn_fast.bin if not given")
    p.add_argument("--test", help="where the test's tensors go: tests/data/ if not given")
    a = p.parse_args()
    state = torch.load(a.checkpoint, weights_only=False, map_location="cpu")
    model = models.from_checkpoint(state)
    name = state.get("network", "default")
    stem = SHIPPED[a.shipped or (name if name in SHIPPED else "default")]
    info = {"network": "kpn", "version": 1, "features": 16, "model": name, "widths": model.widths}
    keep = ("batch", "crop", "rate", "seed", "minutes", "bf16", "l1", "blotches", "ssim", "floor", "model")
    info.update(command="train.py", settings={k: state["arguments"].get(k) for k in keep}, steps=state["steps"],
                seconds=round(state["elapsed"]), views=state["views"], validation=state["log"][-1:])
    tensors = {name: value.numpy().astype(np.float16) for name, value in models.weight_tensors(model).items()}
    model.load_state_dict({n: torch.from_numpy(tensors[n].astype(np.float32)).reshape(v.shape)
                           for n, v in model.state_dict().items()})
    write_whole(a.out or ROOT / f"denoise/train/weights/{stem}.bin", container(tensors, info))
    write_whole(a.test or ROOT / f"tests/data/{stem}_reference.bin",
                container(test_tensors(model), {"weights": stem + ".bin", "made by": "export.py"}))


if __name__ == "__main__":
    main()
