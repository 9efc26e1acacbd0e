"""Carry out a whole run, step by step, with history, fields and checkpoints."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np

from contiga.errors import InputError, OutputError, RunError
from contiga.records import ContactStatus
from contiga.simulation.checks.finding import Finding, merged, raise_findings
from contiga.simulation.checks.model_checks import check_model
from contiga.simulation.checks.run_checks import check_run
from contiga.simulation.clock import Clock
from contiga.simulation.model import Model
from contiga.simulation.outlook import Outlook
from contiga.simulation.output_folder import newest_checkpoint
from contiga.simulation.recorder import Progress, Recorder
from contiga.simulation.result import Result
from contiga.simulation.settling import OnSettle, come_to_rest
from contiga.simulation.signals import filtered_columns
from contiga.simulation.step import StepResult, advance
from contiga.simulation.step_size import next_step
from contiga.simulation.summary import summarise
from contiga.simulation.system_state import SystemState

DOUBTFUL = {
    ContactStatus.LOST: "could not be solved",
    ContactStatus.FOUND: "lies inside and was not seen to come in",
    ContactStatus.REACQUIRED: "has lost its foot, which was found again elsewhere",
}
"""Statuses of points that are not certified, with their meaning."""


class RunOptions(NamedTuple):
    """Options of a run: see `Simulation.run`."""

    resume: bool = False
    strict: bool = False
    keep: int | None = None
    progress: Progress | None = None
    on_check: Callable[[tuple[Finding, ...]], Any] | None = None
    on_step: Callable[[SystemState], Any] | None = None
    on_finish: Callable[[Path], Any] | None = None
    """Called with the output folder once all is written, before a strict run is refused."""
    clock: Clock | None = None
    on_pace: Callable[[str], Any] | None = None
    """Called with the reason for the length of each automatic step."""
    on_slow: Callable[[str], Any] | None = None
    """Called once with a message, if the end is hours away."""
    on_settle: OnSettle | None = None
    """Called with the number of each settling step and the residual after it."""
    settle_only: bool = False
    """End at the start of the run, once the model is at rest."""
    now: Callable[[], float] = perf_counter
    """Clock for the estimate of the remaining time, seconds."""


def carry_out(model: Model, out: str | Path | None, options: RunOptions) -> Result:
    """Run `model` to its end, or with `settle_only` to rest at its start, and return the result.

    When the run is stopped (an exception, Ctrl-C) a checkpoint of the last complete step remains;
    before the first one nothing remains. No other run writes to `out` until this one has ended.

    Raises
    ------
    InputError
        `keep` is no whole number of 1 or more; with `strict`, the checks found something.
    RunError
        The run could not be carried through; with `strict`, a point is not certified.
    OutputError, CheckpointError
        The folder cannot be written, or not be resumed.
    """
    keep = options.keep
    if keep is not None and (isinstance(keep, bool) or not isinstance(keep, int) or keep < 1):
        raise InputError("must be a whole number", where="keep", found=keep, allowed=">= 1")
    clock = Clock() if options.clock is None else options.clock
    recorder = Recorder(model, clock, options.progress)
    try:
        with clock.watching(), clock("total"):
            with clock("checks"):
                findings = check_model(model)
            if options.strict and findings:
                raise_findings(findings)
            if options.on_check is not None:
                options.on_check(findings)
            kept_states: list[SystemState] = []
            outlook = Outlook(model.stepping.end, options.now)
            try:
                if out is not None:
                    recorder.open(Path(out), resume=options.resume)
                state = recorder.state
                while state is None or (
                    state.time < model.stepping.end and not options.settle_only
                ):
                    stepped = _step_from(model, state, clock, options)
                    state = stepped.state
                    if options.strict:
                        check_proved(state)
                    if options.on_pace is not None and stepped.choice is not None:
                        cut = stepped.choice.cut
                        options.on_pace(f"steps of {state.step:.2g}: {cut.text()}")
                    if options.on_slow is not None and (text := outlook.after(stepped)) is not None:
                        options.on_slow(text)
                    recorder.take(stepped)
                    if options.keep is not None and (recorder.done - 1) % options.keep == 0:
                        kept_states.append(state)
                    if options.on_step is not None:
                        options.on_step(state)
            except OutputError as error:
                with suppress(OutputError):  # of the same full disk: report it once
                    recorder.save()
                if recorder.folder is None or not newest_checkpoint(recorder.folder).is_file():
                    raise
                remedy = f"{error.remedy or 'See to it'}; then the run goes on with --resume"
                found = {"found": error.found} if error.has_found else {}
                raise OutputError(
                    error.what, where=error.where, allowed=error.allowed, remedy=remedy, **found
                ) from error
            except BaseException:
                recorder.save()
                raise
            recorder.save()
        history = recorder.columns()
        history |= filtered_columns(model, history)
        run_findings = (*check_run(model, history, state), *recorder.crest())
        all_findings = merged(findings, run_findings)
        summary = summarise(model, history, clock, all_findings, recorder.ends, state.rest)
        recorder.finish(summary, history)
        if options.on_finish is not None and recorder.folder is not None:
            options.on_finish(recorder.folder)
        if options.strict and run_findings:
            raise_findings(run_findings)
        return Result(history, recorder.folder, state, tuple(kept_states), summary)
    finally:
        recorder.release()


def _step_from(
    model: Model, state: SystemState | None, clock: Clock, options: RunOptions
) -> StepResult:
    """Return the step after `state`; at the start the first state, settled if that is asked for."""
    if state is not None:
        return next_step(model, state, clock)
    if model.settling is None and not options.settle_only:
        return advance(model, None, model.stepping.start, clock)
    with clock("settle"):
        return come_to_rest(model, clock, options.on_settle)


def check_proved(state: SystemState) -> None:
    """Raise `RunError` with contact, time, point and status if a point is not certified.

    The message is about the first contact and status, and gives the first of its points.
    """
    for name, contact in state.contacts.items():
        doubts = []
        for status, text in DOUBTFUL.items():
            rows = np.flatnonzero(contact.status == status)
            if len(rows):
                doubts.append(f"point {rows[0]} {text} ({status.name}, {len(rows)} points)")
        rows = np.flatnonzero(contact.in_contact & (contact.certified == 0))
        if len(rows):
            what = "is converged but not proved"
            doubts.append(f"the foot of point {rows[0]} {what} ({len(rows)} points)")
        if doubts:
            remedy = "Take smaller steps, or run without --strict"
            raise RunError(f"{name}: at t = {state.time:g} {doubts[0]}. {remedy}")
