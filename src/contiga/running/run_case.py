"""`contiga.run`: a case, its output folder and its report in one call."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from contiga.errors import InputError
from contiga.running.interrupts import stoppable
from contiga.running.progress import Show, progress_bar

if TYPE_CHECKING:
    from contiga.case.schema import Case
    from contiga.simulation.result import Result


SETTLE_INTERVAL = 20
"""Number of steps between two that are shown while the model comes to rest."""


def run(
    case: Case | str | Path,
    out: str | Path | None = None,
    *,
    resume: bool = False,
    strict: bool = False,
    settle_only: bool = False,
    keep: int | None = None,
    quiet: bool = True,
) -> Result:
    """Run a case, write its output folder, the report included, and return the result.

    Parameters
    ----------
    case : a `Case`, or the path of its file
    out : folder for the results; None keeps them in memory only
    resume : go on from the checkpoint in `out`
    strict : refuse a model that looks wrong; stop at the first point that is not certified
    settle_only : end at rest, before the first step
    keep : number of steps between states that are kept (of a resumed run, since then); None: none
    quiet : no progress bar

    Returns
    -------
    Result
        ``history`` by column, ``state`` at the end, ``states`` kept, ``summary``, ``out``

    Raises
    ------
    InputError, MissingPackageError
        The case, a file or the folder is wrong, or a package is missing; nothing has been written,
        except before a full disk stops the run, or before findings about a run that is `strict`.
    RunError
        The run could not be carried through.

    Examples
    --------
    >>> import contiga as cg
    >>> result = run("case.toml", out="out")
    >>> round(result.summary["sensors"]["head_cg"]["criteria"]["HIC15"]["value"], -1)
    1090.0
    >>> few = cg.load_case("case.toml", set={"time.end": 2.0, "time.step": 0.5})
    >>> [state.time for state in cg.run(few, keep=2).states]
    [0.0, 1.0, 2.0]
    """
    from contiga.case import build
    from contiga.case.schema import Case, load_case
    from contiga.report import require_packages, write_report
    from contiga.simulation.run import RunOptions

    loaded = load_case(case) if isinstance(case, str | Path) else case
    if not isinstance(loaded, Case):
        raise InputError(
            "expected a case",
            where="case",
            found=type(case).__name__,
            allowed="what load_case returns, or the path of a case file",
        )
    if out is not None and loaded.output.report:  # before the run, not after it
        require_packages("a run's report (a case leaves it out by [output] report = false)")
    with stoppable() as is_stopped, progress_bar(loaded.title, quiet=quiet) as show:
        progress = Progress(show, is_stopped)
        options = RunOptions(
            resume=resume,
            strict=strict,
            settle_only=settle_only,
            keep=keep,
            on_finish=write_report,
            progress=progress.step,
            on_check=None if quiet else lambda findings: _warn(*findings),
            on_pace=progress.keep_reason,
            on_slow=None if quiet else _warn,
            on_settle=progress.settle,
        )
        return build.run(loaded, out, options)


def _warn(*messages: object) -> None:
    for message in messages:
        print(f"warning: {message}", file=sys.stderr, flush=True)


class Progress:
    """Shows each step, and ends the run between two of them after Ctrl-C."""

    def __init__(self, show: Show, is_stopped: Callable[[], bool]) -> None:
        self._show, self._is_stopped = show, is_stopped
        self._reason = ""

    def keep_reason(self, reason: str) -> None:
        """Keep the reason for the length of the step, to show it with the step."""
        self._reason = f", {reason}"

    def settle(self, step: int, residual: float) -> None:
        """Show the residual in every `SETTLE_INTERVAL`-th step while the model comes to rest.

        Raises
        ------
        KeyboardInterrupt
            Ctrl-C came since the last step.
        """
        if self._is_stopped():
            raise KeyboardInterrupt
        if step % SETTLE_INTERVAL == 0:
            self._show(0, 1, f"settling: step {step}, residual {residual:.2g}")

    def step(self, done: int, steps: int, contacts: int) -> None:
        """Show that `done` of `steps` states are computed, the start among them.

        `contacts` is the number of points in contact.

        Raises
        ------
        KeyboardInterrupt
            Ctrl-C came since the last step.
        """
        if self._is_stopped():
            raise KeyboardInterrupt
        self._show(done - 1, steps - 1, f"{contacts} in contact{self._reason}")
