# SPDX-License-Identifier: Apache-2.0
"""Denoises what Blender rendered, by fewray instead of Cycles' own denoiser. Install fewray into Blender's Python once:
`BLENDER/python/bin/python3 -m pip install FEWRAY-WHEEL`. Set the output to OpenEXR MultiLayer, switch the passes "Denoising Data" on, render, then

    blender scene.blend --background --python blender_denoise.py -- RENDERED.exr CLEAN.exr

`fewray denoise RENDERED.exr -o CLEAN.exr` does the same and keeps all passes."""

import sys

import fewray

noisy_path, clean_path = sys.argv[-2:]
frame = fewray.read(noisy_path, noisy=True)
fewray.write(clean_path, {"color": fewray.denoise(frame.color, frame.albedo, frame.normal, frame.depth)})
