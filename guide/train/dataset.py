# SPDX-License-Identifier: Apache-2.0
"""Records of fewray-odis-data: split by scene, streamed from disk in shuffled chunks, turned and
mirrored about the vertical."""
import itertools
import math
import os
import queue
import threading

import numpy as np
import torch

from model import COLUMNS, COSINE, INPUTS, PLANE_NAMES, ROWS

VERSION = 2
HEADER_BYTES = 16  # "ODISDATA", uint32 version, uint32 bytes a record
RECORD = np.dtype([("scene", "<u4"), ("x", "<u4"), ("y", "<u4"), ("samples", "<u4"),
                   ("window", "<u4"), ("target_scale", "<f4"),
                   ("input", "<f2", (INPUTS, ROWS, COLUMNS)),   # 12 planes, mask, cosine, fill
                   # mean radiance, root second moment; times target_scale
                   ("target", "<f2", (2, ROWS, COLUMNS))])
NORMALS = ("normal", "second_normal")  # x, y and z planes each
CHUNK = 16      # records read at once: half a megabyte
POOL = 4096     # records that are shuffled together: 140 MB
AHEAD = 4       # batches that the reading thread has ready


def header(record_bytes=RECORD.itemsize):
    return b"ODISDATA" + np.array([VERSION, record_bytes], "<u4").tobytes()


def open_records(path):
    with open(path, "rb") as file:
        if file.read(HEADER_BYTES) != header():
            raise SystemExit(f"{path}: not a version {VERSION} file of fewray-odis-data")
    size = os.path.getsize(path)
    return np.memmap(path, RECORD, "r", HEADER_BYTES, ((size - HEADER_BYTES) // RECORD.itemsize,))


def scene_runs(records):
    """[(scene, begin, end)] of records in ascending order of scenes, found by bisection so that a
    file of any size is barely touched."""
    scene, runs, begin = records["scene"], [], 0
    while begin < len(records):
        number, step = scene[begin], 1
        low, high = begin, begin + 1  # scene[low] is number, scene[high] isn't or is the end
        while high < len(records) and scene[high] == number:
            low, step = high, 2 * step
            high = min(high + step, len(records))
        while high - low > 1:
            middle = (low + high) // 2
            low, high = (middle, high) if scene[middle] == number else (low, middle)
        runs.append((int(number), begin, high))
        begin = high
    return runs


def is_usable(records):
    """Finite, and lit somewhere above the horizon. (N)"""
    finite = np.isfinite(records["target_scale"])
    for field in ("input", "target"):
        finite &= np.isfinite(records[field]).all((1, 2, 3))
    lit = (records["target"][:, 1] > 0) & (records["input"][:, COSINE] > 0)
    return finite & lit.any((1, 2))


def tensors(records):
    """(N, 15, 32, 32) inputs and (N, 2, 32, 32) targets as floats."""
    inputs = torch.from_numpy(np.ascontiguousarray(records["input"])).float()
    targets = torch.from_numpy(np.ascontiguousarray(records["target"])).float()
    scale = torch.from_numpy(np.ascontiguousarray(records["target_scale"]))
    return inputs, targets * scale[:, None, None, None]


class Held:
    """Records in memory, evenly spread over their runs: for validation."""

    def __init__(self, files, runs, limit):
        places = [(f, i) for f, begin, end in runs for i in range(begin, end)]
        places = places[::max(1, math.ceil(len(places) / limit))]
        self.records = np.zeros(len(places), RECORD)
        for slot, (f, i) in enumerate(places):
            self.records[slot] = files[f][i]
        self.records = self.records[is_usable(self.records)]

    def __len__(self):
        return len(self.records)

    def batches(self, size):
        for at in range(0, len(self), size):
            yield tensors(self.records[at:at + size])


class Stream:
    """Endless shuffled batches. A thread reads chunks in random order and swaps each for as many
    random records of a pool; what leaves the pool makes the batches."""

    def __init__(self, paths, runs, batch, seed):
        self.paths, self.batch, self.rng = paths, batch, np.random.default_rng(seed)
        self.chunks = np.array([(f, at, min(at + CHUNK, end)) for f, begin, end in runs
                                for at in range(begin, end, CHUNK)], np.int64).reshape(-1, 3)
        self.count = sum(end - begin for _, begin, end in runs)
        self.ready = queue.Queue(AHEAD)

    def __len__(self):
        return self.count

    def start(self):
        threading.Thread(target=self._run, daemon=True).start()

    def next(self):
        got = self.ready.get()
        if isinstance(got, BaseException):
            raise got
        return got

    def _run(self):
        try:
            chunks, batch = self._chunks(), []
            pool = np.concatenate(list(itertools.islice(chunks, POOL // CHUNK)))
            for fresh in chunks:
                slots = self.rng.choice(len(pool), len(fresh), replace=False)
                batch.append(pool[slots])
                pool[slots] = fresh
                if sum(map(len, batch)) >= self.batch:
                    records = np.concatenate(batch)
                    batch = [records[self.batch:]]
                    records = records[:self.batch]
                    self.ready.put(tensors(records[is_usable(records)]))
        except BaseException as error:  # handed to the training, which would wait for ever
            self.ready.put(error)

    def _chunks(self):
        handles = [os.open(p, os.O_RDONLY) for p in self.paths]
        while True:
            for f, begin, end in self.rng.permutation(self.chunks):
                records = np.empty(end - begin, RECORD)
                at = HEADER_BYTES + int(begin) * RECORD.itemsize
                if os.preadv(handles[f], [records.view(np.uint8)], at) != records.nbytes:
                    raise OSError(f"{self.paths[f]}: cut short while reading")
                yield records


def load(paths, validation_paths, batch, seed, share=10, limit=4096):
    """(training Stream, validation Held). Without validation files every share-th scene number
    validates, in all files alike, so that files of the same scenes never mix."""
    names = list(paths) + list(validation_paths)
    files = [open_records(p) for p in names]
    training, validation = [], []
    for f, records in enumerate(files):
        for scene, begin, end in scene_runs(records):
            held = f >= len(paths) if validation_paths else scene % share == share - 1
            (validation if held else training).append((f, begin, end))
    return Stream(names, training, batch, seed), Held(files, validation, limit)


def augment(inputs, targets, generator):
    """Turns each map about the vertical by whole columns and mirrors half of them, with their
    normals."""
    n = len(inputs)
    turn = torch.randint(COLUMNS, (n, 1), generator=generator)
    mirror = torch.randint(2, (n, 1), generator=generator)
    column = (torch.arange(COLUMNS)[None] - turn) % COLUMNS
    column = torch.where(mirror > 0, COLUMNS - 1 - column, column)[:, None, None]
    inputs = inputs.gather(3, column.expand(-1, INPUTS, ROWS, -1))
    targets = targets.gather(3, column.expand(-1, 2, ROWS, -1))
    angle = turn.float() * (2 * math.pi / COLUMNS)
    c, s = torch.cos(angle)[..., None], torch.sin(angle)[..., None]
    sign = (1 - 2.0 * mirror)[..., None]
    for name in NORMALS:
        x, _, z = PLANE_NAMES[name]
        nx, nz = inputs[:, x] * sign, inputs[:, z]
        inputs[:, x], inputs[:, z] = nx * c + nz * s, nz * c - nx * s
    return inputs, targets


def drop_planes(inputs, names):
    """Zeroes the named input planes in place (the ablations)."""
    for name in names:
        inputs[:, list(PLANE_NAMES[name])] = 0
    return inputs
