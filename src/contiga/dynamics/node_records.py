"""What kernels of nodes are told, and what they write."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.pointer_records import pass_by_pointer
from contiga.records import FloatArray, IndexArray


@pass_by_pointer
class Masses(NamedTuple):
    """Nodes that forces move."""

    mass: FloatArray
    """(n,)."""
    held: NDArray[np.bool_]
    """(n, 3) ways that no force moves; (0, 3) where there are none."""
    led: NDArray[np.bool_]
    """(n, 3) ways in which motions or bodies have them; (0, 3) where there are none."""


@pass_by_pointer
class Acting(NamedTuple):
    """Forces on nodes, (n, 3) each, (0, 3) of those there are none of."""

    rows: IndexArray
    """(k,) nodes on which contacts act, ascending."""
    contacts: FloatArray
    """(k, 3) of contacts."""
    elements: FloatArray
    loads: FloatArray
    drag: FloatArray
    gravity: FloatArray
    """(3,) an acceleration."""


@pass_by_pointer
class Course(NamedTuple):
    """Where nodes are, and their velocities."""

    points: FloatArray
    """(n, 3)."""
    velocities: FloatArray
    """(n, 3)."""


@pass_by_pointer
class Drifted(NamedTuple):
    """Nodes a step on, (n, 3) each."""

    points: FloatArray
    velocities: FloatArray
    """Foreseen at the end of the step: what half a kick more gives."""
    half: FloatArray
    """Velocities of its middle."""


@pass_by_pointer
class Kick(NamedTuple):
    """What the second half of a step's kick begins from."""

    half: FloatArray
    """(n, 3) velocities of the middle of the step."""
    foreseen: FloatArray
    """(n, 3) velocities at its end, by the forces at its start; of what is led as it is led."""
    dt: float
    damping: float
    """α of a force −α m v, 1/time."""


@pass_by_pointer
class Kicked(NamedTuple):
    """What it leaves."""

    velocities: FloatArray
    """(n, 3)."""
    energy: FloatArray
    """(b,) ½ Σ m v₋·v₊ of the middles of the steps before and after, of what forces move."""
