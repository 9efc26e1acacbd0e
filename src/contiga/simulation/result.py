"""What a run leaves."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from contiga.display import Displayed, Facts
from contiga.extras import require
from contiga.records import FloatArray
from contiga.simulation.system_state import SystemState

if TYPE_CHECKING:
    from pandas import DataFrame


@dataclass(frozen=True, eq=False, repr=False)
class Result(Displayed):
    """What a run leaves."""

    history: dict[str, FloatArray]
    """Columns by name, one row a step."""
    out: Path | None
    """Output folder, None where nothing was written."""
    state: SystemState
    """At the end."""
    states: tuple[SystemState, ...]
    """Those that were to be kept, in the order of time."""
    summary: dict[str, Any]
    """Counts, timings, statuses: the content of summary.json."""

    def _facts(self) -> Facts:
        return [
            ("steps", len(self.history["time"])),
            ("end", float(self.state.time)),
            ("in contact", self.state.n_contact),
            ("warnings", len(self.summary["warnings"])),
            ("states kept", len(self.states)),
            ("folder", self.out or "none"),
        ]

    def to_pandas(self) -> DataFrame:
        """The history as a table of pandas, by time; `attrs["units"]` has the units of its columns.

        Raises
        ------
        MissingPackageError
            pandas is not installed.
        """
        table = table_of("Result.to_pandas", self.history)
        table.attrs["units"] = self.summary["columns"]
        return table


def table_of(purpose: str, history: Mapping[str, FloatArray]) -> DataFrame:
    """A history as a table of pandas, by time; `purpose` is what the message begins with.

    Raises
    ------
    MissingPackageError
        pandas is not installed.
    """
    require(purpose, "pandas")
    from pandas import DataFrame, Index

    columns = {name: values for name, values in history.items() if name != "time"}
    return DataFrame(columns, index=Index(history["time"], name="time"))
