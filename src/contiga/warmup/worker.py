"""The process that goes through exercises: a name a line on its standard input, JSON lines back.

It ends with its input, whatever it is at: with the process that started it, that is.
"""

from __future__ import annotations

import json
import os
import signal
import sys
import threading
from collections.abc import Iterator
from hashlib import sha256
from queue import SimpleQueue
from typing import Any, TextIO

from numba.core import event

from contiga.num.compiler import PLACE_IN_MEMORY, KernelDispatcher
from contiga.num.garbage import look_seldom
from contiga.warmup import exercises


def serve() -> None:
    """Do what is asked for, one after the other."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the process that started this one
    look_seldom()
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    nowhere = os.open(os.devnull, os.O_RDWR)
    for stream in (1, 2):  # what exercises print, and native libraries
        os.dup2(nowhere, stream)
    names: SimpleQueue[str] = SimpleQueue()
    threading.Thread(target=_listen, args=(names,), daemon=True).start()
    event.register("numba:compile", Telling(answers))
    while True:
        name = names.get()
        error = None
        try:
            getattr(exercises, name)()
        except Exception as failed:
            error = f"{type(failed).__name__}: {failed}"
        tell(answers, done=name, error=error, **found())


def _listen(names: SimpleQueue[str]) -> None:
    for line in sys.stdin:
        names.put(line.strip())
    os._exit(0)


def tell(answers: TextIO, **what: object) -> None:
    """Write a line; where nobody reads any more, end."""
    try:
        answers.write(json.dumps(what) + "\n")
        answers.flush()
    except OSError:
        os._exit(0)


class Telling(event.Listener):  # type: ignore[misc]
    """Tells of each kernel that is compiled, when that begins and when it is there."""

    def __init__(self, answers: TextIO) -> None:
        self._answers = answers

    def on_start(self, begun: Any) -> None:
        """Kernels that are kept, and none that this process waits for."""
        if isinstance(begun.data.get("dispatcher"), KernelDispatcher):
            function = begun.data["dispatcher"].py_func
            home = function.__module__.rpartition(".")[2].removesuffix("_nb")
            tell(self._answers, compiling=f"{home}.{function.__name__}")

    def on_end(self, ended: Any) -> None:
        """One kernel more is there."""
        if isinstance(ended.data.get("dispatcher"), KernelDispatcher):
            tell(self._answers, compiled=1)


def found() -> dict[str, list[str]]:
    """Names of what this process has compiled so far, and the folders its kernels are kept in."""
    made = {_name(kernel, of) for kernel in _kernels() for of in kernel.stats.cache_misses}
    folders = {kernel.stats.cache_path for kernel in _kernels()}
    return {"made": sorted(made), "folders": sorted(folders)}


def _kernels() -> Iterator[KernelDispatcher]:
    for name, module in list(sys.modules.items()):
        if name.startswith("contiga."):
            for value in list(vars(module).values()):
                if isinstance(value, KernelDispatcher) and value.py_func.__module__ == name:
                    yield value


def _name(kernel: KernelDispatcher, signature: Any) -> str:
    """The same in all processes, and short."""
    types = PLACE_IN_MEMORY.sub("", str(signature))
    version = sha256(types.encode()).hexdigest()[:16]
    return f"{kernel.py_func.__module__}.{kernel.py_func.__qualname__} {version}"
