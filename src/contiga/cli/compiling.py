"""What a command does about kernels that have to be compiled: says so, and takes more cores."""

from __future__ import annotations

import sys
from contextlib import suppress
from typing import TYPE_CHECKING, Any

import typer

if TYPE_CHECKING:
    from contiga.warmup.compile_pool import CompilePool

MANY = 4
"""Kernels that are compiled before other processes are called, where it is not a first run."""
HELPERS = 7
"""Processes beside a run, at most: each takes some 400 MB."""


def watch_compiling(context: typer.Context, helped: bool = False) -> None:
    """Listen to numba until a command ends; with `helped`, have others compile as well if it pays.

    A first run compiles hundreds, so they begin at once, while it reads its case and CAD. Where all
    kernels are kept from before nothing is ever heard, and nothing is started.
    """
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
    counted, first = 0, False

    def say() -> None:
        if tell:
            print(_line(helpers), file=sys.stderr, flush=True)

    def call_others() -> None:
        if helpers:
            with suppress(OSError):  # no more processes: the run compiles by itself
                compile_pool.append(_crew(helpers))

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
        for one in compile_pool:
            COMPILE_LISTENERS.remove(one)
            one.end()

    first = helpers > 0 and _is_first()
    if first:
        say()
        call_others()


def _is_first() -> bool:
    """Whether the kernel of tracking has to be compiled, which every case comes to."""
    from contiga.jit.preload import is_missing
    from contiga.search.track.kernels.track_nb import track_chunks

    return is_missing(track_chunks)


def _line(helpers: int) -> str:
    cores = f" on {1 + helpers} cores" if helpers else ""
    return (
        f"compiling kernels{cores}, which a first run on a machine does: some three minutes of "
        "processor time, once"
    )


def _crew(helpers: int) -> CompilePool:
    from contiga.jit.cache import COMPILE_LISTENERS
    from contiga.warmup.compile_pool import CompilePool

    compile_pool = CompilePool(helpers)
    COMPILE_LISTENERS.append(compile_pool)
    return compile_pool
