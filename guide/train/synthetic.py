# SPDX-License-Identifier: Apache-2.0
"""Writes made-up records in the format of fewray-odis-data, to try the training without a
renderer: each map has a few bright caps over a dim sphere, seen by one noisy sample in a quarter
of the bins."""
import argparse

import numpy as np

from dataset import RECORD, header
from model import COLUMNS, MU, ROWS


def directions():
    y = 1 - (np.arange(ROWS) + 0.5) * 2 / ROWS
    phi = (np.arange(COLUMNS) + 0.5) * 2 * np.pi / COLUMNS
    r = np.sqrt(1 - y * y)[:, None]
    return np.stack([r * np.sin(phi), np.repeat(y[:, None], COLUMNS, 1), r * np.cos(phi)], -1)


def coarse_fill(sample, mask):
    """Mean of each 4x4 block's filled bins, or of all filled bins."""
    blocks = lambda a: a.reshape(8, 4, 8, 4).sum((1, 3))
    count, total = blocks(mask), blocks(sample * mask)
    mean = (total + sample[mask > 0].mean()) / (count + 1)
    return np.log(np.kron(mean, np.ones((4, 4))) + 1e-3)


def make(rng, scene, dirs):
    record = np.zeros((), RECORD)
    normal = rng.normal(size=3)
    normal /= np.linalg.norm(normal)
    cosine = np.maximum(dirs @ normal, 0)
    truth = np.full((ROWS, COLUMNS), rng.uniform(0.01, 0.3))
    for _ in range(rng.integers(1, 4)):
        axis = rng.normal(size=3)
        axis /= np.linalg.norm(axis)
        truth += np.exp(rng.uniform(0, 3)) * ((dirs @ axis) > rng.uniform(0.85, 0.99))
    noisy = truth * rng.gamma(1, 1, truth.shape)
    mask = ((rng.random(truth.shape) < 0.25) & (cosine > 0)).astype(np.float64)
    mask.flat[np.argmax(cosine)] = 1
    scale = noisy[mask > 0].mean()
    compress = lambda v: np.log1p(MU * v) / np.log1p(MU)
    record["scene"], record["samples"], record["window"] = scene, 1, 3
    radiance, normals = compress(noisy / scale), [np.full_like(truth, n) for n in normal]
    planes = [radiance, radiance, radiance, np.full_like(truth, 0.25), np.ones_like(truth),
              *normals, np.full_like(truth, 0.7), *[-dirs[..., i] for i in range(3)]]
    record["input"][:12] = np.stack(planes) * mask
    record["input"][12], record["input"][13] = mask, cosine
    record["input"][14] = coarse_fill(noisy / scale, mask)
    target = np.stack([truth, truth * np.sqrt(2)]) / scale * (cosine > 0)
    record["target_scale"] = target.max() / 32768
    record["target"] = target / record["target_scale"]
    return record


def main():
    p = argparse.ArgumentParser(description=__doc__)
    p.add_argument("-o", "--output", required=True)
    p.add_argument("--maps", type=int, default=2000)
    p.add_argument("--scenes", type=int, default=20)
    p.add_argument("--seed", type=int, default=1)
    args = p.parse_args()
    rng, dirs = np.random.default_rng(args.seed), directions()
    with open(args.output, "wb") as file:
        file.write(header())
        for i in range(args.maps):
            file.write(make(rng, i * args.scenes // args.maps, dirs).tobytes())


if __name__ == "__main__":
    main()
