"""What a run leaves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from contiga.display import Displayed, Facts
from contiga.extras import require
from contiga.records import FloatArray
from contiga.simulation.figure import plot_history
from contiga.simulation.system_state import SystemState

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame


@dataclass(frozen=True, eq=False, repr=False)
class Result(Displayed):
    """The results of a run: history, states, summary."""

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
        """The history as a pandas DataFrame by time; `attrs["units"]` has the units of its columns.

        Raises
        ------
        MissingPackageError
            pandas is not installed.
        """
        table = table_of("Result.to_pandas", self.history)
        table.attrs["units"] = self.summary["columns"]
        return table

    def plot(
        self, *, columns: Sequence[str] | None = None, path: str | Path | None = None
    ) -> Figure:
        """A figure over time: contact forces, penetration, energies, speeds and accelerations.

        Drawn with matplotlib, without a window; a notebook shows what is returned.

        Parameters
        ----------
        columns : names of the history to draw in place of these, a panel for each unit
        path : also write the picture there, in the format of its suffix (.png, .svg, .pdf)

        Raises
        ------
        InputError
            A column that the history does not have, or a suffix of no format.
        MissingPackageError
            matplotlib is not installed.
        OutputError
            The picture cannot be written.

        Examples
        --------
        >>> import contiga as cg
        >>> few = cg.load_case("case.toml", set={"time.end": 2.0, "time.step": 0.5})
        >>> figure = cg.run(few).plot(path="forces.png")
        >>> [axes.get_ylabel() for axes in figure.axes][:2]
        ['contact force [N]', 'deepest penetration [mm]']
        """
        return plot_history("Result.plot", self.history, self.summary, columns, path)


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
