"""Patches as pieces between lines at which their slope may jump, and the edges of pieces."""

from __future__ import annotations

from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.patches.basis import VALUE, Patch, basis_at
from contiga.records import FloatArray, IntArray

EDGES = ("u0", "u1", "v0", "v1")
SAMPLES = 5
"""Points on an edge."""


class Piece(NamedTuple):
    """A part of a patch between lines across which its slope may jump: a patch itself."""

    patch: int
    """Number of the patch it is of."""
    ends: tuple[str, ...]
    """Its edges that lie on edges of the patch, which have the same names."""
    degrees: tuple[int, int]
    knots: tuple[FloatArray, FloatArray]
    control_points: FloatArray
    weights: FloatArray | None
    control: IntArray
    """(n, m) degrees of freedom of its control points."""


class Joint(NamedTuple):
    """Two edges that share their control points, by number of piece and name of edge."""

    pieces: tuple[int, int]
    edges: tuple[str, str]
    turned: bool
    """Whether the second runs the other way."""


class Edge(NamedTuple):
    """An edge of a patch as a curve, its knots from 0 to 1 and its first weight one."""

    degree: int
    knots: FloatArray
    points: FloatArray
    weights: FloatArray
    samples: FloatArray
    """(SAMPLES, 3) on it."""

    def turned(self) -> Edge:
        """The other way round."""
        weights = self.weights[::-1] / self.weights[-1]
        return Edge(
            self.degree, 1.0 - self.knots[::-1], self.points[::-1], weights, self.samples[::-1]
        )


def edge_of(patch: Patch, name: str) -> Edge:
    """An edge of a patch by its name."""
    axis = 1 if name[0] == "u" else 0  # along which the edge runs
    knots = np.asarray(patch.knots[axis])
    low, high = knots[0], knots[-1]
    points = rows_from(patch.control_points, name)[0]
    weights = np.ones(len(points))
    if patch.weights is not None:
        weights = rows_from(patch.weights, name)[0]
    along = np.linspace(low, high, SAMPLES)
    samples = basis_at(patch, edge_parameters(patch, name, along)).of(
        VALUE, patch.control_points.reshape(-1, 3)
    )
    return Edge(
        patch.degrees[axis], (knots - low) / (high - low), points, weights / weights[0], samples
    )


def pieces_of(patch: Patch, number: int, first: int) -> list[Piece]:
    """Cut a patch along knots whose multiplicity is its degree.

    Control points are counted from `first` on.
    """
    n, m = patch.control_points.shape[:2]
    control = first + np.arange(n * m, dtype=np.int32).reshape(n, m)
    points = np.asarray(patch.control_points, np.float64)
    factors = None if patch.weights is None else np.asarray(patch.weights, np.float64)
    along, across = (
        _cuts(np.asarray(knots), p) for knots, p in zip(patch.knots, patch.degrees, strict=True)
    )
    found = []
    for i, (rows, U_knots) in enumerate(along):
        for j, (columns, V_knots) in enumerate(across):
            outer = i == 0, i == len(along) - 1, j == 0, j == len(across) - 1
            piece = Piece(
                number,
                tuple(name for name, is_outer in zip(EDGES, outer, strict=True) if is_outer),
                patch.degrees,
                (U_knots, V_knots),
                points[rows, columns],
                None if factors is None else factors[rows, columns],
                control[rows, columns],
            )
            found.append(piece)
    return found


def _cuts(knots: FloatArray, degree: int) -> list[tuple[slice, FloatArray]]:
    """The control points along one direction and the knots of each piece.

    A line of degree 1 is not cut: it has no slope to keep, and does not bend.
    """
    breaks, times = np.unique(knots, return_counts=True)
    inner = (times >= degree) & (breaks > knots[0]) & (breaks < knots[-1])
    cuts = breaks[inner] if degree > 1 else breaks[:0]
    ends = np.concatenate([knots[:1], cuts, knots[-1:]])
    found = []
    for low, high in pairwise(ends):
        between = knots[(knots > low) & (knots < high)]
        start = max(int(np.searchsorted(knots, low)) - 1, 0)
        count = len(between) + degree + 1
        whole = np.concatenate([np.full(degree + 1, low), between, np.full(degree + 1, high)])
        found.append((slice(start, start + count), whole))
    return found


def edge_parameters(patch: Patch, name: str, along: FloatArray) -> FloatArray:
    """Return (k, 2) parameters on an edge, of those along it (k,)."""
    axis = 0 if name[0] == "u" else 1
    end = patch.knots[axis][0 if name[1] == "0" else -1]
    uv = np.empty((len(along), 2))
    uv[:, axis], uv[:, 1 - axis] = end, along
    return uv


def rows_from(net: NDArray[Any], name: str) -> NDArray[Any]:
    """Rows of a net (n, m, …) parallel to an edge, from it on."""
    rows = net if name[0] == "u" else np.swapaxes(net, 0, 1)
    return rows if name[1] == "0" else rows[::-1]
