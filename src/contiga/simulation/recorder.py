"""Keeps what a run makes: history, last states, and on disk fields and checkpoints."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np

from contiga.contact.state import State
from contiga.extras import require
from contiga.io.out.history import write_history
from contiga.records import FloatArray
from contiga.simulation import output_folder as names
from contiga.simulation.checkpoint import Checkpoint, read_checkpoint, write_checkpoint
from contiga.simulation.clock import Clock
from contiga.simulation.fields import Fields, has_outlines
from contiga.simulation.simulation import Simulation
from contiga.simulation.step import Snapshot, history_row

# Seconds from one checkpoint to the next, at least.
CHECKPOINT_SECONDS = 5.0

Progress = Callable[[int, int, int], Any]


class _Stand(NamedTuple):
    """How far a run has come. Replaced as one, so that a stop at any line leaves a whole step."""

    done: int
    """Steps recorded, the start counted."""
    written: int
    """Of them in the fields file."""
    states: dict[str, State]


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
        self._stand = _Stand(0, 0, {})
        self._rows: dict[str, list[float]] = {}
        self._fields: Fields | None = None
        self._made = False
        self._fingerprint = ""
        self._saved = perf_counter()
        self._clock = clock
        self._progress = progress

    @property
    def done(self) -> int:
        """Steps recorded, the start counted."""
        return self._stand.done

    @property
    def states(self) -> dict[str, State]:
        """After the last step recorded, by contact."""
        return self._stand.states

    def open(self, folder: Path, *, resume: bool) -> None:
        """Write to `folder` from now on, or go on from what is there."""
        require("an output folder", "h5py")
        self._fingerprint = self.simulation.fingerprint()
        checkpoint = None
        if resume:
            checkpoint = read_checkpoint(folder / names.CHECKPOINT, self._fingerprint)
        self._made = names.open_folder(folder)
        self.folder = folder
        written = None
        if checkpoint is None:
            names.clear_last_run(folder)
        else:
            self._stand = _Stand(checkpoint.done, checkpoint.written, checkpoint.states)
            self._rows = {name: list(column) for name, column in checkpoint.history.items()}
            written = checkpoint.written
        finished = self.done >= len(self.simulation.times)
        if "vtkhdf" in self.simulation.output.formats and not finished:
            with self._clock("output"):
                files = folder / names.UNFINISHED, folder / names.UNFINISHED_OUTLINES
                self._fields = Fields(self.simulation, *files, written)

    def take(self, snapshot: Snapshot) -> None:
        """Record one step."""
        row = history_row(self.simulation, snapshot)
        done, written, _ = self._stand
        last = done == len(self.simulation.times) - 1
        if self._fields and (last or done % self.simulation.output.every == 0):
            with self._clock("output"):
                self._fields.append(snapshot)
            written += 1
        for name, value in row.items():
            column = self._rows.setdefault(name, [])
            del column[done:]
            column.append(value)
        self._stand = _Stand(done + 1, written, snapshot.states)
        if perf_counter() - self._saved > CHECKPOINT_SECONDS:
            self._checkpoint()
        if self._progress is not None:
            contacts = sum(state.n_contact for state in snapshot.states.values())
            self._progress(self.done, len(self.simulation.times), contacts)

    def columns(self) -> dict[str, FloatArray]:
        """The history so far; counts are whole numbers."""
        return {
            name: np.array(values[: self.done], np.int64 if is_count(name) else np.float64)
            for name, values in self._rows.items()
        }

    def save(self) -> None:
        """Leave a checkpoint of the last whole step; nothing at all where there is none."""
        if self.folder is None:
            return
        if self.done == 0:
            names.clear_last_run(self.folder)
            if self._made:
                with suppress(OSError):
                    self.folder.rmdir()
            return
        self._checkpoint()
        if self._fields is not None:
            self._fields.close()

    def finish(self, summary: dict[str, Any]) -> None:
        """Write what belongs to a run that went through, under its final names."""
        if self.folder is None:
            return
        names.clear_stale(self.folder, self.simulation.output.formats)
        if "csv" in self.simulation.output.formats:
            write_history(self.folder / names.HISTORY, self.columns())
        if self.simulation.case_text:
            names.write_text(self.folder / names.CASE, self.simulation.case_text)
        # Also there where a run was stopped after its last step and goes on from it.
        if (self.folder / names.UNFINISHED).exists():
            (self.folder / names.UNFINISHED).replace(self.folder / names.FIELDS)
            if has_outlines(self.simulation):
                unfinished = self.folder / names.UNFINISHED_OUTLINES
                unfinished.replace(self.folder / names.OUTLINES)
            else:
                (self.folder / names.OUTLINES).unlink(missing_ok=True)
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
                    self._stand.written,
                    self.states,
                    self.columns(),
                ),
            )
            self._saved = perf_counter()


def is_count(column: str) -> bool:
    """Whether a column of the history counts something."""
    return column.rpartition(".")[2].startswith("n_")
