"""Announce that kernels have to be compiled, and compile them on more cores."""

from __future__ import annotations

import sys
import threading
from contextlib import suppress
from time import perf_counter
from typing import TYPE_CHECKING, Any

import typer

from contiga.jit.notice import suppress_notice

if TYPE_CHECKING:
    from contiga.warmup.compile_pool import CompilePool, Progress
    from contiga.warmup.listing import Row

MIN_KERNELS = 4
"""Number of kernels that a later run compiles before it starts other processes."""
MAX_HELPERS = 7
"""Largest number of processes beside a run: each takes some 400 MB."""
PAUSE = 15.0
"""Time between two messages, seconds."""


def watch_compiling(context: typer.Context, helped: bool = False) -> None:
    """Announce compiling on the error stream until a command ends; with `helped`, share it.

    Messages appear in a terminal without --quiet, from the first kernel that numba compiles on.
    Up to seven other processes start with the fourth kernel; if the kernel of tracking is not
    cached, which means a first run of hundreds of kernels, all of this begins at once. If all
    kernels are cached, nothing is started. When the command ends, the processes are killed.
    """
    suppress_notice()
    tell = sys.stderr.isatty() and "--quiet" not in sys.argv
    if not tell and not helped:
        return
    from numba.core import event

    from contiga.arrays.threads import thread_count
    from contiga.jit.cache import COMPILE_LISTENERS
    from contiga.jit.folder import kernel_folder

    can_share = helped and kernel_folder() is not None  # processes share kernels by files
    n_helpers = min(thread_count() - 1, MAX_HELPERS) if can_share else 0
    messages: list[Messages] = []
    pools: list[CompilePool] = []
    n_compiled, is_first_run = 0, False

    def start_messages() -> None:
        messages.append(Messages(1 + n_helpers, tell))

    def start_helpers() -> None:
        from contiga.warmup.compile_pool import CompilePool

        if n_helpers:
            with suppress(OSError):  # no more processes: the run compiles by itself
                pools.append(CompilePool(n_helpers, messages[0].hear))
        COMPILE_LISTENERS.extend([*messages, *pools])

    class Watcher(event.Listener):  # type: ignore[misc]
        def on_start(self, _: Any) -> None:
            nonlocal n_compiled
            n_compiled += 1
            if n_compiled == 1 and not is_first_run:
                start_messages()
            if n_compiled == MIN_KERNELS and not is_first_run:
                start_helpers()

        def on_end(self, _: Any) -> None:
            pass

    watcher = Watcher()
    event.register("numba:compile", watcher)

    @context.call_on_close
    def end() -> None:
        event.unregister("numba:compile", watcher)
        started = (*messages, *pools)
        COMPILE_LISTENERS[:] = [other for other in COMPILE_LISTENERS if other not in started]
        for pool in pools:
            pool.end()

    is_first_run = n_helpers > 0 and _is_first()
    if is_first_run:
        start_messages()
        start_helpers()


class Messages:
    """Print on the error stream that kernels are compiled, and regularly how many remain.

    It is a `CompileListener`, and listens to the processes of a `CompilePool` too. A run may not
    need all kernels of the list, so that the remaining ones are an upper bound.

    Parameters
    ----------
    cores : number of processes that compile
    tell : whether to print anything
    """

    def __init__(self, cores: int, tell: bool) -> None:
        from contiga.jit.prebuilt import choice
        from contiga.warmup.listing import listing

        self._listing = listing()
        self._remaining = set(range(len(self._listing.kernels)))
        self._lock = threading.Lock()
        self._tell = tell
        self._message_time = perf_counter()
        if tell and choice().refused:
            print(choice().text, file=sys.stderr, flush=True)
        on = f" on {cores} cores" if cores > 1 else ""
        self._print(f"compiling kernels{on}, once for all projects of this user")

    def before(self, module: str, name: str, arguments: tuple[Any, ...]) -> None:
        """Do nothing: counted are the kernels that have been compiled."""

    def after(self, module: str, name: str, arguments: tuple[Any, ...]) -> None:
        """Count a kernel that this process has compiled, or cannot compile."""
        self._remove(self._listing.find(module, name, arguments))

    def hear(self, process: int, progress: Progress) -> None:
        """Count a kernel that another process has compiled, or found in the cache."""
        if progress.done:
            self._remove(progress.row)

    def _remove(self, row: Row | None) -> None:
        """Count a kernel as done; print how many remain, unless the last message is too recent."""
        with self._lock:
            self._remaining -= {row}
            if perf_counter() - self._message_time >= PAUSE:
                self._message_time = perf_counter()
                self._print("compiling kernels")

    def _print(self, text: str) -> None:
        if self._tell:
            print(f"{text}: at most {len(self._remaining)} left", file=sys.stderr, flush=True)


def _is_first() -> bool:
    """Return whether the kernel of tracking, which every case needs, is not cached."""
    from contiga.jit.preload import is_missing
    from contiga.search.track.kernels.track_nb import track_chunks

    return is_missing(track_chunks)
