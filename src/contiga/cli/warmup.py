"""``contiga warmup``: all kernels compiled before they are needed."""

from __future__ import annotations

import os
import threading
from pathlib import Path
from time import perf_counter
from typing import Annotated, Any

import typer

from contiga.cli.progress import Show, progress_bar
from contiga.errors import RunError

MOST = 8
"""Processes where none are asked for, at most: each has half a GB, and more help little."""


def warmup(
    jobs: Annotated[
        int | None,
        typer.Option("--jobs", min=1, metavar="N", help="Processes; one a core if left out."),
    ] = None,
    quiet: Annotated[bool, typer.Option("--quiet", help="Print nothing but errors.")] = False,
) -> None:
    """Compile all kernels now, on all cores, so that no run has to wait for them."""
    from contiga.num.threads import thread_count
    from contiga.warmup import EXERCISES, record
    from contiga.warmup.crew import Crew

    if os.environ.get("NUMBA_DISABLE_JIT", "0") not in ("", "0"):
        print("nothing to compile: NUMBA_DISABLE_JIT is set")
        return
    start = perf_counter()
    kept = record.known()
    if kept:
        if not quiet:
            print(_line(0, kept, perf_counter() - start))
        return
    jobs = min(jobs or min(thread_count(), MOST), len(EXERCISES))
    with progress_bar("warmup", quiet=quiet) as show:
        count = _Count(show, len(EXERCISES) + jobs)  # each process has a last one
        with Crew(EXERCISES, jobs, count.hear) as crew:
            crew.wait()
    kept = [str(file) for folder in count.folders for file in Path(folder).glob("*.nb[ci]")]
    if not quiet:
        print(_line(len(count.compiled), kept, perf_counter() - start))
    if not count.failed:
        record.written(count.folders)
    else:
        failed = "; ".join(count.failed)
        raise RunError(f"not all exercises of kernels could be done ({failed}); runs go on without")


class _Count:
    """What the processes tell, added up and shown."""

    def __init__(self, show: Show, exercises: int) -> None:
        self._show, self._exercises = show, exercises
        self._lock = threading.Lock()
        self._done = self._so_far = 0
        self._at: dict[int, str] = {}
        self.compiled: set[str] = set()
        self.folders: set[str] = set()
        self.failed: list[str] = []

    def hear(self, process: int, told: dict[str, Any]) -> None:
        """A message of a process."""
        with self._lock:
            self._so_far += told.get("compiled", 0)
            if "compiling" in told:
                self._at[process] = told["compiling"]
            name = told.get("done") or told.get("lost")
            if name is not None:
                self._done += 1
                self._at.pop(process, None)
                self.compiled.update(told.get("made", ()))
                self.folders.update(told.get("folders", ()))
                lost = f"its process ended with code {told.get('code')}"
                error = told.get("error", lost)
                if error is not None:
                    self.failed.append(f"{name}: {error}")
            self._show(self._done, self._exercises, self._said())

    def _said(self) -> str:
        return ", ".join((f"{self._so_far} kernels compiled", *self._at.values()))


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
