"""The process that reads files for another one: where a native reader may crash.

`contiga.io.apart` starts it and speaks with it in frames: a letter, a length, so many bytes. It
imports what a reader needs once. For each file it forks, where the system can: the fork is bounded
in time and memory, and whatever a damaged file does to it is gone with it.
"""

from __future__ import annotations

import contextlib
import gc
import os
import pickle
import struct
import sys
import traceback
import warnings
from collections.abc import Callable
from importlib import import_module
from io import RawIOBase
from pathlib import Path
from typing import Any, NamedTuple

from contiga.errors import ContigaError, ContigaWarning, FileError
from contiga.io.limits import limits_for, too_large

HELLO, READY, RESULT, ENDED = b"h", b"y", b"r", b"e"
"""Frames: started; the reader is loaded; an `Outcome`; the fork's status and peak memory."""
ASK, LOAD = b"q", b"l"
"""Frames of the one who asks: a `Request`; the name of a reader to load, which has no answer."""
HEADER = struct.Struct("<cQ")
IDLE_SECONDS = 60.0
IDLE_CODE = 75
"""Exit code of a process that was not needed any more."""
_SAID = 300
"""Characters of what a reader says that are passed on."""


class Request(NamedTuple):
    """One file to read."""

    target: str
    """module:function, called with the path and `args`."""
    path: Path
    args: tuple[object, ...]
    seconds: float
    memory: int
    folder: str
    """Relative paths start here."""
    modules: list[str]
    """sys.path."""


class Outcome(NamedTuple):
    """What came of a file."""

    kind: str
    """"value", "error" (an exception to be raised as it is), "memory", or "failed"."""
    content: Any
    """The value, the exception, or what a failed reader said and its traceback."""
    warnings: list[str]

    def value(self, path: Path) -> Any:
        """What was read; raises as `contiga.io.apart.read_apart`."""
        if self.kind == "value":
            return self.content
        if self.kind == "error":
            raise self.content
        if self.kind == "memory":
            raise too_large(str(path), limits_for(path).memory)
        said, trace = self.content
        raise FileError(
            f"cannot be read: {' '.join(said.split())[:_SAID]}",
            where=str(path),
            allowed=f"an undamaged {path.suffix} file",
        ) from RuntimeError(trace)


def attempt(target: str, path: Path, args: tuple[object, ...]) -> Outcome:
    """Call the reader; nothing but an interruption gets out of it."""
    with warnings.catch_warnings(record=True) as heard:
        warnings.simplefilter("always")
        try:
            kind, content = "value", _function(target)(path, *args)
        except (ContigaError, ImportError) as error:
            kind, content = "error", error
        except MemoryError:
            kind, content = "memory", None
        except Exception as error:
            said = f"{type(error).__name__} {error}".strip()
            kind, content = "failed", (said, traceback.format_exc())
    return Outcome(kind, content, _said(heard))


def _said(heard: list[warnings.WarningMessage]) -> list[str]:
    return [str(item.message) for item in heard if issubclass(item.category, ContigaWarning)]


def _function(target: str) -> Callable[..., Any]:
    module, _, name = target.partition(":")
    function: Callable[..., Any] = getattr(import_module(module), name)
    return function


def serve() -> None:
    """Read files until nobody asks any more."""
    requests = os.fdopen(os.dup(0), "rb", buffering=0)  # what is buffered is not waited for
    replies = os.dup(1)
    nowhere = os.open(os.devnull, os.O_RDWR)
    for stream in (0, 1, 2):  # native libraries print as they please
        os.dup2(nowhere, stream)
    write_frame(replies, HELLO, b"")
    while _somebody_asks(requests):
        frame = _all_of(requests, HEADER.size)
        if len(frame) < HEADER.size:
            return
        kind, size = HEADER.unpack(frame)
        content = _all_of(requests, size)
        if kind == LOAD:
            with contextlib.suppress(Exception):  # told when a file is to be read
                _load(content.decode())
            continue
        request: Request = pickle.loads(content)
        sys.path[:] = request.modules
        with contextlib.suppress(OSError):
            os.chdir(request.folder)
        if not _loaded(request, replies):
            continue
        write_frame(replies, READY, b"")
        if can_fork():
            _read_in_fork(request, replies)
        else:
            _bound_time(request.seconds)
            _read(request, replies)


