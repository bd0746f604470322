# SPDX-License-Identifier: Apache-2.0
"""The kernel-predicting network. Layer names and their order equal the table in denoise/kpn_network.c.
Run as a program, it prints the models' sizes."""
import math
import re

import torch
import torch.nn as nn
import torch.nn.functional as F

import ops

FEATURES = 16
FINE, COARSE = 25, 9
TAPS = FINE + COARSE
SCALES = 5
KEYS = 8  # floats of a pixel's key: 7 whose differences lower a tap's logit, one that is added to it

# Channels of the levels 0 to 3 of the trunk, at 1/2 to 1/16 of the picture's resolution. Multiples of 16, the lanes of
# denoise/nn; kFLOP a pixel by flops().
WIDTHS = {
    "default": (32, 48, 64, 64),  # 41
    "wide": (32, 48, 96, 128),  # 47
    "fast": (16, 16, 32, 48),  # 12, of which the first layer takes 4.6
    "high": (48, 64, 128, 128),  # 86
}


def layer_list(widths):
    """name, kernel size, channels in, channels out"""
    a, b, c, d = widths
    return [
        ("enc0a", 3, 4 * FEATURES, a), ("enc0b", 3, a, a),
        ("enc1a", 3, a, b), ("enc1b", 3, b, b),
        ("enc2a", 3, b, c), ("enc2b", 3, c, c),
        ("enc3a", 3, c, d), ("enc3b", 3, d, d),
        ("up2", 1, d, c), ("dec2a", 3, c, c), ("dec2b", 3, c, c),
        ("up1", 1, c, b), ("dec1a", 3, b, b), ("dec1b", 3, b, b),
        ("up0", 1, b, a), ("dec0a", 3, a, a), ("dec0b", 3, a, a),
        ("down0", 1, a, 4), ("down1", 1, a, 1), ("down2", 1, b, 1), ("down3", 1, c, 1),
        ("kernel0", 1, a, 4 * TAPS), ("kernel1", 1, a, TAPS), ("kernel2", 1, b, TAPS), ("kernel3", 1, c, TAPS),
        ("kernel4", 1, d, FINE),
        ("key_raw", 1, 4 * FEATURES, 4 * KEYS), ("key", 1, a, 4 * KEYS),
    ]


# Level at whose resolution a layer runs (level l has 1 / 4^(l + 1) of the picture's pixels).
LEVEL = {"up2": 3, "up1": 2, "up0": 1, "down0": 0, "down1": 0, "down2": 1, "down3": 2,
         "kernel0": 0, "kernel1": 0, "kernel2": 1, "kernel3": 2, "kernel4": 3}


def flops(layers):
    """Floating-point operations a pixel of the picture, two for each weight at each place."""
    level = lambda name: LEVEL.get(name, int(re.sub("[^0-9]", "", name) or 0))
    return sum(2 * size * size * inputs * outputs / 4 ** (level(name) + 1) for name, size, inputs, outputs in layers)


def coarse_prior():
    """(4, 9) logits: bilinear upsampling for each place in a 2x2 block; together 1.5 times 25 fine taps of logit 0."""
    prior = torch.full((4, 3, 3), 0.01)
    for place in range(4):
        dy, dx = place // 2, place % 2
        for y, wy in ((1, 0.75), (2 if dy else 0, 0.25)):
            for x, wx in ((1, 0.75), (2 if dx else 0, 0.25)):
                prior[place, y, x] += wy * wx
    return torch.log(prior.reshape(4, 9) * 1.5 * FINE)


def key_prior():
    """(32, 64, 1, 1): a pixel's key from its own features as a cross-bilateral filter has it: albedo, normal, depth."""
    weights = torch.zeros(4, KEYS, FEATURES, 4)
    for place in range(4):
        for key, (feature, weight) in enumerate([(4, 0.7), (5, 0.7), (6, 0.7), (7, 1.5), (8, 1.5), (9, 1.5), (10, 2.0)]):
            weights[place, key, feature, place] = weight
    return weights.reshape(4 * KEYS, 4 * FEATURES, 1, 1)


