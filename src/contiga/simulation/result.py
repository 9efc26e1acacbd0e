"""Hold the results of a run."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from contiga.display import Facts
from contiga.errors import InputError
from contiga.records import FloatArray
from contiga.simulation.history_over_time import HistoryOverTime
from contiga.simulation.stored_result import open_result
from contiga.simulation.system_state import SystemState

if TYPE_CHECKING:
    import pyvista


@dataclass(frozen=True, eq=False, repr=False)
class Result(HistoryOverTime):
    """The results of a run: history, states, summary."""

    history: dict[str, FloatArray]
    """Columns by name, one row a step."""
    out: Path | None
    """Output folder; None without one."""
    state: SystemState
    """State at the end."""
    states: tuple[SystemState, ...]
    """States kept by the option `keep`, in order of time."""
    summary: dict[str, Any]
    """Counts, timings, statuses: the content of summary.json."""

    def to_pyvista(self, time: float | None = None) -> pyvista.MultiBlock:
        """Return the recorded step nearest to `time`, from the output folder: see `StoredResult`.

        Raises
        ------
        InputError
            The run has no output folder, or no fields.
        MissingPackageError
            pyvista is not installed.
        """
        if self.out is None:
            raise InputError(
                "the run wrote no fields",
                where="Result.to_pyvista",
                remedy="Give it a folder (out=…), or show a state: simulation.to_pyvista(state)",
            )
        return open_result(self.out).to_pyvista(time)

    def _facts(self) -> Facts:
        return [
            ("steps", len(self.history["time"])),
            ("end", float(self.state.time)),
            ("in contact", self.state.n_contact),
            ("warnings", len(self.summary["warnings"])),
            ("states kept", len(self.states)),
            ("folder", self.out or "none"),
        ]
