"""Running a case with everything that belongs to it: the run, its files, the report."""

from __future__ import annotations

import signal
import threading
import weakref
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING

from contiga.errors import InputError

if TYPE_CHECKING:
    from contiga.case.schema import Case
    from contiga.simulation.run import Result


def run(
    case: Case | str | Path,
    out: str | Path | None = None,
    *,
    resume: bool = False,
    strict: bool = False,
    quiet: bool = True,
) -> Result:
    """Run a case and write its output folder, the report included.

    Parameters
    ----------
    case : a `Case`, or the path of its file
    out : folder for the results; None keeps them in memory only
    resume : go on from the checkpoint in `out`
    strict : stop at the first point whose foot or side is not proved
    quiet : no progress bar

    Returns
    -------
    Result
        ``history`` (columns by name), ``summary``, ``out``.

    Raises
    ------
    InputError
        Something in the case, its files or the folder is wrong; nothing has been written.
    RunError
        The run could not be carried through.
    """
    from contiga.case import build
    from contiga.case.schema import Case, load_case
    from contiga.report import write_report

    checked = load_case(case) if isinstance(case, str | Path) else case
    if not isinstance(checked, Case):
        raise InputError(
            "the case must be one",
            where="case",
            found=type(case).__name__,
            allowed="what load_case returns, or the path of a case file",
        )
    with _stoppable() as stopped, _bar(checked.title, quiet=quiet) as show:

        def progress(done: int, steps: int, contacts: int) -> None:
            if stopped():
                raise KeyboardInterrupt
            show(done, steps, contacts)

        return build.run(
            checked,
            out,
            resume=resume,
            strict=strict,
            progress=progress,
            on_finish=write_report,
        )


@contextmanager
def _stoppable() -> Iterator[Callable[[], bool]]:
    """Ctrl-C that is not lost: yields a function that says whether there was one.

    Python drops an exception in the callback of a weak reference, and while kernels are loaded
    most of its own time goes by in these. There Ctrl-C is only noted, for the next step.
    """
    noted = False

    def note(_: int, frame: FrameType | None) -> None:
        nonlocal noted
        noted = True
        if frame is None or frame.f_code.co_filename != weakref.__file__:
            raise KeyboardInterrupt

    ours = (
        threading.current_thread() is threading.main_thread()
        and signal.getsignal(signal.SIGINT) is signal.default_int_handler
    )
    if not ours:
        yield lambda: False
        return
    signal.signal(signal.SIGINT, note)
    try:
        yield lambda: noted
    finally:
        signal.signal(signal.SIGINT, signal.default_int_handler)


@contextmanager
def _bar(title: str, *, quiet: bool) -> Iterator[Callable[[int, int, int], None]]:
    """A progress bar on the error stream: steps done, points in contact, time left.

    It comes with the first step, so that a message about wrong input stands alone.
    """
    if quiet:
        yield lambda done, steps, contacts: None
        return
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
        TextColumn("{task.fields[contacts]} in contact"),
        TimeRemainingColumn(),
    )
    bar = Progress(*columns, console=Console(stderr=True))
    task = bar.add_task(title, total=None, contacts=0)

    def show(done: int, steps: int, contacts: int) -> None:
        bar.start()
        bar.update(task, completed=done, total=steps, contacts=contacts)

    try:
        yield show
    finally:
        if bar.live.is_started:
            bar.stop()
