# SPDX-License-Identifier: Apache-2.0
"""Rows of numbers as JSON, short enough to keep."""
import json

import numpy as np


def text(number):
    return float(f"{number:.6g}")


def row(*parts):
    return [text(x) for part in parts for x in np.atleast_1d(np.array(part, float))]


def unit(v):
    return np.array(v, float) / np.linalg.norm(v)


def write(path, table):
    """One row of numbers a line."""
    rows = json.dumps(table, separators=(",", ":"))
    with open(path, "w", encoding="ascii") as file:
        file.write(rows.replace('{"name"', '\n{"name"').replace("],[", "],\n[") + "\n")
