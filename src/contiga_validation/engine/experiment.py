"""What an experiment of the thesis is, and what it gives back."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Cell = str | float | int | None


class Options(NamedTuple):
    """What the user asks of a reproduction."""

    full: bool = False
    """The finest meshes the memory allows, which takes tens of minutes."""
    cad: Path | None = None
    """CAD file of the comparison's third body; one of `data`, or one made, if omitted."""
    data: Path | None = None
    """Folder of public CAD files; none is looked for if omitted."""


class Table(NamedTuple):
    """Numbers, the thesis' own beside ours."""

    key: str
    """Name in tables.csv and tables.json, such as "5.1"."""
    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]
    """One value a column; None where there is none."""


class Picture(NamedTuple):
    """A figure that is drawn when the report is written."""

    key: str
    """Name of its file, such as "5.14"."""
    caption: str
    draw: Callable[[Figure], None]
    size: tuple[float, float] = (6.4, 4.0)
    """Width and height, inch."""


class Claim(NamedTuple):
    """A statement of the thesis (or of ours against it) and whether it held in this run."""

    text: str
    holds: bool
    measured: str
    """What was measured, in words and numbers."""


class Outcome(NamedTuple):
    """What an experiment found."""

    tables: tuple[Table, ...] = ()
    pictures: tuple[Picture, ...] = ()
    claims: tuple[Claim, ...] = ()
    difference: str = ""
    """Why our numbers differ from the thesis', a sentence or two."""


Run = Callable[[], Outcome]


class Experiment(NamedTuple):
    """One experiment of the thesis."""

    key: str
    """Such as "5.4-area"; unique."""
    title: str
    where: str
    """Section, figures and tables of the thesis."""
    run: Run
    thesis: str = ""
    """What the thesis shows or claims there, a sentence or two; where it gives no geometry, what
    scene was designed instead."""

    @property
    def chapter(self) -> int:
        """The number that its key begins with."""
        return int(re.split(r"\D", self.key)[0])


class Experiments(list[Experiment]):
    """The experiments of a module, in the order in which it runs them."""

    def add(self, key: str, title: str, where: str, thesis: str = "") -> Callable[[Run], Run]:
        """Over a function that finds an outcome: the experiment is one of these."""

        def added(run: Run) -> Run:
            self.append(Experiment(key, title, where, run, thesis))
            return run

        return added


class Found(NamedTuple):
    """An experiment, what it found, its pictures as PNG and what it cost."""

    experiment: Experiment
    outcome: Outcome
    pictures: tuple[bytes, ...]
    seconds: float
    """Wall time of the experiment and its pictures, compiling included."""
    compiled: float
    """Seconds of it spent on compiling kernels."""
