# SPDX-License-Identifier: Apache-2.0
"""Pictures of many planes, as EXR files hold them."""

import ctypes as C
from typing import Any, Dict, Iterator, Mapping, Optional, Union

import numpy as np

from . import _library as L
from . import _structs as S
from ._arrays import Array, as_floats, view

_LAYERS = {"color": ("R", "G", "B"), "normal": ("normal.X", "normal.Y", "normal.Z"), "depth": ("depth.Z",),
           "confidence": ("irradiance.confidence",)}


def _channels(layer: str) -> "tuple[str, ...]":
    return _LAYERS.get(layer) or tuple(f"{layer}.{c}" for c in "RGB")


class Frame(Mapping[str, Array]):
    """The planes of a picture by their channel names ("R", "albedo.G", "depth.Z"): arrays (height, width) of float32 that are
    the library's own memory, so that changing them changes the frame. Radiance is linear RGB."""

    def __init__(self, width: int, height: int) -> None:
        """A frame without planes; sizes in pixels."""
        pointer = C.c_void_p()
        L.run(lambda error: L.function("fewray_frame_create")(C.c_int(width), C.c_int(height), C.byref(pointer), C.byref(error)))
        self._pointer = pointer
        self.stats: Dict[str, Any] = {}
        """What `fewray render --stats` writes, where the frame was rendered: seconds and counts."""

    @classmethod
    def _of(cls, pointer: C.c_void_p) -> "Frame":
        frame = cls.__new__(cls)
        frame._pointer = pointer
        frame.stats = {}
        return frame

    def __del__(self) -> None:
        if getattr(self, "_pointer", None):
            L.function("fewray_frame_destroy")(C.byref(self._pointer))

    @property
    def _frame(self) -> Any:
        return C.cast(self._pointer, C.POINTER(S.fewray_frame)).contents

    @property
    def width(self) -> int:
        """Pixels."""
        return int(self._frame.width)

    @property
    def height(self) -> int:
        """Pixels."""
        return int(self._frame.height)

    @property
    def spp(self) -> int:
        """Samples a pixel, where the file's header tells; else 0."""
        return int(self._frame.spp)

    def _planes(self) -> Any:
        return C.cast(self._frame.planes, C.POINTER(S.fewray_plane * self._frame.plane_count)).contents

    def __iter__(self) -> Iterator[str]:
        return iter([plane.name.decode() for plane in self._planes()] if len(self) else [])

    def __len__(self) -> int:
        return int(self._frame.plane_count)

    def __getitem__(self, name: str) -> Array:
        for plane in self._planes() if len(self) else []:
            if plane.name.decode() == name and plane.data:
                return view(plane.data, (self.height, self.width), self)
        raise KeyError(name)

    def add(self, name: str) -> Array:
        """The plane of that name, (height, width); zeros where it wasn't there."""
        if not L.function("fewray_frame_add")(self._pointer, name.encode()):
            raise L.Error(f"the plane {name!r} can't be added", -5)
        return self[name]

    def layer(self, name: str) -> Optional[Array]:
        """A copy of a layer, (height, width, 3): "color", "noisy", "albedo", "normal", "variance", "emission", ...; "depth" and
        "confidence" are (height, width); None where the frame lacks it."""
        names = _channels(name)
        if any(n not in self for n in names):
            return None
        return np.stack([self[n] for n in names], axis=2) if len(names) > 1 else self[names[0]].copy()

    def set_layer(self, name: str, values: Any) -> None:
        """Copies (height, width, 3), of depth and confidence (height, width), into a layer, which is added where it is
        missing."""
        floats, names = as_floats(values, name), _channels(name)
        wanted = (self.height, self.width, 3)[:3 if len(names) > 1 else 2]
        if floats.shape != wanted:
            raise ValueError(f"{name} has the shape {floats.shape}, not {wanted}")
        for c, channel in enumerate(names):
            self.add(channel)[:] = floats[:, :, c] if len(names) > 1 else floats

    @property
    def color(self) -> Array:
        """A copy of the picture, (height, width, 3), linear RGB."""
        color = self.layer("color")
        if color is None:
            raise KeyError("R, G, B")
        return color

    @property
    def albedo(self) -> Optional[Array]:
        """A copy, (height, width, 3), 0..1; None where the frame lacks it."""
        return self.layer("albedo")

    @property
    def normal(self) -> Optional[Array]:
        """A copy, (height, width, 3), world space; None where the frame lacks it."""
        return self.layer("normal")

    @property
    def depth(self) -> Optional[Array]:
        """(height, width), scene units, 0: nothing was hit; no copy."""
        return self["depth.Z"] if "depth.Z" in self else None


def read(path: L.PathLike, *, adopt: bool = True, noisy: bool = False) -> Frame:
    """All planes of an EXR file. adopt: layers of Blender, Mitsuba 3, pbrt-v4, Arnold, RenderMan, V-Ray and Karma get fewray's
    names, as `fewray info` tells, so that Frame.color, .albedo, ... find them; noisy: of a picture that its renderer denoised and
    kept beside it, the noisy one is the colour."""
    pointer = C.c_void_p()
    L.run(lambda error: L.function("fewray_frame_read_exr")(L.path_bytes(path), C.byref(pointer), C.byref(error)))
    if adopt:
        L.function("fewray_frame_adopt_names")(pointer, C.c_bool(noisy))
    return Frame._of(pointer)


def write(path: L.PathLike, frame: Union[Frame, Mapping[str, Any]], float32: bool = False) -> None:
    """Writes an EXR file, whole or not at all: a frame, or layers by name as Frame.set_layer() takes them, of which "color" is
    the picture. Half floats, unless float32 is set."""
    if not isinstance(frame, Frame):
        first = np.shape(next(iter(frame.values()), None))
        if len(first) < 2:
            raise ValueError("there is no layer (height, width, 3) to write")
        made = Frame(first[1], first[0])
        for name, values in frame.items():
            made.set_layer(name, values)
        frame = made
    pointer = frame._pointer
    L.run(lambda error: L.function("fewray_frame_write_exr")(pointer, L.path_bytes(path), C.c_bool(float32), C.byref(error)))
