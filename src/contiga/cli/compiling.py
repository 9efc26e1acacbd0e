"""Tell that kernels have to be compiled, and compile them on more cores."""

from __future__ import annotations

import sys
import threading
from contextlib import suppress
from time import perf_counter
from typing import TYPE_CHECKING, Any

import typer

from contiga.jit.notice import leave_out

if TYPE_CHECKING:
    from contiga.warmup.compile_pool import CompilePool, Progress
    from contiga.warmup.listing import Row

MANY = 4
"""Kernels that are compiled before other processes are called, where it is not a first run."""
HELPERS = 7
"""Processes beside a run, at most: each takes some 400 MB."""
PAUSE = 15.0
"""Seconds between two messages."""


def watch_compiling(context: typer.Context, helped: bool = False) -> None:
    """Listen to numba until a command ends; with `helped`, have others compile as well if it pays.

    A first run compiles hundreds, so they begin at once, while it reads its case and CAD. Where all
    kernels are kept from before nothing is ever heard, and nothing is started.
    """
    leave_out()
    tell = sys.stderr.isatty() and "--quiet" not in sys.argv
    if not tell and not helped:
        return
    from numba.core import event

    from contiga.arrays.threads import thread_count
    from contiga.jit.cache import COMPILE_LISTENERS
    from contiga.jit.folder import kernel_folder

    shared = helped and kernel_folder() is not None  # what others compile is found in files
    helpers = min(thread_count() - 1, HELPERS) if shared else 0
    compile_pool: list[CompilePool] = []
    messages: list[Messages] = []
    counted, first = 0, False

    def say() -> None:
        messages.append(Messages(1 + helpers, tell))

    def call_others() -> None:
        COMPILE_LISTENERS.extend(messages)
        if helpers:
            with suppress(OSError):  # no more processes: the run compiles by itself
                compile_pool.append(_crew(helpers, messages[0]))

    class Watcher(event.Listener):  # type: ignore[misc]
        def on_start(self, _: Any) -> None:
            nonlocal counted
            counted += 1
            if counted == 1 and not first:
                say()
            if counted == MANY and not first:
                call_others()

        def on_end(self, _: Any) -> None:
            pass

    watcher = Watcher()
    event.register("numba:compile", watcher)

    @context.call_on_close
    def end() -> None:
        event.unregister("numba:compile", watcher)
        own = (*messages, *compile_pool)
        COMPILE_LISTENERS[:] = [other for other in COMPILE_LISTENERS if other not in own]
        for one in compile_pool:
            one.end()

    first = helpers > 0 and _is_first()
    if first:
        say()
        call_others()


class Messages:
    """Print on the error stream that kernels are compiled, and now and then how many are left.

    It is a `CompileListener`, and listens to the processes of a `CompilePool` too.

    Which kernels a run will need is not known before: those that are left are at most those of the
    list that nobody has come to.

    Parameters
    ----------
    cores : how many processes compile
    tell : whether anything is said
    """

    def __init__(self, cores: int, tell: bool) -> None:
        from contiga.jit.prebuilt import choice
        from contiga.warmup.listing import listing

        self._listing = listing()
        self._left = set(range(len(self._listing.kernels)))
        self._lock = threading.Lock()
        self._tell = tell
        self._said_at = perf_counter()
        if tell and choice().refused:
            print(choice().text, file=sys.stderr, flush=True)
        on = f" on {cores} cores" if cores > 1 else ""
        self._say(f"compiling kernels{on}, once for all projects of this user")

    def before(self, module: str, name: str, arguments: tuple[Any, ...]) -> None:
        """A kernel will be compiled."""

    def after(self, module: str, name: str, arguments: tuple[Any, ...]) -> None:
        """A kernel is there, or cannot be compiled."""
        self._done(self._listing.find(module, name, arguments))

    def hear(self, process: int, progress: Progress) -> None:
        """Take note of what another process tells."""
        if progress.done:
            self._done(progress.row)

    def _done(self, row: Row | None) -> None:
        with self._lock:
            self._left -= {row}
            if perf_counter() - self._said_at >= PAUSE:
                self._said_at = perf_counter()
                self._say("compiling kernels")

    def _say(self, what: str) -> None:
        if self._tell:
            print(f"{what}: at most {len(self._left)} left", file=sys.stderr, flush=True)


def _is_first() -> bool:
    """Return whether the kernel of tracking has to be compiled, which every case comes to."""
    from contiga.jit.preload import is_missing
    from contiga.search.track.kernels.track_nb import track_chunks

    return is_missing(track_chunks)


def _crew(helpers: int, messages: Messages) -> CompilePool:
    from contiga.jit.cache import COMPILE_LISTENERS
    from contiga.warmup.compile_pool import CompilePool

    compile_pool = CompilePool(helpers, messages.hear)
    COMPILE_LISTENERS.append(compile_pool)
    return compile_pool
