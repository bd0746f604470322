# SPDX-License-Identifier: Apache-2.0
"""The shared library, its errors, and calls that Ctrl-C ends."""

import _thread
import ctypes as C
import operator
import os
import threading
from pathlib import Path
from typing import Any, Callable, List, Optional, Union

from . import _structs as S

_PATH = os.environ.get("FEWRAY_LIBRARY") or str(Path(__file__).resolve().parent / "lib" / "libfewray.so")
_library = C.CDLL(_PATH)
_library.fewray_version.restype = C.c_char_p
_library.fewray_frame_add.restype = C.c_void_p
_library.fewray_frame_repair.restype = C.c_size_t
_library.fewray_error_text.restype = C.c_char_p

# OpenMP's threads don't follow into the child of a fork, which would wait for them for ever: they are ended before.
os.register_at_fork(before=lambda: _library.omp_pause_resource_all(C.c_int(2)))  # omp_pause_hard

Progress = Callable[[str, float], None]
PathLike = Union[str, "os.PathLike[str]"]


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


def path_bytes(path: PathLike) -> bytes:
    """A file's name as C takes it."""
    name = os.fsencode(path)
    if b"\0" in name:
        raise ValueError(f"a file's name can't have a zero byte: {path!r}")
    return name


def optional_path(path: Optional[PathLike]) -> Optional[bytes]:
    return path_bytes(path) if path else None


def set_integers(struct: Any, **values: Any) -> None:
    """Sets members of a struct; what they can't hold is an error, where ctypes would cut it."""
    for name, value in values.items():
        integer = operator.index(value)
        setattr(struct, name, integer)
        if getattr(struct, name) != integer:
            raise ValueError(f"{name} can't be {integer}")


def check(status: int, error: Any) -> None:
    if status == CANCELLED:
        raise KeyboardInterrupt
    if status:
        text = C.create_string_buffer(2048)
        _library.fewray_error_text(C.byref(error), text, C.c_size_t(len(text)))
        raise Error(text.value.decode(errors="replace"), status)


def run(work: Callable[[Any], int], cancel: Optional[C.c_int] = None) -> None:
    """Calls work(error), a function of the library that may take long, without Python's lock. In the main thread Ctrl-C, or
    whatever else the handler of a signal raises, sets `cancel`, which ends the work, and is raised then. As it may come
    between any two lines, here and in the caller, work itself must hold on to all memory that C uses."""
    error = S.fewray_error()
    if cancel is None or threading.current_thread() is not threading.main_thread():
        check(work(error), error)
        return
    status: List[int] = []
    failed: List[BaseException] = []
    done = threading.Lock()
    done.acquire()

    def target() -> None:
        try:
            status.append(work(error))
        except BaseException as exception:  # such as an interrupt in a callback
            failed.append(exception)
        done.release()

    raised: Optional[BaseException] = None
    try:
        # Not a threading.Thread: its start() waits, and its join(), interrupted, takes it for ended (Python 3.11).
        _thread.start_new_thread(target, ())
        while not (status or failed):
            try:
                done.acquire(timeout=0.1)
            except BaseException as exception:
                cancel.value = 1
                raised = raised or exception
    except BaseException:  # between the lines above
        cancel.value = 1
        raise
    if failed:
        raise failed[0]
    if raised is not None:
        raise raised
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
        failed, self.failed = self.failed, None
        if failed is not None:
            raise failed
