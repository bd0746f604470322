# SPDX-License-Identifier: Apache-2.0
"""The ODIS network and its discriminator. guide/odis/network.c runs the same layers, by the same
names, in C."""
import math

import torch
import torch.nn as nn
import torch.nn.functional as F

ROWS = COLUMNS = 32
# Gathered planes of a bin (guide/odis/gather.h), by the names that --drop and a weights file's info
# use.
PLANE_NAMES = {"radiance": (0,), "pooled": (1,), "moment": (2,), "count": (3,), "depth": (4,),
               "normal": (5, 6, 7), "distance": (8,), "second_normal": (9, 10, 11)}
PLANES = 12
MASK, COSINE, FILL = 12, 13, 14
INPUTS = 15
FILL_SCALE = 0.25              # brings the fill's natural logarithm to the size of the other inputs
MU = 5000.0                    # of the range compressor (paper, eq. 3)
SLOPE = 0.2                    # of the leaky ReLU
FRACTION_LEAST = 0.05          # of the samples come from the BSDF at least: keeps weights bounded
FRACTION_START = 0.3           # before training


def range_compress(radiance):
    return torch.log1p(MU * radiance) / math.log1p(MU)


def range_expand(compressed):
    return torch.expm1(compressed * math.log1p(MU)) / MU


def space_to_depth(bins):
    """(N, C, 32, 32) -> (N, 4 C, 16, 16); channel (2 dy + dx) C + c of a cell is channel c of its
    bin (2 y + dy, 2 x + dx)."""
    n, c, h, w = bins.shape
    cells = bins.reshape(n, c, h // 2, 2, w // 2, 2).permute(0, 3, 5, 1, 2, 4)
    return cells.reshape(n, 4 * c, h // 2, w // 2)


class SphereConv(nn.Conv2d):
    """3x3 over the sphere's bins: columns wrap around, rows above and below are zero."""

    def __init__(self, inputs, outputs):
        super().__init__(inputs, outputs, 3)

    def forward(self, x):
        return super().forward(F.pad(F.pad(x, (1, 1, 0, 0), mode="circular"), (0, 0, 1, 1)))


class Odis(nn.Module):
    """(N, 15, 32, 32) gathered bins -> (N, 2, 32, 32): log of the root second moment,
    range-compressed mean radiance; and (N): the fraction of samples for the BSDF."""

    def __init__(self):
        super().__init__()
        self.stem = nn.Conv2d(4 * INPUTS, 16, 1)  # 16x16
        self.enc1 = SphereConv(16, 32)            # 8x8
        self.enc2a = SphereConv(32, 48)           # 4x4
        self.enc2b = SphereConv(48, 48)
        self.up1 = nn.Conv2d(48, 32, 1)
        self.dec1 = SphereConv(32, 32)            # 8x8
        self.up0 = nn.Conv2d(32, 16, 1)
        self.dec0 = SphereConv(16, 16)            # 16x16
        self.head = nn.Conv2d(16, 8, 1)
        self.mix = nn.Conv2d(48, 1, 1)            # 1x1
        for layer in self.children():
            nn.init.kaiming_normal_(layer.weight, a=SLOPE)
            nn.init.zeros_(layer.bias)
        nn.init.normal_(self.head.weight, std=0.01)  # starts as the fill alone
        nn.init.normal_(self.mix.weight, std=0.01)
        share = (FRACTION_START - FRACTION_LEAST) / (1 - FRACTION_LEAST)
        nn.init.constant_(self.mix.bias, math.log(share / (1 - share)))

    @staticmethod
    def cells(bins):
        """The stem's input, 2x2 bins at once. Masked: the gathered planes are scaled by 4 / filled
        bins."""
        filled = F.avg_pool2d(bins[:, MASK:MASK + 1], 2)
        gain = torch.where(filled > 0, 1 / filled.clamp(min=0.25), torch.zeros_like(filled))
        gain = F.interpolate(gain, scale_factor=2, mode="nearest")
        planes, fill = bins[:, :PLANES] * gain, bins[:, FILL:] * FILL_SCALE
        return space_to_depth(torch.cat([planes, bins[:, MASK:FILL], fill], 1))

    def layers(self, bins):
        """All layers' outputs by name, after the activation; up1 and up0 before they meet the
        skip."""
        out = {}

        def run(name, x, activate=True):
            y = getattr(self, name)(x)
            out[name] = F.leaky_relu(y, SLOPE) if activate else y
            return out[name]

        up = dict(scale_factor=2, mode="nearest")
        e0 = run("stem", self.cells(bins))
        e1 = run("enc1", F.avg_pool2d(e0, 2))
        e2 = run("enc2b", run("enc2a", F.avg_pool2d(e1, 2)))
        d1 = run("dec1", e1 + F.interpolate(run("up1", e2, False), **up))
        d0 = run("dec0", e0 + F.interpolate(run("up0", d1, False), **up))
        run("head", d0, False)
        run("mix", e2.mean((2, 3), keepdim=True), False)
        return out

    def forward(self, bins):
        layers = self.layers(bins)
        correction, radiance = F.pixel_shuffle(layers["head"], 2).split(1, 1)
        fraction = FRACTION_LEAST + (1 - FRACTION_LEAST) * torch.sigmoid(layers["mix"].flatten())
        return torch.cat([bins[:, FILL:] + correction, radiance], 1), fraction


class Discriminator(nn.Module):
    """Tells range-compressed truth from prediction (paper, section 4.4): (N, 1, 32, 32) -> (N)
    logits."""

    def __init__(self):
        super().__init__()
        blocks, inputs = [], 1
        for outputs in (16, 32, 64, 128):
            blocks += [SphereConv(inputs, outputs), nn.BatchNorm2d(outputs), nn.LeakyReLU(SLOPE)]
            if outputs < 128:
                blocks.append(nn.AvgPool2d(2))
            inputs = outputs
        self.blocks = nn.Sequential(*blocks)
        self.dense = nn.Sequential(nn.Flatten(), nn.Linear(128 * 16, 256), nn.LeakyReLU(SLOPE),
                                   nn.Linear(256, 1))
        for layer in self.modules():
            if isinstance(layer, nn.Conv2d):
                nn.init.trunc_normal_(layer.weight, std=0.02)

    def forward(self, radiance):
        return self.dense(self.blocks(radiance)).squeeze(1)
