#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""IN.gltf OUT.glb: the same scene as one binary file. Its first buffer must be a data URI."""
import base64
import json
import struct
import sys

scene = json.load(open(sys.argv[1]))
data = base64.b64decode(scene["buffers"][0].pop("uri").split(",", 1)[1])
data += b"\0" * (-len(data) % 4)
text = json.dumps(scene).encode()
text += b" " * (-len(text) % 4)
with open(sys.argv[2], "wb") as file:
    file.write(struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(data)))
    file.write(struct.pack("<I4s", len(text), b"JSON") + text)
    file.write(struct.pack("<I4s", len(data), b"BIN\0") + data)
