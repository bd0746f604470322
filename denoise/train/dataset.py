# SPDX-License-Identifier: Apache-2.0
"""Training crops from records: DATA/SCENE--VIEW/ref.npy and DATA/SCENE--VIEW/SPP-*.npy as make_data.py leaves them."""
import queue
import threading
import zlib
from pathlib import Path

import numpy as np
import torch

import ops

DROPOUT = {ops.EMISSION: 0.1, ops.VARIANCE: 0.12, ops.ALBEDO: 0.08, ops.NORMAL: 0.08, ops.DEPTH: 0.15, ops.GUIDE: 0.1}
RESCAN = 500  # batches, after which new views are looked for
EXPOSURE_OFF = 0.05  # share of crops whose exposure is measured wrong by up to 2^8, as in pictures of mostly lamps or night
RANDOM_ALBEDO = 0.3  # share of crops whose materials are painted over
COLOR_ALONE = 0.06  # share of crops without any other layer
ALL_LAYERS = ops.EMISSION | ops.VARIANCE | ops.ALBEDO | ops.NORMAL | ops.DEPTH | ops.GUIDE
LUMINANCE = np.array([0.2126, 0.7152, 0.0722], np.float32)


class View:
    """One camera position: a reference and its noisy renders, mapped into memory."""

    def __init__(self, path):
        self.path = path
        files = [f for f in sorted(path.glob("*.npy")) if f.name != "ref.npy"]
        self.noisy = [np.load(f, mmap_mode="r") for f in files]
        self.spp = [int(f.name.split("-")[0]) for f in files]
        self.guides = [f.name.split("-")[1] for f in files]
        self.ref = np.load(path / "ref.npy", mmap_mode="r")
        self.scales = {}
        light = floats(self.ref[::2, ::2]) @ LUMINANCE
        self.gain = 0.18 / max(float(np.exp(np.log(light + 1e-3 * light.mean() + 1e-8).mean())), 1e-8)

    def scale(self, i, layers):
        key = (i, layers & (ops.ALBEDO | ops.EMISSION))
        if key not in self.scales:
            self.scales[key] = ops.measure(raw_layers(floats(self.noisy[i]), layers), layers)
        return self.scales[key]


def floats(halves):
    """Single precision copy, by PyTorch: many times faster than numpy's conversion."""
    return torch.from_numpy(halves.copy()).float().numpy()


def raw_layers(record, layers):
    """(H, W, 23) of a record -> the 23 planes that the C feature code takes."""
    raw = np.moveaxis(record, 2, 0).copy()
    raw[0:3] += raw[3:6]
    raw[6:9] **= 2
    return raw


def is_for_validation(path):
    """A scene is wholly in one of training and validation."""
    return zlib.crc32(path.name.rsplit("--", 1)[0].encode()) % 12 == 0


def complete(folder):
    """The views that have their reference, the last thing that is made of a view."""
    return [p for p in sorted(Path(folder).iterdir()) if (p / "ref.npy").exists() and len(list(p.glob("*.npy"))) > 1]


