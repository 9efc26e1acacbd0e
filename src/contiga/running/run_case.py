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
    from contiga.simulation.checks.finding import Finding
    from contiga.simulation.result import Result
    from contiga.simulation.run import RunOptions


SHOWN = 20
"""Steps to rest from one that is shown to the next."""


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
    """Run a case and write its output folder, the report included.

    Parameters
    ----------
    case : a `Case`, or the path of its file
    out : folder for the results; None keeps them in memory only
    resume : go on from the checkpoint in `out`
    strict : refuse a model that looks wrong; stop at the first point that is not certified
    settle_only : end where the run would begin, at rest
    keep : keep the states of every so many steps (of a resumed run those since); None none
    quiet : no progress bar

    Returns
    -------
    Result
        ``history`` by column, ``state`` at the end, ``states`` kept, ``summary``, ``out``

    Raises
    ------
    InputError, MissingPackageError
        The case, a file or the folder is wrong, or a package is missing; nothing has been written.
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
    from contiga.report import write_report
    from contiga.simulation.run import RunOptions

    checked = _with_packages(_checked(case), out)
    with stoppable() as stopped, progress_bar(checked.title, quiet=quiet) as show:
        progress = Progress(show, stopped)
        how = RunOptions(
            resume=resume, strict=strict, settle_only=settle_only, keep=keep, on_finish=write_report
        )
        return build.run(checked, out, progress.told_by(how, quiet))


def _with_packages(case: Case, out: str | Path | None) -> Case:
    """The case; a package that its report needs is asked for before the run, not after it."""
    from contiga.report import require_packages

    if out is not None and case.output.report:
        require_packages("a run's report (a case leaves it out by [output] report = false)")
    return case


def _warn_of(findings: tuple[Finding, ...]) -> None:
    """Warn of a model that looks wrong before its first step."""
    for finding in findings:
        _warn(str(finding))


def _warn(text: str) -> None:
    print(f"warning: {text}", file=sys.stderr, flush=True)


class Progress:
    """Shows each step, and ends the run between two of them after Ctrl-C."""

    def __init__(self, show: Show, stopped: Callable[[], bool]) -> None:
        self._show, self._stopped = show, stopped
        self._reason = ""

    def told_by(self, how: RunOptions, quiet: bool) -> RunOptions:
        """Return how a run is carried out that tells this of its steps."""
        return how._replace(
            progress=self.step,
            on_check=None if quiet else _warn_of,
            on_pace=self.keep_reason,
            on_slow=None if quiet else _warn,
            on_settle=self.settle,
        )

    def keep_reason(self, reason: str) -> None:
        """Keep what set the length of the step, to show it with the step."""
        self._reason = f", {reason}"

    def settle(self, step: int, residual: float) -> None:
        """Show how far all is from rest before the first step.

        Raises
        ------
        KeyboardInterrupt
            Ctrl-C came since the last step.
        """
        if self._stopped():
            raise KeyboardInterrupt
        if step % SHOWN == 0:
            self._show(0, 1, f"settling: step {step}, residual {residual:.2g}")

    def step(self, done: int, steps: int, contacts: int) -> None:
        """Show that `done` of `steps` states are there, the last with so many points in contact.

        Raises
        ------
        KeyboardInterrupt
            Ctrl-C came since the last step.
        """
        if self._stopped():
            raise KeyboardInterrupt
        self._show(done - 1, steps - 1, f"{contacts} in contact{self._reason}")


def _checked(case: object) -> Case:
    from contiga.case.schema import Case, load_case

    checked = load_case(case) if isinstance(case, str | Path) else case
    if not isinstance(checked, Case):
        raise InputError(
            "expected a case",
            where="case",
            found=type(case).__name__,
            allowed="what load_case returns, or the path of a case file",
        )
    return checked
