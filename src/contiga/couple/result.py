"""What a coupled run leaves."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from contiga.contact.state import State
from contiga.io.out.history import write_history
from contiga.records import FloatArray
from contiga.shown import Facts, Shown
from contiga.simulation.result import table_of
from contiga.simulation.system_state import Energy

if TYPE_CHECKING:
    from pandas import DataFrame


@dataclass(frozen=True, eq=False, repr=False)
class MujocoResult(Shown):
    """What a coupled run leaves."""

    history: dict[str, FloatArray]
    """Columns by name, one row a step: those of a `Simulation`."""
    contacts: dict[str, State]
    """At the end, by name."""
    energy: Energy
    """At the end."""

    def _facts(self) -> Facts:
        return [
            ("steps", len(self.history["time"]) - 1),
            ("end", float(self.history["time"][-1])),
            ("contacts", ", ".join(self.contacts)),
            ("energy error", self.energy.error),
        ]

    def to_pandas(self) -> DataFrame:
        """The history as a table of pandas, by time.

        Raises
        ------
        MissingPackageError
            pandas is not installed.
        """
        return table_of("MujocoResult.to_pandas", self.history)

    def write(self, path: str | Path) -> None:
        """Write the history as CSV, whole or not at all.

        Raises
        ------
        OutputError
            The file cannot be written.
        """
        write_history(path, self.history)
