# SPDX-License-Identifier: Apache-2.0
"""The guide alone, for other renderers."""

import ctypes as C
from typing import Any, Dict, List, Optional, Tuple

import numpy as np

from . import _library as L
from . import _structs as S
from ._arrays import Array, packed

_VECTORS = ("position", "normal", "direction", "direct", "emitted", "reflected", "second_normal", "second_light",
            "second_bounce")
_NUMBERS = ("depth", "light_pdf", "distance", "second_albedo", "second_light_value", "second_bounce_value")


def look_directions(normal: Any, seed: int = 0, threads: int = 0) -> Array:
    """First bounces for a look: uniform over the hemispheres of normal (height, width, samples, 3; unit, towards the viewer),
    and spread evenly among neighbouring pixels. The same shape; where a normal is 0 the direction is, too."""
    keep: List[Any] = []
    shape = np.shape(normal)
    if len(shape) != 4 or shape[3] != 3:
        raise ValueError(f"normal has the shape {shape}, not (height, width, samples, 3)")
    direction = np.empty(shape, np.float32)
    L.function("fewray_guide_look_directions")(
        C.c_uint64(seed), C.c_int(shape[1]), C.c_int(shape[0]), C.c_int(shape[2]), C.c_int(threads),
        C.c_void_p(packed(normal, "normal", shape, keep)), C.c_void_p(direction.ctypes.data))
    return direction


