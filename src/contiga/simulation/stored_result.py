"""Read the output folder of a run, during the run and afterwards (`contiga.open_result`)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from contiga.display import Facts
from contiga.errors import InputError, MissingPackageError
from contiga.io.out.iso_mme import write_mme
from contiga.io.out.stored import FIELDS, UNFINISHED, read_stored
from contiga.io.out.vtkhdf import FieldSeries, read_fields
from contiga.records import FloatArray
from contiga.simulation.history_over_time import HistoryOverTime
from contiga.simulation.iso_mme import channels_of
from contiga.simulation.pyvista_scene import scene_of_fields

if TYPE_CHECKING:
    import pyvista


@dataclass(frozen=True, eq=False, repr=False)
class StoredResult(HistoryOverTime):
    """The results in the output folder of a run when `open_result` read them."""

    out: Path
    finished: bool
    """Whether the run has ended; otherwise the results are those of its last checkpoint."""
    history: dict[str, FloatArray]
    """Columns (n,) by name, one row per step; filtered columns only once the run has ended."""
    summary: dict[str, Any]
    """The content of summary.json (counts, timings, statuses, criteria)."""

    @cached_property
    def fields(self) -> FieldSeries | None:
        """Points and fields of the recorded steps, read on first use; None without any.

        `fields.times` (k,), `fields.parts`, `fields.names`, `fields.points(i)` (N, 3) of all parts,
        `fields.data(i, "pressure")` (N,) and `fields.rows("pad")`, the rows of one part.
        """
        path = self.out / (FIELDS if self.finished else UNFINISHED)
        series = read_fields(path) if path.is_file() else None
        return series if series is not None and len(series.times) else None

    @property
    def time(self) -> float:
        """Time of the last step of the history."""
        return float(self.history["time"][-1])

    @property
    def sensors(self) -> dict[str, dict[str, FloatArray]]:
        """Columns (n,) of each sensor: by the name of the sensor, then of the column."""
        names = self.summary.get("sensors") or {}
        return {name: self._columns_of(name) for name in names}

    @property
    def springs(self) -> dict[str, dict[str, FloatArray]]:
        """Columns (n,) of each spring: by the name of the spring, then of the column."""
        return {name: self._columns_of(name) for name in self.summary.get("springs") or {}}

    def _columns_of(self, owner: str) -> dict[str, FloatArray]:
        columns = {name.rpartition("."): values for name, values in self.history.items()}
        return {name: values for (of, _, name), values in columns.items() if of == owner}

    def write_mme(self, folder: str | Path, test: str) -> tuple[Path, int]:
        """Write the measurements of sensors, springs and joints as ISO/TS 13499 (ISO-MME) files.

        Parameters
        ----------
        folder : where the folder of the test is made
        test : its name

        Returns
        -------
        The folder of the test, and how many channels are in it.

        Raises
        ------
        InputError
            The run has no units, or no sensors, springs and joints; codes of two sensors are the
            same.
        OutputError
            The test exists already, or cannot be written.

        Warns
        -----
        ContigaWarning
            Columns that are not finite are left out.
        """
        channels = channels_of(self.history, self.summary)
        title, of = str(self.summary.get("title", "")), f"contiga {self.summary.get('version', '')}"
        return write_mme(Path(folder), test, channels, title=title, comment=of), len(channels)

    def at(self, time: float) -> int:
        """Return the index of the recorded step nearest to a time; 0 without fields."""
        times = np.zeros(1) if self.fields is None else self.fields.times
        return int(np.abs(times - time).argmin())

    def to_pyvista(self, time: float | None = None) -> pyvista.MultiBlock:
        """Return the recorded step nearest to `time`, a block for each body and slave.

        Parameters
        ----------
        time : the last recorded step if omitted

        Raises
        ------
        InputError
            The run recorded no fields.
        MissingPackageError
            pyvista is not installed.
        """
        if self.fields is None:
            raise InputError(
                "the run recorded no fields",
                where=str(self.out),
                remedy='Run it with "vtkhdf" among [output] formats',
            )
        step = len(self.fields.times) - 1 if time is None else self.at(time)
        return scene_of_fields("StoredResult.to_pyvista", self.fields, step)

    def _facts(self) -> Facts:
        try:
            recorded: int | str = 0 if self.fields is None else len(self.fields.times)
        except MissingPackageError:  # h5py, which reads fields
            recorded = "unknown"
        return [
            ("steps", len(self.history["time"])),
            ("time", self.time),
            ("finished", self.finished),
            ("recorded", recorded),
            ("warnings", len(self.summary.get("warnings") or [])),
            ("folder", self.out),
        ]


def open_result(folder: str | Path) -> StoredResult:
    """Open the output folder of a run: history, summary, and fields by time.

    During a run, or after it was stopped (Ctrl-C), the results are those of the last checkpoint,
    which a run writes every few seconds and when it stops.

    Parameters
    ----------
    folder : output folder of a run

    Raises
    ------
    FileError
        There is no such folder, no run in it, or the run has only just begun.

    Examples
    --------
    >>> import contiga as cg
    >>> few = cg.load_case("case.toml", set={"time.end": 2.0, "time.step": 0.5})
    >>> done = cg.run(few, out="few")
    >>> result = open_result("few")
    >>> result.finished, result.time, list(result.sensors), len(result.fields.times)
    (True, 2.0, ['head_cg'], 5)
    >>> result.fields.points(result.at(1.0))[result.fields.rows("head")].shape[1]
    3
    """
    stored = read_stored(folder)
    return StoredResult(stored.folder, stored.finished, stored.history, stored.summary)
