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
    from rich.console import Console, RenderableType
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeRemainingColumn,
    )
    from rich.text import Text

    class TwoLines(Progress):
        """The bar, and under it what is said: beside it a terminal would have no room for that."""

        def get_renderables(self) -> Iterator[RenderableType]:
            yield from super().get_renderables()
            for task in self.tasks:
                yield Text(task.fields["said"], overflow="fold")

    columns = (
        TextColumn("{task.description}", markup=False),
        BarColumn(),
        MofNCompleteColumn(),
        TimeRemainingColumn(),
    )
    bar = TwoLines(*columns, console=Console(stderr=True))
    task = bar.add_task(title, total=None, said="")

    def show(done: int, total: int, said: str) -> None:
        bar.start()
        bar.update(task, completed=done, total=total, said=said)

    try:
        yield show
    finally:
        if bar.live.is_started:
            bar.stop()