class Guide:
    """Sampling maps and probes of another renderer's first look: <fewray/guiding.h>, which says what the arrays hold and how to
    stay unbiased. The arrays aren't needed afterwards.

    depth, light_pdf, distance, second_albedo, second_light_value, second_bounce_value: (height, width, samples); position,
    normal, direction, direct, emitted, reflected, second_normal, second_light, second_bounce: (height, width, samples, 3).
    light_pdf and direct may be missing; the five second_* but second_normal too, all together.
    bsdf_fraction: 0..1, negative: the network decides; stats: records, dropped, maps, probes.
    """

    def __init__(self, *, threads: int = 0, bsdf_fraction: float = -1, map_bins: int = 32, share_maps: bool = True,
                 weights: Optional[L.PathLike] = None, **look: Any) -> None:
        unknown = set(look) - set(_VECTORS + _NUMBERS)
        if unknown or "depth" not in look:
            raise TypeError(f"unknown arrays: {', '.join(sorted(unknown))}" if unknown else "the look has no depth")
        shape = np.shape(look["depth"])
        if len(shape) != 3:
            raise ValueError(f"depth has the shape {shape}, not (height, width, samples)")
        self._size = shape[0], shape[1]
        keep: List[Any] = []
        given = S.fewray_guide_look(width=shape[1], height=shape[0], samples=shape[2])
        for name, array in look.items():
            if array is not None:
                setattr(given, name, packed(array, name, shape + ((3,) if name in _VECTORS else ()), keep))
        options, stats, cancel = S.fewray_guide_options(), S.fewray_guide_stats(), C.c_int(0)
        L.function("fewray_guide_options_init")(C.byref(options))
        L.set_integers(options, threads=threads, map_bins=map_bins)
        options.bsdf_fraction, options.share_maps = bsdf_fraction, share_maps
        options.weights_path, options.cancel = L.optional_path(weights), C.addressof(cancel)
        given.memory = keep, cancel  # live as long as `given`, which the work holds on to
        self._guide = C.c_void_p()
        L.run(lambda error: L.function("fewray_guide_create")(
            C.byref(given), C.byref(options), C.byref(self._guide), C.byref(stats), C.byref(error)), cancel)
        self.stats: Dict[str, int] = {name: int(getattr(stats, name)) for name, _ in S.fewray_guide_stats._fields_}

    def __del__(self) -> None:
        if getattr(self, "_guide", None):
            L.function("fewray_guide_destroy")(C.byref(self._guide))

    def _points(self, keep: List[Any], last: bool, **arrays: Any) -> Any:
        """struct fewray_guide_points of `normal`, which comes first, and of what else of pixel and position is given."""
        count = np.shape(arrays["normal"])[0] if np.ndim(arrays["normal"]) else 0
        points = S.fewray_guide_points(count=count, last=last)
        for name, array in arrays.items():
            pixel = name == "pixel"
            setattr(points, name, packed(array, name, (count, 2 if pixel else 3), keep, np.int32 if pixel else np.float32))
        return points

    def _sample(self, u: Any, last: bool, **arrays: Any) -> Tuple[Array, Array, Array]:
        keep: List[Any] = []
        points = self._points(keep, last, **arrays)
        count = int(points.count)
        direction, pdf, fraction = np.empty((count, 3), np.float32), np.empty(count, np.float32), np.empty(count, np.float32)
        L.function("fewray_guide_sample_many")(
            self._guide, C.byref(points), C.c_void_p(packed(u, "u", (count, 2), keep)), C.c_void_p(direction.ctypes.data),
            C.c_void_p(pdf.ctypes.data), C.c_void_p(fraction.ctypes.data))
        return direction, pdf, fraction

    def _pdf(self, direction: Any, last: bool, **arrays: Any) -> Tuple[Array, Array]:
        keep: List[Any] = []
        points = self._points(keep, last, **arrays)
        count = int(points.count)
        pdf, fraction = np.empty(count, np.float32), np.empty(count, np.float32)
        L.function("fewray_guide_pdf_many")(
            self._guide, C.byref(points), C.c_void_p(packed(direction, "direction", (count, 3), keep)),
            C.c_void_p(pdf.ctypes.data), C.c_void_p(fraction.ctypes.data))
        return pdf, fraction

    def first_sample(self, pixel: Any, position: Any, normal: Any, u: Any) -> Tuple[Array, Array, Array]:
        """Draws a direction at each first vertex. pixel: (N, 2) int32, x and y; position, normal (unit, towards the viewer):
        (N, 3); u: (N, 2) in [0, 1). Returns direction (N, 3), its density in solid angle (N) and the share of directions that
        the BSDF should draw (N); where that is 1 nothing guides and the others are 0."""
        return self._sample(u, False, normal=normal, pixel=pixel, position=position)

    def first_pdf(self, pixel: Any, position: Any, normal: Any, direction: Any) -> Tuple[Array, Array]:
        """Density (solid angle) of first_sample() for directions (N, 3), and the BSDF's share: (N) each."""
        return self._pdf(direction, False, normal=normal, pixel=pixel, position=position)

    def later_sample(self, position: Any, normal: Any, u: Any, last: bool = False) -> Tuple[Array, Array, Array]:
        """The same at later vertices. last: the bounce from here can only find lights, since the path ends then."""
        return self._sample(u, last, normal=normal, position=position)

    def later_pdf(self, position: Any, normal: Any, direction: Any, last: bool = False) -> Tuple[Array, Array]:
        """Density of later_sample()."""
        return self._pdf(direction, last, normal=normal, position=position)

    def look_weights(self, guided: int) -> Array:
        """Share (height, width) of the look in each pixel's mean beside so many guided samples: share * (mean of the look's) +
        (1 - share) * (mean of the others)."""
        share = np.empty(self._size, np.float32)
        L.function("fewray_guide_look_weights")(self._guide, C.c_int(guided), C.c_void_p(share.ctypes.data))
        return share

    def irradiance(self, pixel: Any, normal: Any) -> Tuple[Array, Array]:
        """Irradiance / pi (N, 3), nearly free of noise, and the confidence in it (N), 0..1: for fewray.denoise()."""
        keep: List[Any] = []
        points = self._points(keep, False, normal=normal, pixel=pixel)
        count = int(points.count)
        irradiance, confidence = np.empty((count, 3), np.float32), np.empty(count, np.float32)
        L.function("fewray_guide_irradiance_many")(
            self._guide, C.byref(points), C.c_void_p(irradiance.ctypes.data), C.c_void_p(confidence.ctypes.data))
        return irradiance, confidence
