"""What a coupled run leaves."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from contiga.contact.state import State
from contiga.io.out.history import write_history
from contiga.records import FloatArray
from contiga.shown import Facts, Shown
from contiga.simulation.energy_told import LARGE, energy_text, told_of, worst_step
from contiga.simulation.result import table_of
from contiga.simulation.system_state import Energy

if TYPE_CHECKING:
    from pandas import DataFrame


_CAUSE = (
    "steps may be too long there, or masses, places or velocities were changed by hand, which the "
    "ledger does not see: call start() after that"
)


@dataclass(frozen=True, eq=False, repr=False)
class MujocoResult(Shown):
    """What a coupled run leaves."""

    history: dict[str, FloatArray]
    """Columns by name, one row a step: those of a `Simulation`."""
    contacts: dict[str, State]
    """At the end, by name."""
    energy: Energy
    """At the end."""

    @property
    def warnings(self) -> tuple[str, ...]:
        """What is wrong with the run: energy that is nowhere, above 1 % of the largest."""
        told = told_of(self.history)
        if told["relative"] <= LARGE:
            return ()
        time = float(self.history["time"][worst_step(self.history)])
        return (energy_text(told, time, _CAUSE),)

    def _facts(self) -> Facts:
        return [
            ("steps", len(self.history["time"]) - 1),
            ("end", float(self.history["time"][-1])),
            ("contacts", ", ".join(self.contacts)),
            ("energy error", self.energy.error),
            ("warnings", len(self.warnings)),
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
