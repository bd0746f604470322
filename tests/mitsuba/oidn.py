# SPDX-License-Identifier: Apache-2.0
"""Open Image Denoise for the scripts that compare with it: by a Python module with pyoidn's interface, or by the command
oidnDenoise that comes with it. RT filter, HDR, high quality, auxiliary layers as they were rendered (not prefiltered)."""
import importlib
import subprocess
import tempfile
from pathlib import Path

import numpy as np


def add_options(parser):
    parser.add_argument("--oidn", default="pyoidn", metavar="MODULE", help="Python module of Open Image Denoise (pyoidn)")
    parser.add_argument("--oidn-command", metavar="COMMAND", help="use this oidnDenoise instead of the module")


def opened(options):
    """A function of color, albedo, normal: arrays (H, W, 3), the last two may be None; it returns the denoised color."""
    denoise = _by_command(options.oidn_command) if options.oidn_command else _by_module(options.oidn)

    def checked(color, albedo=None, normal=None):
        layers = {"color": color, "albedo": albedo, "normal": normal if albedo is not None else None}  # no normal without albedo
        return denoise({k: np.ascontiguousarray(v, dtype=np.float32) for k, v in layers.items() if v is not None})
    return checked


def _by_module(name):
    oidn = importlib.import_module(name)
    device = oidn.Device(oidn.OIDN_DEVICE_TYPE_CPU)
    device.commit()

    def denoise(layers):
        out = np.zeros_like(layers["color"])
        with oidn.Filter(device, oidn.OIDN_FILTER_TYPE_RT) as f:
            for layer, image in layers.items():
                f.set_image(layer, image, oidn.OIDN_FORMAT_FLOAT3)
            f.set_image("output", out, oidn.OIDN_FORMAT_FLOAT3)
            f.set_quality(oidn.OIDN_QUALITY_HIGH)
            f.set_bool("hdr", True)
            f.commit()
            f.execute()
        if device.get_error():
            raise SystemExit(f"OIDN: {device.get_error()}")
        return out
    return denoise


def _by_command(command):
    def denoise(layers):
        with tempfile.TemporaryDirectory() as folder:
            arguments = [command, "--quality", "high", "-o", f"{folder}/out.pfm"]
            for layer, option in (("color", "--hdr"), ("albedo", "--alb"), ("normal", "--nrm")):
                if layer in layers:
                    _write_pfm(f"{folder}/{layer}.pfm", layers[layer])
                    arguments += [option, f"{folder}/{layer}.pfm"]
            subprocess.run(arguments, check=True, stdout=subprocess.DEVNULL)
            return _read_pfm(f"{folder}/out.pfm")
    return denoise


def _write_pfm(path, image):
    header = f"PF\n{image.shape[1]} {image.shape[0]}\n-1.0\n".encode()
    Path(path).write_bytes(header + image[::-1].astype("<f4").tobytes())


def _read_pfm(path):
    _, size, _, data = Path(path).read_bytes().split(b"\n", 3)
    width, height = map(int, size.split())
    return np.frombuffer(data, "<f4").reshape(height, width, 3)[::-1].copy()
