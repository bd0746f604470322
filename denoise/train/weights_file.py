# SPDX-License-Identifier: Apache-2.0
"""Writes weights files as denoise/nn/nn.h describes them; for this denoiser's training and the guide's."""
import json
import os
import struct
import zlib
from pathlib import Path

import numpy as np


def container(tensors, info):
    """The bytes of a weights file. tensors: name -> array with four dimensions, stored as halves; info: a JSON object."""
    text = json.dumps(info, indent=1).encode()
    body = struct.pack("<I", len(text)) + text + struct.pack("<I", len(tensors))
    for name, value in tensors.items():
        body += name.encode().ljust(48, b"\0") + struct.pack("<4i", *value.shape)
        body += np.ascontiguousarray(value, "<f2").tobytes()
    return b"FEWRAYNN" + struct.pack("<II", 1, zlib.crc32(body)) + body


def write_whole(path, data):
    """Writes beside, then renames: the file appears whole or not at all."""
    Path(path).resolve().parent.mkdir(parents=True, exist_ok=True)
    Path(str(path) + ".part").write_bytes(data)
    os.replace(str(path) + ".part", path)
