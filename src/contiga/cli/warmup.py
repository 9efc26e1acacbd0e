"""``contiga warmup``: all kernels compiled before they are needed."""

from __future__ import annotations

import os
import threading
from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import TYPE_CHECKING, Annotated

import typer

from contiga.cli.options import Quiet
from contiga.errors import RunError
from contiga.running.progress import Show, progress_bar

if TYPE_CHECKING:
    from contiga.warmup.compile_pool import Progress
    from contiga.warmup.pack import Level

MAX_PROCESSES = 16
"""Largest default number of processes: each takes some 400 MB, and more help little."""


def warmup(
    jobs: Annotated[
        int | None,
        typer.Option("--jobs", min=1, metavar="N", help="Processes; one a core if left out."),
    ] = None,
    clear: Annotated[
        bool,
        typer.Option("--clear", help="Remove all kernels that are kept, and compile none."),
    ] = False,
    pack: Annotated[
        Path | None,
        typer.Option(
            "--pack", metavar="FOLDER", help="Write all kernels as a wheel, for other machines."
        ),
    ] = None,
    quiet: Quiet = False,
) -> None:
    """Compile all kernels now, on all cores, so that no run has to wait for them."""
    from contiga.jit.folder import kernel_folder, remove_kernels
    from contiga.jit.prebuilt import choice
    from contiga.warmup import record
    from contiga.warmup.listing import listing

    if pack is not None:
        _write_package(pack, jobs, quiet)
        return
    if choice().prebuilt is not None and not clear:
        if not quiet:
            print(f"nothing to compile: {choice().text}")
        return
    folder = kernel_folder()
    if folder is None:
        raise RunError(
            "no folder can be written to in which kernels could be kept; runs go on without, and "
            "NUMBA_CACHE_DIR=folder names one"
        )
    if clear:
        removed = remove_kernels()
        if not quiet:
            print(f"{removed} kernels removed from {folder}")
        return
    if os.environ.get("NUMBA_DISABLE_JIT", "0") not in ("", "0"):
        print("nothing to compile: NUMBA_DISABLE_JIT is set")
        return
    start = perf_counter()
    n_compiled, n_cached, errors = 0, len(listing().kernels), list[str]()
    if not record.has_all():
        count = _compile_all(jobs, quiet, os.environ)
        n_compiled, n_cached, errors = count.n_compiled, count.n_cached, count.errors
        if not errors:
            record.write(count.files.values())
    if not quiet:
        print(choice().text)
        counts = f"{n_compiled} kernels compiled, {n_cached}"
        if not n_compiled:
            counts = f"nothing to compile: {n_cached} kernels"
        seconds = f"{perf_counter() - start:.0f} s"
        print(f"{counts} were there already; {seconds}; kept in {folder}")
    if errors:
        reasons = "; ".join(errors)
        raise RunError(f"not all kernels could be compiled ({reasons}); runs go on without")


def _write_package(folder: Path, jobs: int | None, quiet: bool) -> None:
    """Compile all kernels for the levels of this kind of processor, and write them as a wheel.

    The folder is made if it does not exist. The user's own cache of kernels is not used.

    Raises
    ------
    RunError
        A kernel could not be compiled or kept, or the wheel cannot be written.
    """
    from contiga.warmup.pack import environment, levels, sources, write_wheel

    files: dict[Level, dict[int, str]] = {}
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with TemporaryDirectory(prefix="contiga-pack-", ignore_cleanup_errors=True) as cache:
            old_sources = sources()
            for level in levels():
                count = _compile_all(jobs, quiet, environment(level, Path(cache, level.name)))
                if count.errors:
                    reasons = "; ".join(count.errors)
                    raise RunError(
                        f"no wheel is written: kernels could not be compiled ({reasons})"
                    )
                files[level] = count.files
            wheel = write_wheel(files, old_sources, folder)
    except OSError as error:
        raise RunError(f"no wheel can be written to {folder} ({error.strerror})") from None
    if not quiet:
        names = " and ".join(level.name for level in files)
        print(f"{len(count.files)} kernels for {names} in {wheel}")


def _compile_all(jobs: int | None, quiet: bool, environment: Mapping[str, str]) -> _Count:
    """Compile all kernels of the list and wait; errors are in the counts, none is raised.

    `jobs` processes do it, by default one a thread but at most 16, in this environment.
    """
    from contiga.arrays.threads import thread_count
    from contiga.warmup.compile_pool import CompilePool
    from contiga.warmup.listing import listing

    names = [f"{kernel.module}.{kernel.name}" for kernel in listing().kernels]
    with progress_bar("warmup", quiet=quiet) as show:
        count = _Count(show, names)
        processes = jobs or min(thread_count(), MAX_PROCESSES)
        with CompilePool(processes, count.hear, environment=environment) as compile_pool:
            compile_pool.wait()
    return count


class _Count:
    """Counts of kernels by the messages of the processes, shown in the progress bar."""

    def __init__(self, show: Show, names: list[str]) -> None:
        self._show, self._names = show, names
        self._lock = threading.Lock()
        self._n_done = 0
        self._current_names: dict[int, str] = {}
        """Kernel that each process compiles."""
        self.n_compiled = self.n_cached = 0
        self.files: dict[int, str] = {}
        """Cache file of the kernel of each row."""
        self.errors: list[str] = []

    def hear(self, process: int, progress: Progress) -> None:
        """Count a message of a process and show the counts; processes call it on their threads."""
        name = self._names[progress.row]
        with self._lock:
            if progress.done:
                self._n_done += 1
                self._current_names.pop(process, None)
                self.n_compiled += progress.is_compiled
                self.n_cached += not (progress.is_compiled or progress.error)
                if progress.file:
                    self.files[progress.row] = progress.file
                if progress.error:
                    self.errors.append(f"{name}: {progress.error}")
            else:
                short_name = name.rpartition("kernels.")[2].replace("_nb.", ".")
                self._current_names[process] = short_name
            texts = f"{self.n_compiled} kernels compiled", *self._current_names.values()
            self._show(self._n_done, len(self._names), ", ".join(texts))