def views(folder):
    """Training and validation views."""
    train, validation = [], []
    for path in complete(folder):
        (validation if is_for_validation(path) else train).append(View(path))
    if not validation:
        validation = train[:: max(1, len(train) // 4)]
    return train, validation


def orthogonal(rng):
    if rng.random() < 0.5:
        return np.eye(3, dtype=np.float32)[rng.permutation(3)] * rng.choice([-1, 1], 3).astype(np.float32)
    return np.linalg.qr(rng.normal(size=(3, 3)))[0].astype(np.float32)


def fireflies(rng, record):
    """A few pixels of 10 to 1e5 times their value, each by one lucky sample: standard error about the value itself."""
    height, width, _ = record.shape
    for _ in range(rng.integers(1, 12)):
        y, x = rng.integers(height), rng.integers(width)
        value = (record[y, x, 0:3] + 0.5 * record[..., 0:3].mean((0, 1))) * 10 ** rng.uniform(1, 5)
        record[y, x, 0:3] = value
        record[y, x, 6:9] = value * rng.uniform(0.7, 1.0)


def paint(rng, height, width):
    """(H, W, 3) factors of 0.1 to 1: a tint, tiles, stripes, clouds or grains between two colours."""
    y, x = np.mgrid[0:height, 0:width].astype(np.float32)
    kind, period = rng.integers(5), 2 ** rng.uniform(0.5, 5)
    if kind == 0:
        mix = np.zeros((height, width), np.float32)
    elif kind == 1:
        mix = np.floor(y / period + rng.random()) + np.floor(x / period + rng.random())
        mix = mix % 2
    elif kind == 2:
        angle = rng.uniform(0, np.pi)
        mix = np.floor((x * np.cos(angle) + y * np.sin(angle)) / period + rng.random()) % 2
    elif kind == 3:
        waves = rng.normal(size=(6, 2)) / period
        mix = 0.5 + 0.5 * sum(np.sin(x * a + y * b + p) for (a, b), p in zip(waves, rng.uniform(0, 6.3, 6))) / 6
    else:
        mix = rng.random((height, width))
    one, two = 0.1 + 0.9 * rng.random((2, 3))
    return (one + mix[..., None] * (two - one)).astype(np.float32)


def repaint(rng, record, ref):
    """Other materials under the same light: what is reflected, its noise and both albedos times the same factors, scaled
    so that no albedo exceeds 1; emission and the guide's irradiance stay. (Light between surfaces keeps its colour.)"""
    factors = paint(rng, *ref.shape[:2])
    brightest = np.maximum(record[..., 9:12], record[..., 20:23]).max()
    factors *= 2 ** rng.uniform(-1, 1) * 0.9
    factors /= max(1.0, float(factors.max() * brightest))
    for first in (0, 6, 9, 20):
        record[..., first:first + 3] *= factors
    ref[...] = record[..., 3:6] + factors * (ref - record[..., 3:6])


def crop(rng, view, size):
    """One augmented sample: features (16, S, S), irradiance, modulation, emission and reference (S, S, 3)."""
    i = int(rng.integers(len(view.noisy)))
    height, width, _ = view.ref.shape
    y, x = int(rng.integers(max(height - size, 0) + 1)), int(rng.integers(max(width - size, 0) + 1))
    record = floats(view.noisy[i][y:y + size, x:x + size])
    ref = floats(view.ref[y:y + size, x:x + size])

    layers = sum(bit for bit, chance in DROPOUT.items() if rng.random() >= chance)
    if rng.random() < COLOR_ALONE:
        layers = 0
    exposure, log2_depth = view.scale(i, layers)
    if rng.random() < 0.5:
        record, ref = record.transpose(1, 0, 2), ref.transpose(1, 0, 2)
    if rng.random() < 0.5:
        record, ref = record[::-1], ref[::-1]
    if rng.random() < 0.5:
        record, ref = record[:, ::-1], ref[:, ::-1]
    colors = rng.permutation(3)
    order = np.concatenate([colors, 3 + colors, 6 + colors, 9 + colors, np.arange(12, 16), 16 + colors, [19], 20 + colors])
    record, ref = record[..., order].copy(), ref[..., colors].copy()
    record[..., 12:15] = record[..., 12:15] @ orthogonal(rng)
    if rng.random() < RANDOM_ALBEDO:
        repaint(rng, record, ref)
    if rng.random() < 0.15:
        fireflies(rng, record)
    gain = view.gain * 2 ** rng.normal(0, 1.2)
    record[..., 0:9] *= gain
    record[..., 16:19] *= gain
    ref *= gain
    # Features see radiance times exposure alone: a picture's own exposure cancels exactly, over 2^+-8 and more. What is left
    # to learn is an exposure that was measured wrong.
    off = rng.uniform(-8, 8) if rng.random() < EXPOSURE_OFF else rng.normal(0, 0.4)
    return prepare(record, ref, layers, exposure / gain * 2 ** off, log2_depth + rng.normal(0, 0.5))


def prepare(record, ref, layers, exposure, log2_depth):
    f, e = ops.features(raw_layers(record, layers), layers, exposure, log2_depth)
    modulation = np.maximum(record[..., 9:12], ops.ALBEDO_MIN) if layers & ops.ALBEDO else np.ones_like(ref)
    emission = record[..., 3:6] if layers & ops.EMISSION else np.zeros_like(ref)
    return f, e, modulation.copy(), emission.copy(), ref


def whole(view, i, size=None, layers=ALL_LAYERS):
    """A view without augmentation and with these layers, cut to multiples of 16 (and to size x size in its middle)."""
    height, width, _ = view.ref.shape
    h, w = (min(height, size or height) // 16 * 16, min(width, size or width) // 16 * 16)
    y, x = (height - h) // 2, (width - w) // 2
    record = floats(view.noisy[i][y:y + h, x:x + w])
    ref = floats(view.ref[y:y + h, x:x + w])
    return prepare(record, ref, layers, *view.scale(i, layers))


def collate(samples):
    return [torch.from_numpy(np.stack(parts)) for parts in zip(*samples)]


class Loader:
    """Batches made by a background thread, also of views that are added to the folder meanwhile."""

    def __init__(self, folder, train, batch, size, seed):
        self.queue = queue.Queue(4)
        self.failure = None
        arguments = folder, list(train), batch, size, np.random.default_rng(seed)
        threading.Thread(target=self.work, args=arguments, daemon=True).start()

    def work(self, folder, train, batch, size, rng):
        known, count = {view.path for view in train}, 0
        try:
            while True:
                count += 1
                if count % RESCAN == 0:
                    new = [p for p in complete(folder) if p not in known and not is_for_validation(p)]
                    known.update(new)
                    train += [View(p) for p in new]
                self.queue.put(collate([crop(rng, train[rng.integers(len(train))], size) for _ in range(batch)]))
        except Exception as failure:
            self.failure = failure
            self.queue.put(None)

    def next(self):
        batch = self.queue.get()
        if batch is None:
            raise self.failure
        return batch
