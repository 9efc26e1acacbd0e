"""Hold the results of a coupled run."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from contiga.contact.state import State
from contiga.display import Displayed, Facts
from contiga.errors import InputError
from contiga.io.out.history import write_history
from contiga.records import FloatArray
from contiga.simulation.clock import Clock
from contiga.simulation.energy_balance import ERROR_TOL, balance_of, energy_text, worst_step
from contiga.simulation.history_over_time import table_of
from contiga.simulation.model import Model
from contiga.simulation.summary import summarise
from contiga.simulation.system_state import Energy

if TYPE_CHECKING:
    from pandas import DataFrame


_CAUSE = (
    "steps may be too long there, or masses, places or velocities were changed by hand, which the "
    "ledger does not see: call start() after that"
)


@dataclass(frozen=True, eq=False, repr=False)
class MujocoResult(Displayed):
    """The results of a coupled run."""

    history: dict[str, FloatArray]
    """Columns by name, one row per step, as in a `Simulation`."""
    contacts: dict[str, State]
    """Contacts at the end, by name."""
    energy: Energy
    """Energies at the end."""
    criteria: dict[str, dict[str, Any]] = field(default_factory=dict)
    """Results of sensors by name: filter, and criteria with values and time windows."""

    @property
    def warnings(self) -> tuple[str, ...]:
        """Defects of the run: an energy balance error above 1 % of the largest energy."""
        balance = balance_of(self.history)
        if balance["relative"] <= ERROR_TOL:
            return ()
        time = float(self.history["time"][worst_step(self.history)])
        return (energy_text(balance, time, _CAUSE),)

    def of(self, name: str) -> dict[str, FloatArray]:
        """Return the columns of a contact, a body, a sensor or "energy", by their own names.

        The arrays are those of the history, not copies.

        Raises
        ------
        InputError
            The history has nothing of that name.
        """
        columns = {full_name.rpartition("."): values for full_name, values in self.history.items()}
        chosen = {column: values for (of, _, column), values in columns.items() if of == name}
        if not chosen and list(self.contacts) == [name]:  # the only one: not prefixed
            chosen = {column: values for (of, _, column), values in columns.items() if not of}
        if not chosen:
            names = dict.fromkeys(of for of, _, _ in columns if of)
            raise InputError(
                "the history has nothing of this name",
                where="name",
                found=name,
                allowed=", ".join(map(repr, {*self.contacts, *names})),
            )
        return chosen

    def _facts(self) -> Facts:
        return [
            ("steps", len(self.history["time"]) - 1),
            ("end", float(self.history["time"][-1])),
            ("contacts", ", ".join(self.contacts)),
            ("energy error", self.energy.error),
            ("warnings", len(self.warnings)),
        ]

    def to_pandas(self) -> DataFrame:
        """Return the history as a pandas DataFrame by time.

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


def summary_of(result: MujocoResult, model: Model, title: str, seconds: float) -> dict[str, Any]:
    """Return the summary of a coupled run for its folder, with the warnings of `result`.

    `seconds` are the wall-clock time of the run.
    """
    clock = Clock()
    clock.seconds["total"] = seconds
    summary = summarise(model, result.history, clock)
    warnings = [*summary["warnings"], *result.warnings]
    energy = balance_of(result.history)
    return summary | {"title": title, "energy": energy, "warnings": warnings}
