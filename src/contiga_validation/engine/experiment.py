"""Records of an experiment of the thesis and of its outcome."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Cell = str | float | int | None


class Options(NamedTuple):
    """Options of a reproduction."""

    full: bool = False
    """Whether to use the finest meshes that memory allows, which takes tens of minutes."""
    cad: Path | None = None
    """CAD file of the comparison's third body; from `data`, or a generated one, if omitted."""
    data: Path | None = None
    """Folder of public CAD files, if any."""


class Table(NamedTuple):
    """A table of numbers of the thesis and of contiga."""

    key: str
    """Name in tables.csv and tables.json, such as "5.1"."""
    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]
    """One value a column, None for an empty cell."""


class Picture(NamedTuple):
    """A figure that is drawn when the report is written."""

    key: str
    """Name of its file, such as "5.14"."""
    caption: str
    draw: Callable[[Figure], None]
    size: tuple[float, float] = (6.4, 4.0)
    """Width and height, inch."""


class Claim(NamedTuple):
    """A statement of the thesis, or of ours about it, and whether it held in this run."""

    text: str
    holds: bool
    measured: str
    """The measurement, in words and numbers."""


class Outcome(NamedTuple):
    """Tables, pictures and claims of an experiment."""

    tables: tuple[Table, ...] = ()
    pictures: tuple[Picture, ...] = ()
    claims: tuple[Claim, ...] = ()
    difference: str = ""
    """Reason why our numbers differ from the thesis."""


Run = Callable[[], Outcome]


class Experiment(NamedTuple):
    """One experiment of the thesis."""

    key: str
    """Unique, such as "5.4-area"."""
    title: str
    where: str
    """Section, figures and tables of the thesis."""
    run: Run
    thesis: str = ""
    """Summary of what the thesis shows or claims there, and, if it gives no geometry, of the scene
    designed instead."""

    @property
    def chapter(self) -> int:
        """Chapter, the first number of the key."""
        return int(re.split(r"\D", self.key)[0])


class Experiments(list[Experiment]):
    """The experiments of a module, in their order."""

    def add(self, key: str, title: str, where: str, thesis: str = "") -> Callable[[Run], Run]:
        """Return a decorator that adds a function that returns an `Outcome` as an experiment."""

        def register(run: Run) -> Run:
            self.append(Experiment(key, title, where, run, thesis))
            return run

        return register


class ExperimentResult(NamedTuple):
    """An experiment with its outcome, its pictures as PNG and its run time."""

    experiment: Experiment
    outcome: Outcome
    pictures: tuple[bytes, ...]
    seconds: float
    """Wall time of the experiment and its pictures, compiling included."""
    compiled: float
    """Seconds of it spent compiling kernels."""
