# SPDX-License-Identifier: Apache-2.0
"""Records of fewray-odis-data: read through memory maps, split by scene, turned and mirrored about
the vertical."""
import math

import numpy as np
import torch

from model import COLUMNS, COSINE, INPUTS, ROWS

HEADER_BYTES = 16  # "ODISDATA", uint32 version, uint32 bytes a record
RECORD = np.dtype([("scene", "<u4"), ("x", "<u4"), ("y", "<u4"), ("samples", "<u4"),
                   ("input", "<f2", (INPUTS, ROWS, COLUMNS)),   # 10 planes, mask, cosine, fill
                   ("target", "<f4", (2, ROWS, COLUMNS))])      # mean radiance, root second moment
NORMALS = ((2, 4), (6, 8))  # x and z planes of the first and second hit's normal


def open_records(path):
    with open(path, "rb") as file:
        magic, header = file.read(8), np.frombuffer(file.read(8), "<u4")
    if magic != b"ODISDATA" or len(header) != 2 or tuple(header) != (1, RECORD.itemsize):
        raise SystemExit(f"{path}: not a version 1 file of fewray-odis-data")
    size = np.memmap(path, mode="r").size
    return np.memmap(path, RECORD, "r", HEADER_BYTES, ((size - HEADER_BYTES) // RECORD.itemsize,))


class Records:
    """Some records of several files, by (file, index)."""

    def __init__(self, files, places):
        self.files, self.places = files, places

    def __len__(self):
        return len(self.places)

    def batch(self, order):
        rows = [self.files[f][i] for f, i in self.places[order]]
        inputs = torch.from_numpy(np.stack([r["input"] for r in rows]).astype(np.float32))
        targets = torch.from_numpy(np.stack([r["target"] for r in rows]))
        return inputs, targets


def is_lit(record):
    finite = np.isfinite(record["target"]).all() and np.isfinite(record["input"]).all()
    return finite and (record["target"][1] * record["input"][COSINE] > 0).any()


def load(paths, validation_paths=(), share=10):
    """(training, validation) records. Without validation files every share-th scene number
    validates, in all files alike, so that files of the same scenes never mix."""
    files = [open_records(p) for p in list(paths) + list(validation_paths)]
    training, validation = [], []
    for f, records in enumerate(files):
        scenes = np.asarray(records["scene"])
        # A truth without any light teaches nothing: the map falls back to the BSDF there.
        lit = np.array([is_lit(r) for r in records], bool)
        if validation_paths:
            held_out = np.full(len(scenes), f >= len(paths))
        else:
            held_out = scenes % share == share - 1
        for chosen, places in ((held_out, validation), (~held_out, training)):
            index = np.flatnonzero(chosen & lit)
            places.append(np.stack([np.full_like(index, f), index], 1))
    return Records(files, np.concatenate(training)), Records(files, np.concatenate(validation))


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
    for x, z in NORMALS:
        nx, nz = inputs[:, x] * sign, inputs[:, z]
        inputs[:, x], inputs[:, z] = nx * c + nz * s, nz * c - nx * s
    return inputs, targets
