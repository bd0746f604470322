# SPDX-License-Identifier: Apache-2.0
"""numpy arrays as C sees them."""

import ctypes as C
from typing import Any, List, Tuple

import numpy as np
import numpy.typing as npt

from . import _structs as S

Array = npt.NDArray[np.float32]


def as_floats(array: Any, name: str) -> "npt.NDArray[Any]":
    """The array itself where it is float32 (aligned, any strides of whole floats), else a converted copy."""
    given = np.asarray(array)
    if given.dtype.kind not in "fiu":
        raise TypeError(f"{name} holds {given.dtype}, not numbers")
    floats = np.asarray(given, dtype=np.float32)
    return floats if floats.flags.aligned and not any(s % 4 for s in floats.strides) else floats.copy()


def channels(array: Any, name: str, size: Tuple[int, int], components: int, keep: List[Any]) -> Any:
    """struct fewray_channels of an array (height, width, components), without a copy; of None: a missing layer. What must
    live as long is added to keep."""
    out = S.fewray_channels()
    if array is None:
        return out
    floats = as_floats(array, name)
    if components == 1 and floats.ndim == 2:
        floats = floats[:, :, None]
    wanted = size + (components,)
    if floats.shape != wanted:
        raise ValueError(f"{name} has the shape {floats.shape}, not {wanted}")
    keep.append(floats)
    row, pixel, component = (s // 4 for s in floats.strides)
    for c in range(components):
        out.channel[c] = floats.ctypes.data + 4 * c * component
    out.pixel_stride, out.row_stride = pixel, row
    return out


def size_of(array: Any, name: str) -> Tuple[int, int]:
    shape = np.shape(array)
    if len(shape) != 3 or shape[2] != 3:
        raise ValueError(f"{name} has the shape {shape}, not (height, width, 3)")
    return shape[0], shape[1]


def packed(array: Any, name: str, shape: Tuple[int, ...], keep: List[Any], dtype: Any = np.float32) -> int:
    """The address of an array without gaps, which is a copy only where it has some or is of another type."""
    if array is None:
        raise ValueError(f"{name} is missing")
    values = np.require(array, dtype, ["C", "A"])
    if values.shape != shape:
        raise ValueError(f"{name} has the shape {values.shape}, not {shape}")
    keep.append(values)
    return int(values.ctypes.data)


def view(address: int, shape: Tuple[int, ...], owner: Any) -> Array:
    """An array of memory that `owner` keeps alive."""
    count = int(np.prod(shape))
    memory = (C.c_float * count).from_address(address)
    memory._owner = owner
    return np.frombuffer(memory, dtype=np.float32).reshape(shape)
