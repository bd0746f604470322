# SPDX-License-Identifier: Apache-2.0
"""What the network is trained on, and the same measure for maps that need no network."""
import torch
import torch.nn.functional as F

from model import COSINE, FILL, range_compress, range_expand


MEAN_LEAST = 1e-3  # of a mean map before the cosine, in units of the gathered scale (network.c)


def normalized(values):
    return values / values.sum((1, 2), keepdim=True).clamp(min=1e-30)


def sampling_map(log_moment, cosine):
    """Shares of the bins, proportional to exp(log_moment) * cosine. (N, 32, 32)"""
    logits = log_moment + torch.log(cosine.clamp(min=1e-6))
    logits = torch.where(cosine > 0, logits, torch.full_like(cosine, -1e9))
    return torch.softmax(logits.flatten(1), 1).reshape(cosine.shape)


def log_excess(shares, inputs, targets, fraction):
    """(N): log of the second moment that the map causes in a one-sample mixture with the cosine
    density, sum_b t_b^2 / (a q_b + (1 - a) p_b) / (sum_b t_b)^2 with t = cosine * sqrt(E[L^2]) and
    a the fraction, a number or (N); 0 were the mixture the best possible map. The divisor doesn't
    depend on the network: it only lets bright and dark maps count alike."""
    cosine = inputs[:, COSINE]
    truth, density = normalized(cosine * targets[:, 1]), normalized(cosine)
    if torch.is_tensor(fraction):
        fraction = fraction[:, None, None]
    mixture = fraction * density + (1 - fraction) * shares
    return torch.log((truth ** 2 / mixture.clamp(min=1e-12)).sum((1, 2)))


def radiance_l1(output, inputs, targets):
    """Mean absolute difference of range-compressed radiance over the hemisphere (paper, eq. 4)."""
    valid = (inputs[:, COSINE] > 0).float()
    difference = (output[:, 1] - range_compress(targets[:, 0])).abs() * valid
    return difference.sum() / valid.sum()


def map_of(output, inputs, mode):
    """The sampling map: of the second moment, or of the mean radiance as in the paper ('l1')."""
    if mode == "l1":
        radiance = range_expand(output[:, 1].clamp(0, 4))
        return normalized(radiance.clamp(min=MEAN_LEAST) * inputs[:, COSINE])
    return sampling_map(output[:, 0], inputs[:, COSINE])


def reference_maps(inputs, targets):
    """{name: (map, fraction)} to compare with."""
    cosine = inputs[:, COSINE]
    fill = sampling_map(inputs[:, FILL], cosine)
    return {"fill only, a 0.25": (fill, 0.25), "fill only, a 0.5": (fill, 0.5),
            "perfect map, a 0.25": (normalized(cosine * targets[:, 1]), 0.25),
            "perfect mean map, a 0.25": (normalized(cosine * targets[:, 0]), 0.25),
            "cosine only": (normalized(cosine), 1)}


def adversarial(logits, real):
    return F.binary_cross_entropy_with_logits(logits, torch.full_like(logits, float(real)))
