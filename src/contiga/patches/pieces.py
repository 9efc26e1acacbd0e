"""Pieces of patches between lines at which the slope may jump, and the edges of pieces."""

from __future__ import annotations

from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.patches.basis import VALUE, Patch, basis_at
from contiga.records import FloatArray, IntArray

EDGES = ("u0", "u1", "v0", "v1")
N_SAMPLES = 5
"""Samples of an edge."""


class Piece(NamedTuple):
    """A part of a patch between lines across which its slope may jump; itself a patch."""

    patch: int
    """Number of its patch."""
    ends: tuple[str, ...]
    """Its edges on edges of the patch, which have the same names."""
    degrees: tuple[int, int]
    knots: tuple[FloatArray, FloatArray]
    """Clamped, with the parameters of the patch."""
    control_points: FloatArray
    """(n, m, 3)."""
    weights: FloatArray | None
    """(n, m), or None for a B-spline."""
    control: IntArray
    """(n, m) degrees of freedom of its control points."""


class Joint(NamedTuple):
    """Two edges that share their control points, by number of piece and name of edge."""

    pieces: tuple[int, int]
    """Numbers of the pieces; the same one twice if it is joined with itself."""
    edges: tuple[str, str]
    """Names of the edges, of `EDGES`."""
    turned: bool
    """Whether the two edges run in opposite directions."""


class Edge(NamedTuple):
    """An edge of a patch as a curve, its knots from 0 to 1 and its first weight one."""

    degree: int
    knots: FloatArray
    """(n + degree + 1,) clamped, from 0 to 1."""
    points: FloatArray
    """(n, 3) control points."""
    weights: FloatArray
    """(n,) over the first of them; ones for a B-spline."""
    samples: FloatArray
    """(N_SAMPLES, 3) points of the curve."""

    def reversed(self) -> Edge:
        """Return the same edge in the opposite direction."""
        weights = self.weights[::-1] / self.weights[-1]
        return Edge(
            self.degree, 1.0 - self.knots[::-1], self.points[::-1], weights, self.samples[::-1]
        )


def edge_of(patch: Patch, name: str) -> Edge:
    """Return an edge of a patch as a curve, in the direction of rising u or v."""
    axis = 1 if name[0] == "u" else 0  # along which the edge runs
    knots = np.asarray(patch.knots[axis])
    low, high = knots[0], knots[-1]
    points = rows_from(patch.control_points, name)[0]
    weights = np.ones(len(points))
    if patch.weights is not None:
        weights = rows_from(patch.weights, name)[0]
    t = np.linspace(low, high, N_SAMPLES)
    samples = basis_at(patch, edge_parameters(patch, name, t)).of(
        VALUE, patch.control_points.reshape(-1, 3)
    )
    return Edge(
        patch.degrees[axis], (knots - low) / (high - low), points, weights / weights[0], samples
    )


def pieces_of(patch: Patch, number: int, first: int) -> list[Piece]:
    """Cut a patch along inner knots of a multiplicity of at least its degree.

    A direction of degree 1 is not cut. Pieces are in the order of u, then v; those of a patch
    without such knots are the patch alone. Control points of the patch are numbered from `first`
    on, row by row, and pieces share the numbers along their cuts.
    """
    n, m = patch.control_points.shape[:2]
    control = first + np.arange(n * m, dtype=np.int32).reshape(n, m)
    points = np.asarray(patch.control_points, np.float64)
    factors = None if patch.weights is None else np.asarray(patch.weights, np.float64)
    in_u, in_v = (
        _cuts(np.asarray(knots), p) for knots, p in zip(patch.knots, patch.degrees, strict=True)
    )
    pieces = []
    for i, (rows, U_knots) in enumerate(in_u):
        for j, (columns, V_knots) in enumerate(in_v):
            outer = i == 0, i == len(in_u) - 1, j == 0, j == len(in_v) - 1
            piece = Piece(
                number,
                tuple(name for name, is_outer in zip(EDGES, outer, strict=True) if is_outer),
                patch.degrees,
                (U_knots, V_knots),
                points[rows, columns],
                None if factors is None else factors[rows, columns],
                control[rows, columns],
            )
            pieces.append(piece)
    return pieces


def _cuts(knots: FloatArray, degree: int) -> list[tuple[slice, FloatArray]]:
    """Return the slice of control points and the clamped knots of each piece along one direction.

    A direction of degree 1 is not cut: it has no slope to keep, and does not bend.
    """
    breaks, times = np.unique(knots, return_counts=True)
    inner = (times >= degree) & (breaks > knots[0]) & (breaks < knots[-1])
    cuts = breaks[inner] if degree > 1 else breaks[:0]
    ends = np.concatenate([knots[:1], cuts, knots[-1:]])
    pieces = []
    for low, high in pairwise(ends):
        inside = knots[(knots > low) & (knots < high)]
        start = max(int(np.searchsorted(knots, low)) - 1, 0)
        count = len(inside) + degree + 1
        clamped = np.concatenate([np.full(degree + 1, low), inside, np.full(degree + 1, high)])
        pieces.append((slice(start, start + count), clamped))
    return pieces


def edge_parameters(patch: Patch, name: str, t: FloatArray) -> FloatArray:
    """Return (k, 2) parameters of the patch at parameters (k,) of an edge."""
    axis = 0 if name[0] == "u" else 1
    end = patch.knots[axis][0 if name[1] == "0" else -1]
    uv = np.empty((len(t), 2))
    uv[:, axis], uv[:, 1 - axis] = end, t
    return uv


def rows_from(net: NDArray[Any], name: str) -> NDArray[Any]:
    """Return the rows of a net (n, m, …) parallel to an edge, starting at it."""
    rows = net if name[0] == "u" else np.swapaxes(net, 0, 1)
    return rows if name[1] == "0" else rows[::-1]
