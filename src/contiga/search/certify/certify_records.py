"""What the certificates of tracked feet hand each other: records of arrays, made by kernels."""

from __future__ import annotations

from typing import Any, NamedTuple

from numpy.typing import NDArray

from contiga.elements.element_arrays import Elements, Grid
from contiga.records import FloatArray, IndexArray, IntArray

Vector = tuple[float, float, float]


class Near(NamedTuple):
    """What proofs on one side of an edge read of the tables: to hand on all of these costs as much
    as a proof."""

    elements: Elements
    neighbourhoods: FloatArray
    """What is kept around the parts of elements."""
    trimmed: IntArray
    """(patches,) 1 where a patch is trimmed."""
    tolerance: float
    """Length."""


class Bending(NamedTuple):
    """What `bend_bounds` leaves of the cell it was asked for last."""

    derivatives: FloatArray
    """(4, 6) S and its derivatives to the second order in the middle, by parameters that run over
    [-1, 1] in the cell."""
    rest: FloatArray
    """(2, 5) what they depart from that polynomial by over the cell, at most; along the normal."""


class Cells(NamedTuple):
    """The cells about a foot that a proof is made with."""

    here: FloatArray
    """(6,) bounds of the cell about the foot, by `bend_nb`'s names of columns."""
    beyond: FloatArray
    """(6,) those of the cell that goes on across a side or an edge."""
    derivatives: FloatArray
    """(4, 6) work: S and its derivatives somewhere."""
    bending: Bending
    """Of the cell about the foot."""
    bending_beyond: Bending
    boxes: FloatArray
    """(2, 5) element (−1 none), middle s and t, half the cell in s and t: both cells, for which a
    proof holds if nothing is trimmed away from them."""


class EdgeSegment(NamedTuple):
    """The stretches of one edge in a cell, as Bézier curves in its parameters."""

    coefs: FloatArray
    """(stretches, DEGREE, 3) homogeneous x, y, w."""
    degree: IndexArray
    """(stretches,)."""


class EdgeWork(NamedTuple):
    """The cells on both sides of an edge, its edge segment in the first, and a place to search
    into."""

    cells: Cells
    segment: EdgeSegment
    place: FloatArray
    """(4,) what `closest` finds."""


class Principal(NamedTuple):
    """How a surface bends at a place; see `bend_nb.principal`."""

    inner: float
    outer: float
    metric: tuple[float, float, float, float]


class SideFrame(NamedTuple):
    """A place of a crease as one of its faces has it."""

    point: Vector
    tangent: Vector
    across: Vector
    """Unit vector across the crease, into the face."""
    normal: Vector
    bent: Vector
    """Curvature of the crease."""
    principal: Principal
    """Where a tangent vanishes the metric is zero, and the rest means nothing."""


class EdgeFrame(NamedTuple):
    """A place of an edge as one of its faces has it; fields as of `SideFrame`."""

    point: Vector
    tangent: Vector
    across: Vector
    normal: Vector


class Curve(NamedTuple):
    """A stretch of a curve C in a cell, by a parameter that runs over [-1, 1] there."""

    second: Vector
    """C″ in about its middle."""
    change: float
    """How far C″ departs from that at most."""
    slowest: float
    """|C′| at least."""
    bent: float
    """Its largest curvature as a curve in space."""


class Reach(NamedTuple):
    """How far points w of a motion are from a stretch of a crease or an edge."""

    arc: float
    """Its length either way from where it is looked at."""
    far: float
    """|w| on it at most."""
    along: float
    """|w·e| on it at most, e its tangent."""


class EdgeJoint(NamedTuple):
    """How well two faces meet at an edge."""

    width: float
    """Length."""
    slip: float
    """With the next, by how much tangents and normals are uncertain, radians."""
    turn: float


class EdgeFold(NamedTuple):
    """The fold at an edge next to a foot."""

    is_known: bool
    first: EdgeFrame
    second: EdgeFrame
    way: float
    """From the foot to it, length."""
    arc: float
    """Way along it, length, and its curvature."""
    bent: float
    stretches: int
    there: tuple[int, float, float]
    """The place (e, s, t) in the second face."""
    joint: EdgeJoint


class Seen(NamedTuple):
    """A motion P(0) → P(1), as a foot sees it."""

    heights: tuple[float, float]
    """(P − Q)·n of both."""
    far: float
    """The larger distance from the foot."""
    slip: float
    """How far the motion leads along the surface at most, length."""


class Range(NamedTuple):
    """What a number is between."""

    least: float
    largest: float


class TakenOut(NamedTuple):
    """What quick certificates read of the tables of a body."""

    grid: Grid
    table: NDArray[Any]
    """Of the elements."""
    neighbourhoods: FloatArray
    """What is kept around the parts of elements."""
