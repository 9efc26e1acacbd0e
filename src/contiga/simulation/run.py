"""Carry out a whole run: step by step to the end, with history, fields and checkpoints."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from time import perf_counter
from typing import Any, NamedTuple

from contiga.errors import InputError, OutputError
from contiga.simulation.checks.finding import Finding, raise_findings, together
from contiga.simulation.checks.model_checks import check_model
from contiga.simulation.checks.run_checks import check_run
from contiga.simulation.clock import Clock
from contiga.simulation.model import Model
from contiga.simulation.outlook import Outlook
from contiga.simulation.output_folder import newest_checkpoint
from contiga.simulation.recorder import Progress, Recorder
from contiga.simulation.result import Result
from contiga.simulation.settling import OnSettle, settled
from contiga.simulation.signals import filtered_columns
from contiga.simulation.step import advance
from contiga.simulation.step_size import following
from contiga.simulation.strict import check_proved
from contiga.simulation.summary import summarise
from contiga.simulation.system_state import SystemState


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
    """Called with what set each step that chose itself."""
    on_slow: Callable[[str], Any] | None = None
    """Called once, where the end is out of reach."""
    on_settle: OnSettle | None = None
    """Called with the number of each step to rest, and the residual after it."""
    settle_only: bool = False
    """End where the run would begin, once all is at rest."""
    now: Callable[[], float] = perf_counter
    """Seconds of the clock that the end is reckoned by."""


def carry_out(model: Model, out: str | Path | None, options: RunOptions) -> Result:
    """Run `model` to its end.

    When the run is stopped (an exception, Ctrl-C) a checkpoint of the last whole step is left;
    before the first one nothing is. Nobody else writes to `out` until the run has ended.
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
            kept: list[SystemState] = []
            outlook = Outlook(model.stepping.end, options.now)
            try:
                if out is not None:
                    recorder.open(Path(out), resume=options.resume)
                state = recorder.state
                while state is None or (
                    state.time < model.stepping.end and not options.settle_only
                ):
                    if state is not None:
                        stepped = following(model, state, clock)
                    elif model.settling is None and not options.settle_only:
                        stepped = advance(model, None, model.stepping.start, clock)
                    else:
                        with clock("settle"):
                            stepped = settled(model, clock, options.on_settle)
                    state = stepped.state
                    if options.strict:
                        check_proved(state)
                    if options.on_pace is not None and stepped.choice is not None:
                        cut = stepped.choice.cut
                        options.on_pace(f"steps of {state.step:.2g}: {cut.said()}")
                    if options.on_slow is not None and (text := outlook.after(stepped)) is not None:
                        options.on_slow(text)
                    recorder.take(stepped)
                    if options.keep is not None and (recorder.done - 1) % options.keep == 0:
                        kept.append(state)
                    if options.on_step is not None:
                        options.on_step(state)
            except OutputError as error:
                with suppress(OutputError):  # of the same full disk: once is enough
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
        shown = (*check_run(model, history, state), *recorder.crest())
        told = together(findings, shown)
        summary = summarise(model, history, clock, told, recorder.ends, state.rest)
        recorder.finish(summary, history)
        if options.on_finish is not None and recorder.folder is not None:
            options.on_finish(recorder.folder)
        if options.strict and shown:
            raise_findings(shown)
        return Result(history, recorder.folder, state, tuple(kept), summary)
    finally:
        recorder.release()