class KPN(nn.Module):
    def __init__(self, widths=WIDTHS["default"]):
        super().__init__()
        self.widths = tuple(widths)
        for name, size, inputs, outputs in layer_list(widths):
            conv = nn.Conv2d(inputs, outputs, size, padding=size // 2)
            if name.startswith(("kernel", "down", "key")):
                nn.init.normal_(conv.weight, std=0.3 / math.sqrt(inputs))
            else:
                nn.init.kaiming_normal_(conv.weight, a=0.2)
            nn.init.zeros_(conv.bias)
            self.add_module(name, conv)
        with torch.no_grad():
            self.kernel0.bias.view(4, TAPS)[:, FINE:] = coarse_prior()
            self.key.weight.normal_(std=0.02).view(4, KEYS, -1)[:, -1] = 0
            self.key_raw.weight.copy_(key_prior())
        # Logarithms of what weighs the keys' differences; taps of a coarser level lie farther apart.
        for s in range(SCALES):
            self.register_parameter(f"scale{s}", nn.Parameter(torch.full((2, KEYS - 1), -s * math.log(4))))
        for s in (1, 2, 3):
            self.register_parameter(f"parity{s}", nn.Parameter(coarse_prior()))

    def layer(self, name, x, trace):
        x = F.leaky_relu(self.get_submodule(name)(x), 0.2)
        if trace is not None:
            trace[name] = x
        return x

    def trunk(self, features, trace=None):
        """(N, H/2, W/2, 64) of ops.features(), H and W multiples of 16 -> features of the scales 0 and 1 (one tensor), 2, 3, 4."""
        x = features.permute(0, 3, 1, 2)
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

    def keys(self, features, dec0):
        """(N, H, W, 8)"""
        key = (self.key_raw(features.permute(0, 3, 1, 2)) + self.key(dec0)).float()
        n, _, h, w = key.shape
        key = key.view(n, 2, 2, KEYS, h, w).permute(0, 4, 1, 5, 2, 3)
        return key.reshape(n, 2 * h, 2 * w, KEYS).contiguous()

    def forward(self, features, irradiance, trace=None):
        """features (N, H/2, W/2, 64), irradiance (N, H, W, 3) -> filtered irradiance (N, H, W, 3)."""
        dec0, dec1, dec2, enc3 = self.trunk(features, trace)
        inputs = [dec0, dec0, dec1, dec2, enc3]
        e, keys = [irradiance.contiguous()], [self.keys(features, dec0)]
        if trace is not None:
            trace["key"] = keys[0].permute(0, 3, 1, 2)
        for s in range(SCALES - 1):
            logits = self.get_submodule(f"down{s}")(inputs[s])
            if s > 0:
                logits = F.pixel_unshuffle(logits, 2)
            weights = logits.float().softmax(1).permute(0, 2, 3, 1)  # (N, h, w, 4)
            n, h, w, _ = weights.shape
            for pyramid in (e, keys):
                fine = pyramid[s].view(n, h, 2, w, 2, -1).permute(0, 1, 3, 2, 4, 5).reshape(n, h, w, 4, -1)
                pyramid.append((weights.unsqueeze(-1) * fine).sum(3).contiguous())
            if trace is not None:
                trace[f"down{s}"] = e[-1].permute(0, 3, 1, 2)
        out = None
        for s in reversed(range(SCALES)):
            logits = self.get_submodule(f"kernel{s}")(inputs[s])
            parity = self.get_parameter(f"parity{s}") if s in (1, 2, 3) else None
            scale = F.pad(self.get_parameter(f"scale{s}").exp(), (0, 1))
            coarse_keys = keys[s + 1] if out is not None else None
            out = ops.apply_kernels(logits, parity, e[s], out, keys[s], coarse_keys, scale)
            if trace is not None:
                trace[f"kernel{s}"] = out.permute(0, 3, 1, 2)
        return out


def weight_tensors(model):
    """name -> tensor, as the weights file has them: parity as (4, 9, 1, 1), a bias as (out, 1, 1, 1)."""
    tensors = {}
    for name, value in model.state_dict().items():
        tensors[name] = value if value.dim() == 4 else value.reshape(value.shape + (1,) * (4 - value.dim()))
    return tensors


def build(name):
    """An untrained model by the name that train.py's --model takes."""
    return KPN(WIDTHS[name])


def from_checkpoint(state):
    """The averaged weights of a checkpoint as a model; checkpoints of before there were names are default ones."""
    model = build(state.get("network", "default"))
    model.load_state_dict(state["average"])
    return model


def start_from(model, weights):
    """Takes over another model's weights, of other widths or fewer features. The channels that both have are copied. New
    channels start with random weights, but what the old ones read of them is 0: a model that only grew computes what the
    other one did."""
    own = model.state_dict()
    for name, value in own.items():
        if name not in weights:
            continue
        old = weights[name]
        shared = tuple(slice(min(n, o)) for n, o in zip(value.shape, old.shape))
        if value.dim() == 4:
            value[shared[0]] = 0
        else:
            value.zero_()
        value[shared] = old[shared]
    model.load_state_dict(own)


if __name__ == "__main__":
    for name, widths in WIDTHS.items():
        weights = sum(p.numel() for p in build(name).parameters())
        print(f"{name}: {widths}, {flops(layer_list(widths)) / 1000:.1f} kFLOP a pixel, {weights} weights")
