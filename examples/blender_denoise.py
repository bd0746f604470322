# SPDX-License-Identifier: Apache-2.0
"""Denoises what Blender last rendered, by fewray instead of Cycles' own denoiser. In Blender's Python, which has numpy (install fewray there by
`BLENDER/python/bin/python3 -m pip install FEWRAY-WHEEL`): set the output to OpenEXR MultiLayer, switch the passes "Denoising Data" on, render, then

    blender scene.blend --background --python blender_denoise.py -- RENDERED.exr CLEAN.exr

Without fewray's Python package `fewray denoise RENDERED.exr -o CLEAN.exr` does the same and keeps all passes."""

import sys

import fewray
import numpy as np

noisy_path, clean_path = sys.argv[-2:]
frame = fewray.read(noisy_path)
layer = next(name.split(".")[0] for name in frame if name.endswith(".Denoising Albedo.R"))


def channels(name, letters):
    planes = [frame.get(f"{layer}.{name}.{letter}") for letter in letters]
    return None if any(plane is None for plane in planes) else np.stack(planes, axis=2)


color = channels("Noisy Image", "RGB")
color = channels("Combined", "RGB") if color is None else color
clean = fewray.denoise(color, channels("Denoising Albedo", "RGB"), channels("Denoising Normal", "XYZ"))
fewray.write(clean_path, {"color": clean})
