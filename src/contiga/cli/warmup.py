"""``contiga warmup``: all kernels compiled before they are needed."""

from __future__ import annotations

import os
import threading
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Annotated

import typer

from contiga.cli.options import Quiet
from contiga.errors import RunError
from contiga.running.progress import Show, progress_bar

if TYPE_CHECKING:
    from contiga.warmup.compile_pool import Progress

MOST = 16
"""Processes where none are asked for, at most: each takes some 400 MB, and more help little."""


def warmup(
    jobs: Annotated[
        int | None,
        typer.Option("--jobs", min=1, metavar="N", help="Processes; one a core if left out."),
    ] = None,
    quiet: Quiet = False,
) -> None:
    """Compile all kernels now, on all cores, so that no run has to wait for them."""
    from contiga.arrays.threads import thread_count
    from contiga.warmup import record
    from contiga.warmup.compile_pool import CompilePool
    from contiga.warmup.listing import listing

    if os.environ.get("NUMBA_DISABLE_JIT", "0") not in ("", "0"):
        print("nothing to compile: NUMBA_DISABLE_JIT is set")
        return
    start = perf_counter()
    kept = record.known()
    if kept:
        if not quiet:
            print(_line(0, kept, perf_counter() - start))
        return
    jobs = jobs or min(thread_count(), MOST)
    with progress_bar("warmup", quiet=quiet) as show:
        count = _Count(show, [f"{one.module}.{one.name}" for one in listing().kernels])
        with CompilePool(jobs, count.hear) as compile_pool:
            compile_pool.wait()
    kept = [str(file) for folder in count.folders for file in Path(folder).glob("*.nb[ci]")]
    if not quiet:
        print(_line(count.compiled, kept, perf_counter() - start))
    if not count.failed:
        record.written(count.folders)
    else:
        failed = "; ".join(count.failed)
        raise RunError(f"not all kernels could be compiled ({failed}); runs go on without")


class _Count:
    """What the processes tell, added up and shown."""

    def __init__(self, show: Show, names: list[str]) -> None:
        self._show, self._names = show, names
        self._lock = threading.Lock()
        self._done = 0
        self._at: dict[int, str] = {}
        self.compiled = 0
        self.folders: set[str] = set()
        self.failed: list[str] = []

    def hear(self, process: int, progress: Progress) -> None:
        """A message of a process."""
        name = self._names[progress.row]
        with self._lock:
            if progress.done:
                self._done += 1
                self._at.pop(process, None)
                self.compiled += progress.made
                self.folders |= {progress.folder} - {""}
                if progress.error:
                    self.failed.append(f"{name}: {progress.error}")
            else:
                self._at[process] = name.rpartition("kernels.")[2].replace("_nb.", ".")
            self._show(self._done, len(self._names), self._said())

    def _said(self) -> str:
        return ", ".join((f"{self.compiled} kernels compiled", *self._at.values()))


def _line(compiled: int, files: list[str], seconds: float) -> str:
    """What was done, and where the `files` of kernels are."""
    there = max(sum(file.endswith(".nbc") for file in files) - compiled, 0)
    if compiled:
        counts = f"{compiled} kernels compiled, {there} were there already"
    else:
        counts = f"nothing to compile: {there} kernels were there already"
    folders = {os.path.dirname(file) for file in files}
    where = os.path.commonpath(folders) if folders else "no files"
    return f"{counts}; {seconds:.0f} s; kept in {where}"
