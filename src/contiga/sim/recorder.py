"""Keeps what a run makes: history, last states, and on disk fields and checkpoints."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from contiga.io.history import write_history
from contiga.records import FloatArray
from contiga.sim import folder as names
from contiga.sim.checkpoint import Checkpoint, read_checkpoint, write_checkpoint
from contiga.sim.clock import Clock
from contiga.sim.fields import Fields
from contiga.sim.simulation import Simulation
from contiga.sim.state import State
from contiga.sim.step import Moment, history_row

# Seconds from one checkpoint to the next, at least.
CHECKPOINT_SECONDS = 5.0

Progress = Callable[[int, int, int], Any]


class Recorder:
    """Takes the steps of a run as they come.

    Parameters
    ----------
    simulation : what is run
    clock : times the output
    progress : called with steps done, steps in all, points in contact
    """

    def __init__(self, simulation: Simulation, clock: Clock, progress: Progress | None) -> None:
        self.simulation = simulation
        self.folder: Path | None = None
        self.states: dict[str, State] = {}
        self.done = 0
        self._rows: dict[str, list[float]] = {}
        self._fields: Fields | None = None
        self._fingerprint = ""
        self._saved = perf_counter()
        self._clock = clock
        self._progress = progress

    def open(self, folder: Path, *, resume: bool) -> None:
        """Write to `folder` from now on, or go on from what is there."""
        self._fingerprint = self.simulation.fingerprint()
        checkpoint = None
        if resume:
            checkpoint = read_checkpoint(folder / names.CHECKPOINT, self._fingerprint)
        self.folder = names.open_folder(folder)
        written = None
        if checkpoint is None:
            names.clear_last_run(folder)
        else:
            self.states = checkpoint.states
            self.done = checkpoint.done
            self._rows = {name: list(column) for name, column in checkpoint.history.items()}
            written = checkpoint.written
        finished = self.done >= len(self.simulation.times)
        if "vtkhdf" in self.simulation.output.formats and not finished:
            with self._clock("output"):
                self._fields = Fields(self.simulation, folder / names.UNFINISHED, written)

    def take(self, moment: Moment) -> None:
        """Record one step."""
        for name, value in history_row(self.simulation, moment).items():
            self._rows.setdefault(name, []).append(value)
        self.states = moment.states
        with self._clock("output"):
            last = self.done == len(self.simulation.times) - 1
            if self._fields and (last or self.done % self.simulation.output.every == 0):
                self._fields.append(moment)
        self.done += 1
        if perf_counter() - self._saved > CHECKPOINT_SECONDS:
            self._checkpoint()
        if self._progress is not None:
            contacts = sum(state.n_contact for state in moment.states.values())
            self._progress(self.done, len(self.simulation.times), contacts)

    def columns(self) -> dict[str, FloatArray]:
        """The history so far; counts are whole numbers."""
        return {
            name: np.array(values, dtype=np.int64 if is_count(name) else np.float64)
            for name, values in self._rows.items()
        }

    def save(self) -> None:
        """Leave a checkpoint of the last whole step and close the fields."""
        if self.folder is None or self.done == 0:
            return
        self._checkpoint()
        if self._fields is not None:
            self._fields.close()

    def finish(self, summary: dict[str, Any]) -> None:
        """Write what belongs to a run that went through, under its final names."""
        if self.folder is None:
            return
        if "csv" in self.simulation.output.formats:
            write_history(self.folder / names.HISTORY, self.columns())
        if self.simulation.case_text:
            names.write_text(self.folder / names.CASE, self.simulation.case_text)
        if self._fields is not None:
            (self.folder / names.UNFINISHED).replace(self.folder / names.FIELDS)
        names.write_json(self.folder / names.SUMMARY, summary)

    def _checkpoint(self) -> None:
        if self.folder is None:
            return
        with self._clock("output"):
            if self._fields is not None:
                self._fields.flush()
            write_checkpoint(
                self.folder / names.CHECKPOINT,
                Checkpoint(
                    self._fingerprint,
                    self.done,
                    0 if self._fields is None else self._fields.written,
                    self.states,
                    self.columns(),
                ),
            )
            self._saved = perf_counter()


def is_count(column: str) -> bool:
    """Whether a column of the history counts something."""
    return column.rpartition(".")[2].startswith("n_")
