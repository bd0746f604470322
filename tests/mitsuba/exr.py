# SPDX-License-Identifier: Apache-2.0
"""EXR pictures by channel name, and the metrics of pictures, for the scripts that compare denoisers."""
import json
import subprocess

import numpy as np
import OpenEXR


def read(path):
    """{channel name: float32 plane (H, W)}"""
    with OpenEXR.File(str(path), separate_channels=True) as f:
        return {name: np.array(c.pixels, dtype=np.float32) for name, c in f.channels().items()}


def write(path, planes):
    with OpenEXR.File({"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage},
                      {name: np.ascontiguousarray(plane) for name, plane in planes.items()}) as f:
        f.write(str(path))


def stacked(planes, *names):
    """(H, W, 3), or None where the file lacks one."""
    return np.stack([planes[n] for n in names], axis=2) if all(n in planes for n in names) else None


def write_rgb(path, image):
    write(path, {c: image[:, :, i] for i, c in enumerate("RGB")})


def _display(linear):
    v = np.clip(linear, 0, 1)
    return np.where(v <= 0.0031308, 12.92 * v, 1.055 * v ** (1 / 2.4) - 0.055).astype(np.float32)


def measure(fewray, path, reference):
    """What `fewray compare` says, and, where flip_evaluator is installed, the mean LDR-FLIP at 67 pixels a degree."""
    run = subprocess.run([fewray, "compare", str(path), str(reference), "--json"], check=True, capture_output=True)
    figures = json.loads(run.stdout)
    try:
        import flip_evaluator
    except ImportError:
        figures["flip"] = float("nan")
        return figures
    test, truth = (np.ascontiguousarray(_display(stacked(read(p), *"RGB"))) for p in (path, reference))
    figures["flip"] = float(flip_evaluator.evaluate(truth, test, "LDR", applyMagma=False)[1])
    return figures
