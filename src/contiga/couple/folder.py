"""The output folder of a coupled run: the files of a Simulation's, and its report."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from contiga.extras import require
from contiga.io.out.files import open_folder, write_json
from contiga.io.out.history import write_history
from contiga.io.out.lock import FolderLock
from contiga.records import FloatArray
from contiga.report import require_packages, write_report
from contiga.simulation import output_folder as names
from contiga.simulation.fields import Fields, has_outlines
from contiga.simulation.model import Model
from contiga.simulation.system_state import SystemState


class CoupledFolder:
    """Takes what is to be written as it comes; `close` it whatever happens.

    Raises
    ------
    OutputError
        The folder is somebody's own, another run writes to it, or it cannot be written.
    MissingPackageError
        What fields or the report are written with is not installed.
    """

    def __init__(self, folder: Path, model: Model) -> None:
        require("an output folder", "h5py")
        require_packages()
        open_folder(folder, names.RUN_FILES, "run")
        self._folder, self._model = folder, model
        self._time = math.nan
        self._lock = FolderLock(folder / names.LOCK, "run")
        unfinished = folder / names.UNFINISHED, folder / names.UNFINISHED_OUTLINES
        try:
            names.clear_last_run(folder)
            names.clear_killed(folder)
            self._fields = Fields(model, *unfinished)
        except BaseException:
            self._lock.release()
            raise

    def append(self, state: SystemState) -> None:
        """Write the fields of one step, once."""
        if state.time != self._time:
            self._fields.append(state)
            self._time = state.time

    def finish(self, history: dict[str, FloatArray], summary: dict[str, Any]) -> None:
        """Write all under its final names, and the report."""
        self._fields.close()
        names.clear_stale(self._folder, ("csv", "vtkhdf"))
        write_history(self._folder / names.HISTORY, history, summary["columns"])
        names.finish_fields(self._folder, outlines=has_outlines(self._model))
        write_json(self._folder / names.SUMMARY, summary)
        write_report(self._folder)

    def close(self) -> None:
        """Let others write to the folder; of a run that failed nothing is left half-written."""
        try:
            if (self._folder / names.UNFINISHED).exists():
                self._fields.close()
                names.clear_last_run(self._folder)
        finally:
            self._lock.release()
