"""Running a case with everything that belongs to it: the run, its files, the report."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from contiga.cli.progress import Show, progress_bar
from contiga.cli.signals import stoppable
from contiga.errors import InputError

if TYPE_CHECKING:
    from contiga.case.schema import Case
    from contiga.simulation.checks.finding import Finding
    from contiga.simulation.result import Result


def run(
    case: Case | str | Path,
    out: str | Path | None = None,
    *,
    resume: bool = False,
    strict: bool = False,
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
    keep : keep the states of every so many steps (of a resumed run those since); None none
    quiet : no progress bar

    Returns
    -------
    Result
        ``history`` (columns by name), ``state`` at the end, ``states`` kept, ``summary``, ``out``.

    Raises
    ------
    InputError, MissingPackageError
        Something in the case, its files or the folder is wrong, or what the case asks for needs a
        package that is not installed; nothing has been written.
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
    from contiga.report import require_packages, write_report

    checked = _checked(case)
    if out is not None and checked.output.report:  # said before the run, not after it
        require_packages("a run's report (a case leaves it out by [output] report = false)")
    pace: list[str] = []
    with stoppable() as stopped, progress_bar(checked.title, quiet=quiet) as show:
        return build.run(
            checked,
            out,
            resume=resume,
            strict=strict,
            keep=keep,
            progress=_progress(show, stopped, pace),
            **_listeners(pace, quiet=quiet),
            on_finish=write_report,
        )


def _tell(findings: tuple[Finding, ...]) -> None:
    """Warn before the first step: a wrong model is not to be waited for."""
    for finding in findings:
        _warn(str(finding))


def _listeners(pace: list[str], *, quiet: bool) -> dict[str, Callable[..., None]]:
    """What a run tells as it goes on; what set a step is kept in `pace`."""

    def keep(text: str) -> None:
        pace[:] = [text]

    return {} if quiet else {"on_check": _tell, "on_pace": keep, "on_slow": _warn}


def _warn(text: str) -> None:
    print(f"warning: {text}", file=sys.stderr, flush=True)


def _progress(
    show: Show, stopped: Callable[[], bool], pace: list[str]
) -> Callable[[int, int, int], None]:
    """Shows each step, and ends the run between two of them where it is to stop.

    `pace` says what set it, or nothing.
    """

    def progress(done: int, steps: int, contacts: int) -> None:
        if stopped():
            raise KeyboardInterrupt
        show(done, steps, ", ".join([f"{contacts} in contact", *pace]))

    return progress


def _checked(case: object) -> Case:
    from contiga.case.schema import Case, load_case

    checked = load_case(case) if isinstance(case, str | Path) else case
    if not isinstance(checked, Case):
        raise InputError(
            "the case must be one",
            where="case",
            found=type(case).__name__,
            allowed="what load_case returns, or the path of a case file",
        )
    return checked
