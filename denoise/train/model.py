# SPDX-License-Identifier: Apache-2.0
"""The kernel-predicting network. Layer names and their order equal the table in denoise/kpn.c."""
import math

import torch
import torch.nn as nn
import torch.nn.functional as F

import ops

FEATURES = 16
FINE, COARSE = 25, 9
TAPS = FINE + COARSE
SCALES = 5

# name, kernel size, channels in, channels out
LAYERS = [
    ("enc0a", 3, 64, 32), ("enc0b", 3, 32, 32),
    ("enc1a", 3, 32, 48), ("enc1b", 3, 48, 48),
    ("enc2a", 3, 48, 64), ("enc2b", 3, 64, 64),
    ("enc3a", 3, 64, 64), ("enc3b", 3, 64, 64),
    ("up2", 1, 64, 64), ("dec2a", 3, 64, 64), ("dec2b", 3, 64, 64),
    ("up1", 1, 64, 48), ("dec1a", 3, 48, 48), ("dec1b", 3, 48, 48),
    ("up0", 1, 48, 32), ("dec0a", 3, 32, 32), ("dec0b", 3, 32, 32),
    ("down0", 1, 32, 4), ("down1", 1, 32, 1), ("down2", 1, 48, 1), ("down3", 1, 64, 1),
    ("kernel0", 1, 32, 4 * TAPS), ("kernel1", 1, 32, TAPS), ("kernel2", 1, 48, TAPS), ("kernel3", 1, 64, TAPS),
    ("kernel4", 1, 64, FINE),
]


def coarse_prior():
    """(4, 9) logits: bilinear upsampling for each place in a 2x2 block; together 1.5 times 25 fine taps of logit 0."""
    prior = torch.full((4, 3, 3), 0.01)
    for place in range(4):
        dy, dx = place // 2, place % 2
        for y, wy in ((1, 0.75), (2 if dy else 0, 0.25)):
            for x, wx in ((1, 0.75), (2 if dx else 0, 0.25)):
                prior[place, y, x] += wy * wx
    return torch.log(prior.reshape(4, 9) * 1.5 * FINE)


class KPN(nn.Module):
    def __init__(self):
        super().__init__()
        for name, size, inputs, outputs in LAYERS:
            conv = nn.Conv2d(inputs, outputs, size, padding=size // 2)
            if name.startswith(("kernel", "down")):
                nn.init.normal_(conv.weight, std=0.3 / math.sqrt(inputs))
            else:
                nn.init.kaiming_normal_(conv.weight, a=0.2)
            nn.init.zeros_(conv.bias)
            self.add_module(name, conv)
        with torch.no_grad():
            self.kernel0.bias.view(4, TAPS)[:, FINE:] = coarse_prior()
        for s in (1, 2, 3):
            self.register_parameter(f"parity{s}", nn.Parameter(coarse_prior()))

    def layer(self, name, x, trace):
        x = F.leaky_relu(self.get_submodule(name)(x), 0.2)
        if trace is not None:
            trace[name] = x
        return x

    def trunk(self, features, trace=None):
        """(N, 16, H, W), H and W multiples of 16 -> features of the scales 0 and 1 (one tensor), 2, 3, 4."""
        x = F.pixel_unshuffle(features, 2).contiguous(memory_format=torch.channels_last)
        skips = []
        for i in range(4):
            x = self.layer(f"enc{i}b", self.layer(f"enc{i}a", x, trace), trace)
            skips.append(x)
            if i < 3:
                x = F.avg_pool2d(x, 2)
        levels = [x]
        for i in (2, 1, 0):
            x = self.layer(f"up{i}", x, trace)
            x = skips[i] + F.interpolate(x, scale_factor=2, mode="nearest")
            x = self.layer(f"dec{i}b", self.layer(f"dec{i}a", x, trace), trace)
            levels.append(x)
        return levels[::-1]

    def forward(self, features, irradiance, trace=None):
        """features (N, 16, H, W), irradiance (N, H, W, 3) -> filtered irradiance (N, H, W, 3)."""
        dec0, dec1, dec2, enc3 = self.trunk(features, trace)
        inputs = [dec0, dec0, dec1, dec2, enc3]
        e = [irradiance.contiguous()]
        for s in range(SCALES - 1):
            logits = self.get_submodule(f"down{s}")(inputs[s])
            if s > 0:
                logits = F.pixel_unshuffle(logits, 2)
            weights = logits.float().softmax(1).permute(0, 2, 3, 1)  # (N, h, w, 4)
            n, h, w, _ = weights.shape
            fine = e[s].view(n, h, 2, w, 2, 3).permute(0, 1, 3, 2, 4, 5).reshape(n, h, w, 4, 3)
            e.append((weights.unsqueeze(-1) * fine).sum(3).contiguous())
            if trace is not None:
                trace[f"down{s}"] = e[-1].permute(0, 3, 1, 2)
        out = None
        for s in reversed(range(SCALES)):
            logits = self.get_submodule(f"kernel{s}")(inputs[s])
            parity = self.get_parameter(f"parity{s}") if s in (1, 2, 3) else None
            out = ops.apply_kernels(logits, parity, e[s], out)
            if trace is not None:
                trace[f"kernel{s}"] = out.permute(0, 3, 1, 2)
        return out


def weight_tensors(model):
    """name -> tensor, as the weights file has them: parity as (4, 9, 1, 1), a bias as (out, 1, 1, 1)."""
    tensors = {}
    for name, value in model.state_dict().items():
        tensors[name] = value if value.dim() == 4 else value.reshape(value.shape + (1,) * (4 - value.dim()))
    return tensors
