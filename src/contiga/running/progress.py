"""Progress of long tasks: a bar on a terminal, a line of text in a notebook."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import perf_counter
from typing import Any

from contiga.display import in_notebook
from contiga.extras import require

Show = Callable[[int, int, str], None]
"""Called with the parts done, the number of parts, and a text."""
_PAUSE = 0.2
"""Shortest time between two states of the line, seconds."""


@contextmanager
def progress_bar(title: str, *, quiet: bool) -> Iterator[Show]:
    """Provide a function that shows progress in the notebook or on the error stream.

    It shows parts done, a text and the remaining time, and nothing before its first call, so that
    a message about wrong input stands alone. `quiet` provides one that shows nothing. Raises
    `MissingPackageError` without rich, which draws the bar of a terminal.
    """
    if quiet:
        yield lambda done, total, text: None
    elif in_notebook(sys.stderr):
        line = _Line(title)
        try:
            yield line.show
        finally:
            line.end()
    else:
        yield from _bar(title)


class _Line:
    """A line of text that replaces itself: a saved notebook holds only the last one."""

    def __init__(self, title: str) -> None:
        self._title = title
        self._start_time = self._write_time = 0.0
        self._text = ""
        self._output: Any = None

    def show(self, done: int, total: int, text: str) -> None:
        """Set the text of the line, and write it if the last time was `_PAUSE` ago."""
        now = perf_counter()
        self._start_time = self._start_time or now
        remaining = (now - self._start_time) * (total - done) / done if done else 0.0
        share = f"{self._title}: {done}/{total}, {100 * done // max(total, 1)} %"
        parts = [share, f"{remaining:.0f} s left" if remaining else "", text]
        self._text = ", ".join(filter(None, parts))
        if now - self._write_time >= _PAUSE:
            self._write_time = now
            self._write()

    def end(self) -> None:
        """Write the last state, if there is one."""
        if self._text:
            self._write()

    def _write(self) -> None:
        line = {"text/plain": self._text}
        if self._output is not None:
            self._output.update(line, raw=True)
            return
        from IPython.display import display  # every notebook has it

        self._output = display(line, raw=True, display_id=True)


def _bar(title: str) -> Iterator[Show]:
    """Provide a function that shows a progress bar of rich from its first call on."""
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
        """The bar, and the text below it: beside it a terminal would have no room."""

        def get_renderables(self) -> Iterator[RenderableType]:
            yield from super().get_renderables()
            for task in self.tasks:
                yield Text(task.fields["text"], overflow="fold")

    columns = (
        TextColumn("{task.description}", markup=False),
        BarColumn(),
        MofNCompleteColumn(),
        TimeRemainingColumn(),
    )
    bar = TwoLines(*columns, console=Console(stderr=True))
    task = bar.add_task(title, total=None, text="")

    def show(done: int, total: int, text: str) -> None:
        bar.start()
        bar.update(task, completed=done, total=total, text=text)

    try:
        yield show
    finally:
        if bar.live.is_started:
            bar.stop()
