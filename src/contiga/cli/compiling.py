"""What a command does about kernels that have to be compiled: says so, and takes more cores."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from contiga.warmup.crew import Crew

WITH_HELP = ("run", "check", "preview")
"""Commands whose kernels other processes compile beside them."""
MANY = 10
"""Kernels that are compiled before there is a need of others: a first run compiles hundreds."""
HELPERS = 3
"""Processes beside a run, at most: what kernels are built of is compiled one after the other."""


def watch_compiling(tell: bool, command: str | None) -> Callable[[], None]:
    """Listen to numba while a command runs; returns what ends that, and the other processes.

    Where all kernels are kept from before nothing is ever heard, and nothing is started.
    """
    if not tell and command not in WITH_HELP:
        return lambda: None
    from numba.core import event

    from contiga.num.threads import thread_count

    helpers = min(thread_count() - 1, HELPERS) if command in WITH_HELP else 0
    crew: list[Crew] = []
    counted = 0

    class Watcher(event.Listener):  # type: ignore[misc]
        def on_start(self, _: Any) -> None:
            nonlocal counted
            counted += 1
            if counted == 1 and tell:
                print(_line(helpers), file=sys.stderr, flush=True)
            if counted == MANY and helpers:
                crew.append(_crew(helpers))

        def on_end(self, _: Any) -> None:
            pass

    watcher = Watcher()
    event.register("numba:compile", watcher)

    def end() -> None:
        event.unregister("numba:compile", watcher)
        for one in crew:
            one.end()

    return end


def _line(helpers: int) -> str:
    cores = f" on {1 + helpers} cores" if helpers else ""
    return f"compiling kernels{cores}, which a first run on a machine does: some minutes, once"


def _crew(helpers: int) -> Crew:
    from contiga.warmup import BESIDE
    from contiga.warmup.crew import Crew

    return Crew(BESIDE, helpers)
