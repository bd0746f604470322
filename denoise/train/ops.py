# SPDX-License-Identifier: Apache-2.0
"""What training takes from C (ops_kpn.c): features and kernel application. FEWRAY_KPN_OPS names the shared library."""
import ctypes
import os
from pathlib import Path

import numpy as np
import torch

RAW_CHANNELS = 23  # color, emission, variance, albedo, normal (3 each), depth, irradiance, confidence, shaded albedo
FEATURES = 16
EMISSION, VARIANCE, ALBEDO, NORMAL, DEPTH, GUIDE = 1, 2, 4, 8, 16, 32
ALBEDO_MIN = 0.01


def load():
    path = os.environ.get("FEWRAY_KPN_OPS")
    if not path:
        path = Path(__file__).resolve().parents[2] / "build" / "libfewray-kpn-ops.so"
    return ctypes.CDLL(str(path))


library = load()


def pointer(array):
    if array is None:
        return None
    if isinstance(array, torch.Tensor):
        return ctypes.c_void_p(array.data_ptr())
    return ctypes.c_void_p(array.ctypes.data)


def features(raw, layers, exposure, log2_depth):
    """raw (23, H, W) float32 -> features (H/2, W/2, 64), channel 4 c + 2 dy + dx of pixel (dy, dx), irradiance (H, W, 3)."""
    raw = np.ascontiguousarray(raw, np.float32)
    _, height, width = raw.shape
    f = np.empty((height // 2, width // 2, 4 * FEATURES), np.float32)
    e = np.empty((height, width, 3), np.float32)
    if library.kpn_train_features(pointer(raw), height, width, layers, ctypes.c_float(exposure),
                                  ctypes.c_float(log2_depth), pointer(f), pointer(e)):
        raise MemoryError
    return f, e


def measure(raw, layers):
    """Exposure and log2 of the depth scale of a whole picture, raw (23, H, W)."""
    raw = np.ascontiguousarray(raw, np.float32)
    exposure, depth = ctypes.c_float(), ctypes.c_float()
    if library.kpn_train_measure(pointer(raw), raw.shape[1], raw.shape[2], layers, ctypes.byref(exposure),
                                 ctypes.byref(depth)):
        raise MemoryError
    return exposure.value, depth.value


class ApplyKernels(torch.autograd.Function):
    @staticmethod
    def forward(ctx, logits, parity, fine, coarse, key_fine, key_coarse, scale):
        logits = logits.contiguous()
        n, height, width, _ = fine.shape
        sub = height // logits.shape[1]
        taps = 34 if coarse is not None else 25
        ctx.shape = (n, height, width, sub, logits.shape[3], taps)
        out = torch.empty_like(fine)
        weights = torch.empty(n, height, width, taps)
        if library.kpn_apply_forward(*ctx.shape, pointer(logits), pointer(parity), pointer(fine), pointer(coarse),
                                     pointer(key_fine), pointer(key_coarse), pointer(scale), pointer(weights), pointer(out),
                                     torch.get_num_threads()):
            raise MemoryError
        ctx.save_for_backward(logits, parity, fine, coarse, key_fine, key_coarse, scale, weights)
        return out

    @staticmethod
    def backward(ctx, grad_out):
        logits, parity, fine, coarse, key_fine, key_coarse, scale, weights = ctx.saved_tensors
        grad_logits = torch.zeros_like(logits)
        grad_fine = torch.zeros_like(fine) if ctx.needs_input_grad[2] else None
        grad_coarse = torch.zeros_like(coarse) if coarse is not None else None
        grad_parity = torch.zeros(fine.shape[0], 4, 9) if parity is not None else None
        grad_key_fine = torch.zeros_like(key_fine)
        grad_key_coarse = torch.zeros_like(key_coarse) if coarse is not None else None
        grad_scale = torch.zeros(fine.shape[0], 2, 8)
        if library.kpn_apply_backward(*ctx.shape, pointer(logits), pointer(parity), pointer(fine), pointer(coarse),
                                      pointer(key_fine), pointer(key_coarse), pointer(scale), pointer(weights),
                                      pointer(grad_out.contiguous()), pointer(grad_logits), pointer(grad_parity),
                                      pointer(grad_fine), pointer(grad_coarse), pointer(grad_key_fine),
                                      pointer(grad_key_coarse), pointer(grad_scale), torch.get_num_threads()):
            raise MemoryError
        return (grad_logits, None if parity is None else grad_parity.sum(0), grad_fine, grad_coarse, grad_key_fine,
                grad_key_coarse, grad_scale.sum(0))


def apply_kernels(logits, parity, fine, coarse, key_fine, key_coarse, scale):
    """logits (N, C, h, w), fine (N, H, W, 3) contiguous, coarse (N, H/2, W/2, 3) or None, keys (N, H, W, 8) and
    (N, H/2, W/2, 8), scale (2, 8) -> (N, H, W, 3)."""
    return ApplyKernels.apply(logits.permute(0, 2, 3, 1).float(), parity, fine, coarse, key_fine, key_coarse,
                              scale.contiguous())
