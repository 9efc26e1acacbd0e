"""A whole run: step by step through the times, with history, fields and checkpoints."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

from contiga.contact.state import State
from contiga.records import FloatArray
from contiga.simulation.clock import Clock
from contiga.simulation.recorder import Progress, Recorder
from contiga.simulation.simulation import (
    BodyPart,
    ContactPart,
    OutputOptions,
    Simulation,
    SlavePart,
)
from contiga.simulation.step import advance
from contiga.simulation.strict import check_proved
from contiga.simulation.summary import summarise

__all__ = [
    "BodyPart",
    "ContactPart",
    "OutputOptions",
    "Result",
    "Simulation",
    "SlavePart",
    "run",
]


class Result(NamedTuple):
    """What a run leaves."""

    history: dict[str, FloatArray]
    """Columns by name, one row a step."""
    out: Path | None
    """Output folder, None where nothing was written."""
    states: dict[str, State]
    """At the end, by contact."""
    summary: dict[str, Any]
    """Counts, timings, statuses: the content of summary.json."""


def run(
    simulation: Simulation,
    out: str | Path | None = None,
    *,
    resume: bool = False,
    strict: bool = False,
    progress: Progress | None = None,
    clock: Clock | None = None,
) -> Result:
    """Carry out a simulation.

    Parameters
    ----------
    simulation : what to run
    out : folder for history, fields, checkpoint and summary; None keeps all in memory
    resume : go on from the checkpoint in `out`; the results are the same bits as of one run
    strict : stop at the first point whose foot or side is not proved
    progress : called with steps done, steps in all, points in contact
    clock : goes on counting from what was spent before (reading, building)

    Raises
    ------
    OutputError
        The folder cannot be written or is somebody else's.
    CheckpointError
        Nothing to resume, or the checkpoint is of another case.
    MissingPackageError
        An output folder is asked for, and h5py is not installed.
    RunError
        With `strict`, a point that is not certified.

    Notes
    -----
    When the run is stopped (an exception, Ctrl-C) a checkpoint of the last whole step is left;
    before the first one nothing is.
    """
    clock = Clock() if clock is None else clock
    with clock.watching(), clock("total"):
        recorder = Recorder(simulation, clock, progress)
        try:
            if out is not None:
                recorder.open(Path(out), resume=resume)
            for k in range(recorder.done, len(simulation.times)):
                moment = advance(simulation, k, recorder.states, clock)
                if strict:
                    check_proved(moment)
                recorder.take(moment)
        except BaseException:
            recorder.save()
            raise
        recorder.save()
    history = recorder.columns()
    summary = summarise(simulation, history, clock)
    recorder.finish(summary)
    return Result(history, recorder.folder, recorder.states, summary)