def can_fork() -> bool:
    """Whether files are read in forks. The libraries of macOS do not stand it."""
    return hasattr(os, "fork") and sys.platform != "darwin"


def _all_of(stream: RawIOBase, size: int) -> bytes:
    """So many bytes, or those before the end of the stream."""
    content = b""
    while len(content) < size and (piece := stream.read(size - len(content))):
        content += piece
    return content


def _somebody_asks(requests: RawIOBase) -> bool:
    """Wait for a request; a process that is not needed for long gives its memory back."""
    if os.name != "posix":
        return True
    import select

    if select.select([requests], [], [], IDLE_SECONDS)[0]:
        return True
    sys.exit(IDLE_CODE)


def _loaded(request: Request, replies: int) -> bool:
    """Import the reader, and have its module load what it needs, before the time counts."""
    try:
        _load(request.target)
    except Exception as error:
        if not isinstance(error, ImportError):
            error = ImportError(f"{type(error).__name__}: {error}")
        write_frame(replies, RESULT, pickle.dumps(Outcome("error", error, [])))
        return False
    return True


def _load(target: str) -> None:
    gc.disable()  # nothing of what is loaded is garbage: looking for some is an eighth of the time
    try:
        module = import_module(target.partition(":")[0])
        getattr(module, "warm_up", lambda: None)()
        gc.freeze()  # nor is it ever: forks share it as long as nothing looks at it
    finally:
        gc.enable()


def _read_in_fork(request: Request, replies: int) -> None:
    import mmap

    answering = mmap.mmap(-1, 1)  # shared with the fork
    process = os.fork()
    if process == 0:
        code = 1
        try:
            _bound_time(request.seconds)
            _bound_memory(request.memory)
            _read(request, replies, answering)
            code = 0
        finally:
            os._exit(code)
    _, status, usage = os.wait4(process, 0)
    if status and answering[0]:
        os._exit(1)  # half a frame is out: only the end of the stream can follow it
    write_frame(replies, ENDED, pickle.dumps((status, usage.ru_maxrss * 1024)))


def _read(request: Request, replies: int, answering: Any = None) -> None:
    try:
        frame = _pickled(attempt(request.target, request.path, request.args))
    except MemoryError:
        frame = _pickled(Outcome("memory", None, []))
    if answering is not None:
        answering[0] = 1
    write_frame(replies, RESULT, frame)


def _pickled(outcome: Outcome) -> bytes:
    try:
        return pickle.dumps(outcome, protocol=5)
    except (pickle.PicklingError, TypeError, AttributeError):
        if outcome.kind != "error":
            raise
        # What an exception found may be of any kind; its text says it too.
        error = type(outcome.content)(str(outcome.content))
        return pickle.dumps(outcome._replace(content=error), protocol=5)


def _bound_time(seconds: float) -> None:
    """End this process after so much processor time from now, where the system does that."""
    if os.name != "posix":
        return
    import resource

    usage = resource.getrusage(resource.RUSAGE_SELF)
    _lower(resource.RLIMIT_CPU, int(usage.ru_utime + usage.ru_stime + seconds) + 1)
    _lower(resource.RLIMIT_CORE, 0)


def _bound_memory(memory: int) -> None:
    """Refuse this process more than `memory` bytes beyond what it has, where Linux says that."""
    if sys.platform != "linux":
        return
    import resource

    with open("/proc/self/statm", encoding="ascii") as file:
        pages = int(file.read().split()[0])
    _lower(resource.RLIMIT_AS, pages * resource.getpagesize() + memory)


def _lower(what: int, bound: int) -> None:
    import resource

    hard = resource.getrlimit(what)[1]
    with contextlib.suppress(OSError, ValueError):
        resource.setrlimit(what, (bound if hard < 0 else min(bound, hard), hard))


def write_frame(out: int, kind: bytes, content: bytes) -> None:
    """Write a frame, all of it."""
    for piece in (HEADER.pack(kind, len(content)), content):
        rest = memoryview(piece)
        while rest:
            rest = rest[os.write(out, rest) :]
