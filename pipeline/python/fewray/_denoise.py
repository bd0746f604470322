# SPDX-License-Identifier: Apache-2.0
"""The denoiser."""

import ctypes as C
import threading
from typing import Any, Callable, Dict, List, Mapping, Optional, Sequence

import numpy as np

from . import _library as L
from . import _structs as S
from ._arrays import Array, channels, size_of
from ._frame import Frame

_MODELS = ("default", "fast")


class Denoiser:
    """Keeps the network for many pictures. Threads that share it take turns.

    model: "default" or "fast" (half the time, less exact); weights: another network's file; threads: 0 = all cores that the
    picture has work for; max_memory: bytes for the network's buffers (0: 256 MiB); progress: called with "denoise" and the
    share done, 0..1.
    """

    def __init__(self, model: str = "default", *, weights: Optional[L.PathLike] = None, threads: int = 0,
                 max_memory: int = 0, progress: Optional[L.Progress] = None) -> None:
        if model not in _MODELS:
            raise ValueError(f"there is no model {model!r}; {' and '.join(_MODELS)} are there")
        self._lock = threading.Lock()
        self._cancel = C.c_int(0)
        self._callback = L.Callback(progress, self._cancel, False, "denoise")
        options = S.fewray_denoise_options()
        L.function("fewray_denoise_options_init")(C.byref(options))
        L.set_integers(options, model=_MODELS.index(model), threads=threads, max_memory=max_memory)
        options.weights_path = L.optional_path(weights)
        options.progress, options.cancel = self._callback.address, C.addressof(self._cancel)
        self._options = options
        self._denoiser = C.c_void_p()
        L.run(lambda error: L.function("fewray_denoiser_create")(C.byref(options), C.byref(self._denoiser), C.byref(error)))

    def __del__(self) -> None:
        if getattr(self, "_denoiser", None):
            L.function("fewray_denoiser_destroy")(C.byref(self._denoiser))

    def __call__(self, color: Any, albedo: Any = None, normal: Any = None, depth: Any = None, variance: Any = None,
                 emission: Any = None, shaded_albedo: Any = None, irradiance: Any = None, confidence: Any = None, *,
                 layers: Optional[Mapping[str, Any]] = None, out: Optional[Array] = None) -> Any:
        """See fewray.denoise()."""
        size, keep = size_of(color, "color"), []  # type: ignore[var-annotated]
        given = S.fewray_denoise_input(width=size[1], height=size[0])
        for name, array, components in (
                ("color", color, 3), ("albedo", albedo, 3), ("normal", normal, 3), ("variance", variance, 3),
                ("emission", emission, 3), ("shaded_albedo", shaded_albedo, 3), ("irradiance", irradiance, 3),
                ("depth", depth, 1), ("confidence", confidence, 1)):
            setattr(given, name, channels(array, name, size, components, keep))
        others = self._add_layers(given, layers or {}, size, keep)
        result = np.empty(size + (3,), np.float32) if out is None else out
        if not isinstance(result, np.ndarray) or result.dtype != np.float32 or result.shape != size + (3,) or \
                not result.flags.c_contiguous or not result.flags.writeable:
            raise ValueError(f"out must be a writable float32 array {size + (3,)} without gaps")
        if any(np.may_share_memory(result, array) for array in keep):
            raise ValueError("out shares memory with the input")
        given.memory = keep, result, others  # live as long as `given`, which the work holds on to
        self._run(lambda error: L.function("fewray_denoiser_run")(
            self._denoiser, C.byref(given), C.c_void_p(result.ctypes.data), None, C.byref(error)))
        return (result, others) if layers is not None else result

    def _run(self, work: Callable[[Any], int]) -> None:
        with self._lock:
            self._cancel.value = 0
            try:
                L.run(work, self._cancel)
            finally:
                self._callback.finish()

    @staticmethod
    def _add_layers(given: Any, layers: Mapping[str, Any], size: "tuple[int, int]", keep: List[Any]) -> Dict[str, Array]:
        made = (S.fewray_denoise_layer * max(len(layers), 1))()
        out: Dict[str, Array] = {}
        for layer, (name, array) in zip(made, layers.items()):
            layer.__init__()  # type: ignore[misc]
            setattr(layer, "in", channels(array, name, size, 3, keep))
            layer.emission = 2  # FEWRAY_EMISSION_SHARED: nobody says where it is
            out[name] = np.empty(size + (3,), np.float32)
            for c in range(3):
                layer.out[c] = out[name].ctypes.data + 4 * c
            layer.out_pixel_stride, layer.out_row_stride = 3, 3 * size[1]
        given.layers, given.layer_count = C.addressof(made), len(layers)
        keep.append(np.frombuffer(made, np.uint8))  # lives as long as the arrays
        return out

    def frame(self, frame: Frame, layers: Sequence[str] = ()) -> None:
        """Denoises a frame in place, as `fewray denoise` does: R, G, B by the layers that it has, and the layers of these
        names by the same weights; what they were is kept as noisy.*."""
        names = (C.c_char_p * max(len(layers), 1))(*[name.encode() for name in layers])
        self._run(lambda error: L.function("fewray_denoise_frame_layers")(
            self._denoiser, frame._pointer, names, C.c_int(len(layers)), None, C.byref(error)))


def denoise(color: Any, albedo: Any = None, normal: Any = None, depth: Any = None, variance: Any = None, emission: Any = None,
            shaded_albedo: Any = None, irradiance: Any = None, confidence: Any = None, *,
            layers: Optional[Mapping[str, Any]] = None, out: Optional[Array] = None, model: str = "default",
            weights: Optional[L.PathLike] = None, threads: int = 0, progress: Optional[L.Progress] = None) -> Any:
    """Filters a noisy picture; returns (height, width, 3), or that and a dictionary where layers are given.

    color: (height, width, 3), radiance, linear RGB. All else may be missing: albedo (0..1), normal (world space), variance of
    the pixel's mean (radiance^2), emission of the first surfaces, shaded_albedo of the very samples that colour is made of,
    irradiance / pi by a guide: (height, width, 3); depth (scene units, 0: nothing) and confidence in the irradiance (0..1):
    (height, width). layers: name -> (height, width, 3), parts of colour that are filtered by the same weights, so that sums
    still hold. out: where the result goes. NaN, negative values and radiance beyond 1e12 count as in fewray/denoise.h.

    float32 arrays of any strides are read where they are; others are converted, which is a copy. For many pictures make a
    Denoiser.
    """
    made = Denoiser(model, weights=weights, threads=threads, progress=progress)
    return made(color, albedo, normal, depth, variance, emission, shaded_albedo, irradiance, confidence, layers=layers, out=out)
