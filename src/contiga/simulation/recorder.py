"""Record a run: its history and last states in memory, fields and checkpoints on disk."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from contextlib import suppress
from math import floor
from pathlib import Path
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np

from contiga.dynamics.stepping import AutoSteps
from contiga.errors import ContigaWarning
from contiga.extras import require
from contiga.io.out.files import open_folder, write_json, write_text
from contiga.io.out.full_disk import check_room
from contiga.io.out.history import write_history
from contiga.io.out.lock import FolderLock
from contiga.records import FloatArray
from contiga.simulation import output_folder as names
from contiga.simulation.checkpoint import (
    Checkpoint,
    Onward,
    Peak,
    read_checkpoint,
    write_checkpoint,
)
from contiga.simulation.checks.finding import Finding
from contiga.simulation.checks.run_checks import check_crest
from contiga.simulation.clock import Clock
from contiga.simulation.fields import Fields, has_outlines
from contiga.simulation.fingerprint import identity_of
from contiga.simulation.history import (
    history_row,
    measured_columns,
    total_force,
    unmeasured_names,
)
from contiga.simulation.model import Model
from contiga.simulation.step import StepResult
from contiga.simulation.summary import summary_so_far
from contiga.simulation.system_state import SystemState

# Minimum seconds from one checkpoint to the next.
CHECKPOINT_SECONDS = 5.0
_TIME_TOL = 1e-9
"""Share of an interval by which a time may fall short of its end."""
_BYTES_PER_POINT = 2000
"""Bytes per point of a state and the state at the peak in a checkpoint."""

Progress = Callable[[int, int, int], Any]


class _Record(NamedTuple):
    """The recorded part of a run.

    The record is replaced as a whole, so that a stop at any line leaves complete steps.
    """

    done: int
    """Steps recorded, the start counted."""
    written: int
    """Number of these with measured areas, which are in the fields file if there is one."""
    state: SystemState | None
    """State after the last of them."""
    peak: Peak = Peak()
    """The greatest force so far."""
    crest: SystemState | None = None
    """State at the greatest force, if it came since the run began or was resumed."""
    onward: Onward | None = None
    """At the end of the run: values for a run that goes on beyond it."""


class Recorder:
    """The recorder of a run, called after each step.

    Parameters
    ----------
    model : the model that is run
    clock : times the output
    progress : called with steps done, steps in all, points in contact
    """

    def __init__(self, model: Model, clock: Clock, progress: Progress | None) -> None:
        self.model = model
        self._planned = len(model.stepping.planned())
        self.folder: Path | None = None
        self._record = _Record(0, 0, None)
        self._rows: dict[str, list[float]] = {}
        self._old_findings: tuple[Finding, ...] = ()
        self._ends: tuple[float, ...] = ()
        self._fields: Fields | None = None
        self._lock: FolderLock | None = None
        self._made_folder = False
        self._fingerprint = ""
        self._last_checkpoint = perf_counter()
        self._clock = clock
        self._progress = progress

    @property
    def done(self) -> int:
        """Steps recorded, the start counted."""
        return self._record.done

    @property
    def state(self) -> SystemState | None:
        """The state after the last step recorded."""
        return self._record.state

    @property
    def ends(self) -> tuple[float, ...]:
        """Earlier ends of the run whose steps differ from those of a single run."""
        return self._ends

    def open(self, folder: Path, *, resume: bool) -> None:
        """Write to `folder` from now on; with `resume`, go on from its newest checkpoint.

        The folder is made and locked; without `resume` files of an earlier run are removed.

        Raises
        ------
        CheckpointError
            Nothing in the folder can be resumed by this model.
        OutputError
            The folder has other files, another run writes to it, or it cannot be written.
        MissingPackageError
            h5py is not installed.

        Warns
        -----
        ContigaWarning
            Compiled code affects the results, and cannot be compared with that of the checkpoint.
        """
        require("an output folder", "h5py")
        self._fingerprint, unknown = identity_of(self.model)
        checkpoint = None
        if resume:
            checkpoint = read_checkpoint(names.newest_checkpoint(folder), self.model)
            for name in unknown:
                text = f"{name} is compiled: whether it is what it was before cannot be known"
                warnings.warn(text, ContigaWarning, stacklevel=6)
        self._made_folder = open_folder(folder, names.RUN_FILES, "run")
        self._lock = FolderLock(folder / names.LOCK, "run")
        self.folder = folder
        names.clear_killed(folder)
        if checkpoint is None:
            names.clear_last_run(folder)
        else:
            # Continue from the checkpoint; beyond the end of its run, as if that were no end.
            done, stepping = checkpoint.done, self.model.stepping
            self._rows = {name: list(column) for name, column in checkpoint.history.items()}
            self._ends, self._old_findings = checkpoint.ends, checkpoint.crest
            steps, peak, onward = checkpoint.written, checkpoint.peak, checkpoint.onward
            if checkpoint.end < stepping.end:
                same = stepping.planned()[done - 1 : done] == checkpoint.state.time
                if isinstance(stepping, AutoSteps) or not same.all():
                    self._ends += (checkpoint.end,)
                if onward is not None:
                    steps, peak = onward.written, onward.peak
                    for name in unmeasured_names(self.model):
                        for row in onward.unmeasured:
                            self._rows[name][row] = np.nan
                    onward = None
            self._record = _Record(done, steps, checkpoint.state, peak, None, onward)
        finished = self.state is not None and self._is_last(self.state)
        if "vtkhdf" in self.model.output.formats and not finished:
            with self._clock("output"):
                if checkpoint is not None:
                    names.reopen_fields(folder, outlines=has_outlines(self.model))
                files = folder / names.UNFINISHED, folder / names.UNFINISHED_OUTLINES
                written = None if checkpoint is None else self._record.written
                self._fields = Fields(self.model, *files, written)
        if checkpoint is not None and checkpoint.end < self.model.stepping.end:
            # The fields may be of fewer steps now than the old checkpoint says.
            self._checkpoint()

    def _is_last(self, state: SystemState) -> bool:
        return state.time >= self.model.stepping.end

    def take(self, stepped: StepResult) -> None:
        """Record one step: a row of the history, and its fields if they are due or it is the last.

        Before its fields, those of the greatest force so far are written, if they were not yet. Of
        a last step that is not due, the record keeps the values that a run beyond that end would
        have. A checkpoint follows if the last is `CHECKPOINT_SECONDS` old; then `progress` is
        called.
        """
        state = stepped.state
        done, n_written = self._record.done, self._record.written
        peak, crest = self._record.peak, self._record.crest
        # Whether fields of this step are written: by steps or by time.
        output, before = self.model.output, self.state
        is_due = self.done % output.every == 0
        if output.interval is not None and before is not None:
            start, times = self.model.stepping.start, (before.time, state.time)
            intervals = [floor((t - start) / output.interval + _TIME_TOL) for t in times]
            is_due = intervals[1] > intervals[0]
        is_recorded = self._is_last(state) or is_due
        with self._clock("area"):
            row = history_row(self.model, stepped, self.state, measured=is_recorded)
        force = total_force(self.model, row)
        onward = None
        if is_recorded and not is_due:
            pending_peak = peak.after(state, force, done, written=False)
            rows = (done,) if pending_peak.state is None else (pending_peak.row, done)
            onward = Onward(n_written, pending_peak, rows)
        peak = peak.after(state, force, done, written=is_recorded)
        crest = state if peak.row == done else crest
        if is_recorded:
            if peak.state is not None:
                # Contact areas were not measured in that step.
                with self._clock("area"):
                    measured = measured_columns(self.model, peak.state)
                for name, value in measured.items():
                    self._rows[name][peak.row] = value
                self._write(peak.state)
                peak, n_written = peak._replace(state=None), n_written + 1
            self._write(state)
            n_written += 1
        for name, value in row.items():
            column = self._rows.get(name)
            if column is None:
                column = self._rows[name] = []
            elif len(column) > done:
                del column[done:]
            column.append(value)
        self._record = _Record(done + 1, n_written, state, peak, crest, onward)
        if perf_counter() - self._last_checkpoint > CHECKPOINT_SECONDS:
            self._checkpoint()
        if self._progress is not None:
            # Steps done of those planned; for automatic steps the share of the time.
            n_done, stepping = self.done, self.model.stepping
            if isinstance(stepping, AutoSteps):
                share = (state.time - stepping.start) / (stepping.end - stepping.start)
                n_done = 1 + round(share * (self._planned - 1))
            self._progress(n_done, self._planned, state.n_contact)

    def crest(self) -> tuple[Finding, ...]:
        """Return findings about the model from the step with the greatest force."""
        crest = self._record.crest
        return self._old_findings if crest is None else check_crest(self.model, crest)

    def _write(self, state: SystemState) -> None:
        """Write fields, if the run has them; raise `OutputError` if the disk has no room."""
        if self._fields is not None and self.folder is not None:
            with self._clock("output"):
                # A checkpoint has the history, the state, and the state at the peak.
                points = sum(len(part.slave) for part in self.model.slaves.values())
                room = self._fields.n_bytes + 8 * (self.done + 1) * len(self._rows)
                check_room(self.folder / names.UNFINISHED, room + _BYTES_PER_POINT * points)
                self._fields.append(state)

    def columns(self) -> dict[str, FloatArray]:
        """Return the history so far as new arrays; counts are whole numbers (`as_column`)."""
        return {name: as_column(name, values[: self.done]) for name, values in self._rows.items()}

    def save(self) -> None:
        """Close the fields, and write a checkpoint of the last complete step, if there is one.

        Without any checkpoint in the folder its files are removed, and also the folder if it was
        made for this run.

        Raises
        ------
        OutputError
            The disk is full. Earlier files stay if a run can be resumed from them.
        """
        if self.folder is None:
            return
        try:
            if self._fields is not None:
                self._fields.close()  # else they could be neither removed nor renamed everywhere
        finally:
            try:
                if self.done:
                    self._checkpoint(stopped=True)
            finally:
                if not names.newest_checkpoint(self.folder).is_file():
                    # A run that cannot be resumed leaves no files.
                    names.clear_last_run(self.folder)
                    if self._made_folder:
                        self.release()
                        with suppress(OSError):
                            self.folder.rmdir()

    def release(self) -> None:
        """Release the folder's lock."""
        if self._lock is not None:
            self._lock.release()

    def finish(self, summary: dict[str, Any], history: dict[str, FloatArray]) -> None:
        """Write the files of a complete run under their final names, if it has a folder.

        Stale files of an earlier run and the checkpoint before the last are removed.
        """
        if self.folder is None:
            return
        names.clear_stale(self.folder, self.model.output.formats)
        if "csv" in self.model.output.formats:
            write_history(self.folder / names.HISTORY, history, summary["columns"])
        if self.model.case_text:
            write_text(self.folder / names.CASE, self.model.case_text)
        # Also needed if a run was stopped after its last step, or killed here, and is resumed.
        names.finish_fields(self.folder, outlines=has_outlines(self.model))
        write_json(self.folder / names.SUMMARY, summary)
        (self.folder / names.CHECKPOINT_BEFORE).unlink(missing_ok=True)

    def _checkpoint(self, *, stopped: bool = False) -> None:
        """Write a checkpoint of the last step recorded, if there are a folder and a step.

        Fields are flushed first. The older checkpoint is kept beside it.
        """
        if self.folder is None or self.state is None:
            return
        history = self.columns()
        with self._clock("output"):
            if self._fields is not None:
                self._fields.flush()
            write_checkpoint(
                self.folder / names.CHECKPOINT,
                Checkpoint(
                    self._fingerprint,
                    self.model.stepping.end,
                    self._ends,
                    self.done,
                    self._record.written,
                    self.state,
                    history,
                    self._record.peak,
                    self.crest(),
                    self._record.onward,
                ),
                summary_so_far(self.model, history, self._clock, stopped=stopped),
                before=self.folder / names.CHECKPOINT_BEFORE,
            )
            self._last_checkpoint = perf_counter()


def as_column(name: str, values: list[float]) -> FloatArray:
    """Return a column of the history: of whole numbers, if it counts and all values are finite."""
    column = np.array(values, np.float64)
    return column.astype(np.int64) if is_count(name) and np.isfinite(column).all() else column


def is_count(column: str) -> bool:
    """Return whether a column of the history counts something."""
    return column.rpartition(".")[2].startswith("n_")
