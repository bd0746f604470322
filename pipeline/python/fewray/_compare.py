# SPDX-License-Identifier: Apache-2.0
"""Metrics."""

import ctypes as C
from dataclasses import dataclass
from typing import Any

from . import _library as L
from . import _structs as S
from ._arrays import size_of
from ._frame import Frame


@dataclass(frozen=True)
class Metrics:
    """Of a picture x against a reference r, both linear RGB; lower is better but for psnr; NaN: not known.

    mrse: mean of (x - r)^2 / (r^2 + 0.01), without unit; mrse_trimmed: without the worst 0.01 % of the pixels; mrse_top1: share
    (0..1) of the mrse that lies in the worst 1 %; mse, l1: radiance^2 and radiance; mape: mean of |x - r| / (|r| + 0.01);
    psnr: dB, ssim_loss: 1 - SSIM, flip: 0..1, these three of the pictures as a display shows them (sRGB); ref_mrse: the
    reference's own noise, where it has stderr.R/G/B, and mrse_net: mrse less that; n_nonfinite, n_ref_nonfinite: pixels.
    """

    mrse: float
    mrse_trimmed: float
    mrse_top1: float
    mse: float
    mape: float
    l1: float
    psnr: float
    ssim_loss: float
    flip: float
    ref_mrse: float
    mrse_net: float
    n_nonfinite: int
    n_ref_nonfinite: int


def _as_frame(picture: Any, name: str) -> Frame:
    if isinstance(picture, Frame):
        return picture
    height, width = size_of(picture, name)
    frame = Frame(width, height)
    frame.set_layer("color", picture)
    return frame


def compare(test: Any, reference: Any) -> Metrics:
    """The error of a picture against a reference of the same size: Frames, or arrays (height, width, 3) of linear RGB, which
    are copied into planes."""
    frames = _as_frame(test, "test"), _as_frame(reference, "reference")
    metrics = S.fewray_metrics()
    L.run(lambda error: L.function("fewray_compare")(frames[0]._pointer, frames[1]._pointer, C.byref(metrics), C.byref(error)))
    return Metrics(**{name: getattr(metrics, name) for name, _ in S.fewray_metrics._fields_})
