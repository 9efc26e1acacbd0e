"""The progress bar of everything that takes long."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from contiga.extras import require

Show = Callable[[int, int, str], None]
"""Called with how much is done, how much there is, and what is to be said of it."""


@contextmanager
def progress_bar(title: str, *, quiet: bool) -> Iterator[Show]:
    """A progress bar on the error stream: parts done, what is said of them, time left.

    It comes with the first part, so that a message about wrong input stands alone.
    """
    if quiet:
        yield lambda done, total, said: None
        return
    require("a progress bar", "rich")
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeRemainingColumn,
    )

    columns = (
        TextColumn("{task.description}", markup=False),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("{task.fields[said]}", markup=False),
        TimeRemainingColumn(),
    )
    bar = Progress(*columns, console=Console(stderr=True))
    task = bar.add_task(title, total=None, said="")

    def show(done: int, total: int, said: str) -> None:
        bar.start()
        bar.update(task, completed=done, total=total, said=said)

    try:
        yield show
    finally:
        if bar.live.is_started:
            bar.stop()
