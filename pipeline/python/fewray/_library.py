# SPDX-License-Identifier: Apache-2.0
"""The shared library, its errors, and calls that Ctrl-C ends."""

import ctypes as C
import os
import threading
from pathlib import Path
from typing import Any, Callable, List, Optional

from . import _structs as S

_PATH = os.environ.get("FEWRAY_LIBRARY") or str(Path(__file__).resolve().parent / "lib" / "libfewray.so")
_library = C.CDLL(_PATH)
_library.fewray_version.restype = C.c_char_p
_library.fewray_frame_add.restype = C.c_void_p
_library.fewray_frame_repair.restype = C.c_size_t
_library.fewray_error_text.restype = C.c_char_p

Progress = Callable[[str, float], None]


class Error(RuntimeError):
    """What fewray says went wrong, in one line. `status` is one of the values of enum fewray_status in fewray/features.h
    (-1: a file can't be read or written, -2 damaged, -3 not supported, -4 no memory, -5 wrong argument)."""

    def __init__(self, text: str, status: int) -> None:
        super().__init__(text)
        self.status = status


CANCELLED = -6


def version() -> str:
    return _library.fewray_version().decode()


def function(name: str) -> Any:
    return getattr(_library, name)


def check(status: int, error: Any) -> None:
    if status == CANCELLED:
        raise KeyboardInterrupt
    if status:
        text = C.create_string_buffer(2048)
        _library.fewray_error_text(C.byref(error), text, C.c_size_t(len(text)))
        raise Error(text.value.decode(errors="replace"), status)


def run(work: Callable[[Any], int], cancel: Optional[C.c_int] = None) -> None:
    """Calls work(error), a function of the library that may take long, without Python's lock. In the main thread Ctrl-C sets
    `cancel`, which ends it; it is KeyboardInterrupt then."""
    error = S.fewray_error()
    if cancel is None or threading.current_thread() is not threading.main_thread():
        check(work(error), error)
        return
    status: List[int] = []
    failed: List[BaseException] = []

    def target() -> None:
        try:
            status.append(work(error))
        except BaseException as exception:  # such as an interrupt in a callback
            failed.append(exception)

    worker = threading.Thread(target=target, name="fewray")
    worker.start()
    interrupted = False
    while worker.is_alive():
        try:
            worker.join(0.1)
        except KeyboardInterrupt:
            interrupted = True
            cancel.value = 1
    if failed:
        raise failed[0]
    if interrupted:
        raise KeyboardInterrupt
    check(status[0], error)


class Callback:
    """A progress function for C. The first exception in it cancels the work and is raised afterwards."""

    def __init__(self, progress: Optional[Progress], cancel: C.c_int, with_phase: bool, phase: str = "") -> None:
        self.failed: Optional[BaseException] = None

        def tell(name: str, fraction: float) -> None:
            try:
                if progress and self.failed is None:
                    progress(name, fraction)
            except BaseException as exception:
                self.failed = exception
                cancel.value = 1

        if with_phase:
            kind = C.CFUNCTYPE(None, C.c_void_p, C.c_char_p, C.c_double)
            self.function = kind(lambda _, name, fraction: tell((name or b"").decode(), fraction))
        else:
            kind = C.CFUNCTYPE(None, C.c_void_p, C.c_double)
            self.function = kind(lambda _, fraction: tell(phase, fraction))
        self.address = C.cast(self.function, C.c_void_p) if progress else None

    def finish(self) -> None:
        if self.failed is not None:
            raise self.failed
