"""Convert and plot the history of a run, in memory or from a folder."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from contiga.display import Displayed
from contiga.errors import MissingPackageError
from contiga.extras import require
from contiga.records import FloatArray
from contiga.simulation.figure import plot_history

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame


class HistoryOverTime(Displayed):
    """A history with its summary."""

    history: dict[str, FloatArray]
    summary: dict[str, Any]

    def to_pandas(self) -> DataFrame:
        """Return the history as a pandas DataFrame by time; `attrs["units"]` has its units.

        Raises
        ------
        MissingPackageError
            pandas is not installed.
        """
        table = table_of(f"{type(self).__name__}.to_pandas", self.history)
        table.attrs["units"] = self.summary.get("columns") or {}
        return table

    def plot(
        self,
        *,
        x: str | None = None,
        y: str | Sequence[str] | None = None,
        columns: Sequence[str] | None = None,
        path: str | Path | None = None,
    ) -> Figure:
        """Draw contact forces, penetration, energies, speeds and accelerations over time.

        matplotlib draws without a window; a notebook shows the returned figure.

        Parameters
        ----------
        x, y : channels to draw in place of these, one or several over another, time if omitted:
            columns of the history, ``<body or sensor>.travel``, ``<contact>.strain``
        columns : names of the history to draw over time, a panel for each unit
        path : also write the picture there, in the format of its suffix (.png, .svg, .pdf)

        Raises
        ------
        InputError
            A column or channel that the run does not have, or a suffix of no format.
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
        >>> (axes,) = cg.run(few).plot(x="head_cg.travel", y="head-pad.force").axes
        >>> axes.get_xlabel(), axes.get_ylabel()
        ('head_cg.travel [mm]', 'head-pad.force [N]')
        """
        purpose = f"{type(self).__name__}.plot"
        return plot_history(purpose, self.history, self.summary, columns, path, x=x, y=y)

    def _picture(self) -> bytes | None:
        try:
            figure = plot_history("a picture", self.history, self.summary)
        except MissingPackageError:
            return None
        return figure.png(dpi=72)


def table_of(purpose: str, history: Mapping[str, FloatArray]) -> DataFrame:
    """Return a history as a pandas table by time; `purpose` begins the message about pandas.

    Raises
    ------
    MissingPackageError
        pandas is not installed.
    """
    require(purpose, "pandas")
    from pandas import DataFrame, Index

    columns = {name: values for name, values in history.items() if name != "time"}
    return DataFrame(columns, index=Index(history["time"], name="time"))
