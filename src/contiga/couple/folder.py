"""Write the output folder of a coupled run: the files of a simulation, and a report."""

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
    """The output folder of a coupled run; it must be closed in any case.

    It is made and locked, and checkpoints and unfinished files of an earlier run are removed.

    Raises
    ------
    OutputError
        The folder has other files, another run writes to it, or it cannot be written.
    MissingPackageError
        A package for fields or the report is not installed.
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
        """Write the fields of a step, unless the last fields are of the same time."""
        if state.time != self._time:
            self._fields.append(state)
            self._time = state.time

    def finish(self, history: dict[str, FloatArray], summary: dict[str, Any]) -> None:
        """Write all files under their final names, and the report, in place of an earlier one."""
        self._fields.close()
        names.clear_stale(self._folder, ("csv", "vtkhdf"))
        write_history(self._folder / names.HISTORY, history, summary["columns"])
        names.finish_fields(self._folder, outlines=has_outlines(self._model))
        write_json(self._folder / names.SUMMARY, summary)
        write_report(self._folder)

    def close(self) -> None:
        """Release the folder; remove unfinished files, which only a run that failed leaves."""
        try:
            if (self._folder / names.UNFINISHED).exists():
                self._fields.close()
                names.clear_last_run(self._folder)
        finally:
            self._lock.release()
