#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Denoises an EXR in Python: denoise.py NOISY.exr CLEAN.exr [REFERENCE.exr]"""

import sys

import fewray

noisy = fewray.read(sys.argv[1])
clean = fewray.denoise(noisy.color, noisy.albedo, noisy.normal, noisy.depth, noisy.layer("variance"))
fewray.write(sys.argv[2], {"color": clean, "noisy": noisy.color})
if len(sys.argv) > 3:
    reference = fewray.read(sys.argv[3])
    before, after = fewray.compare(noisy, reference), fewray.compare(clean, reference.color)
    print(f"mrse {before.mrse:.4g} before, {after.mrse:.4g} after")
