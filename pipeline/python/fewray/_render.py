# SPDX-License-Identifier: Apache-2.0
"""The renderer: a scene file in, a frame out."""

import ctypes as C
import json
import os
import tempfile
from typing import Any, List, Mapping, Optional, Union

from . import _library as L
from . import _structs as S
from ._frame import Frame

_MODELS = ("default", "fast")
_GUIDES = ("odis", "paper", "ppg", "off")


class _Progress:
    """fewray_job.progress, which gets a struct."""

    def __init__(self, progress: Optional[L.Progress], cancel: C.c_int) -> None:
        self.inner = L.Callback(progress, cancel, True)
        kind = C.CFUNCTYPE(None, C.c_void_p, C.POINTER(S.fewray_progress))
        self.function = kind(lambda _, now: self.inner.function(None, now.contents.phase, now.contents.fraction))
        self.address = C.cast(self.function, C.c_void_p) if progress else None


def render(scene: L.PathLike, spp: int = 4, *, guide: Union[bool, str] = True, denoise: bool = True,
           width: int = 0, height: int = 0, max_depth: int = 0, seed: int = 0, threads: int = 0, initial: int = 1,
           seconds: float = 0, error: float = 0, max_spp: int = 0, adaptive: bool = False, model: str = "default",
           aovs: bool = False, defines: Optional[Mapping[str, Any]] = None, lenient: bool = False, pilot: bool = True,
           guide_weights: Optional[L.PathLike] = None, denoise_weights: Optional[L.PathLike] = None,
           progress: Optional[L.Progress] = None) -> Frame:
    """Renders a scene (Mitsuba 3 XML, glTF, OBJ) as `fewray render` does, whose manual page tells of all these.

    spp: samples a pixel, the first look of `initial` included. guide: True or "odis", "paper", "ppg", False or "off". width,
    height: pixels, 0: the scene's own. seconds: of wall time for the whole run, instead of spp; error: mrse to reach, at most
    with max_spp samples a pixel; adaptive: tiles get samples by their expected error. aovs: layers direct.* and indirect.* as
    well. defines: values of $name in the XML. progress: called with the phase and the share of the whole run, 0..1, from
    another thread. Frame.stats holds seconds and counts. Ctrl-C raises KeyboardInterrupt.
    """
    chosen = {True: "odis", False: "off"}.get(guide, guide) if isinstance(guide, bool) else guide
    if chosen not in _GUIDES:
        raise ValueError(f"there is no guide {guide!r}; {', '.join(_GUIDES)} are there")
    if model not in _MODELS:
        raise ValueError(f"there is no model {model!r}; {' and '.join(_MODELS)} are there")
    job, cancel = S.fewray_job(), C.c_int(0)
    L.function("fewray_job_init")(C.byref(job))
    if chosen == "paper":
        L.function("fewray_render_settings_paper")(C.byref(job.settings))
    job.scene_path = L.path_bytes(scene)
    job.guided, job.denoised, job.ppg, job.pilot = chosen != "off", denoise, chosen == "ppg", pilot and chosen != "paper"
    settings: Any = job.settings
    L.set_integers(settings, spp=spp, initial=initial, seed=seed, threads=threads, width=width, height=height)
    if max_depth:
        L.set_integers(settings, max_depth=max_depth)
    settings.direct = settings.indirect = aovs
    settings.weights_path = L.optional_path(guide_weights)
    settings.cancel = C.addressof(cancel)
    goal: Any = job.goal
    L.set_integers(goal, max_spp=max_spp)
    goal.seconds, goal.error = seconds, error
    goal.adaptive, goal.any_model = bool(adaptive or seconds or error), bool(seconds)
    job.denoise.model = _MODELS.index(model)
    job.denoise.weights_path = L.optional_path(denoise_weights)
    pairs: List[bytes] = [f"{name}={value}".encode() for name, value in (defines or {}).items()]
    array = (C.c_char_p * max(len(pairs), 1))(*pairs)
    job.scene.defines, job.scene.define_count, job.scene.lenient = C.addressof(array), len(pairs), lenient
    told = _Progress(progress, cancel)
    job.progress = told.address
    job.memory = array, cancel, told  # live as long as `job`, which the work holds on to
    pointer = C.c_void_p()
    with tempfile.TemporaryDirectory(prefix="fewray-") as folder:
        stats = os.path.join(folder, "stats.json")
        job.outputs.stats = os.fsencode(stats)
        try:
            L.run(lambda failure: L.function("fewray_job_run")(C.byref(job), C.byref(pointer), None, C.byref(failure)), cancel)
            frame = Frame._of(pointer)
            pointer = C.c_void_p()
            with open(stats, encoding="utf-8") as file:
                frame.stats = json.load(file)
        finally:
            if pointer:
                L.function("fewray_frame_destroy")(C.byref(pointer))
            told.inner.finish()
    return frame
