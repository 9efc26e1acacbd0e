"""Points of a shell that are asked for contact or drawn: x = N q, and Nᵀ f of forces on them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_array

from contiga.arrays.layout import locked
from contiga.arrays.threads import run_ranges
from contiga.jit import straight
from contiga.patches.kernels.point_map_nb import map_rows
from contiga.pointer_records import pass_by_pointer
from contiga.records import FloatArray, IndexArray, IntArray

POINTS = 4000
"""Below so many a second thread does not pay."""


@pass_by_pointer
class SparseRows(NamedTuple):
    """A sparse matrix by its rows (CSR)."""

    starts: IntArray
    """(n + 1,) where rows begin."""
    columns: IntArray
    """(e,)."""
    values: FloatArray
    """(e,)."""

    def times(self, given: FloatArray) -> FloatArray:
        """Return (n, 3) products with `given` (m, 3)."""
        out = np.empty((len(self.starts) - 1, 3))
        rows = locked(np.ascontiguousarray(given, np.float64))
        run_ranges(straight(map_rows), len(out), POINTS, self, rows, out)
        return out

    def at(self, rows: IndexArray) -> SparseRows:
        """Return some of the rows."""
        counts = np.diff(self.starts)[rows]
        starts = np.zeros(len(rows) + 1, np.int32)
        np.cumsum(counts, out=starts[1:])
        entries = np.repeat(self.starts[:-1][rows] - starts[:-1], counts) + np.arange(starts[-1])
        return SparseRows(starts, self.columns[entries], self.values[entries])

    def matrix(self, columns: int) -> csr_array:
        """Return the matrix for SciPy."""
        shape = len(self.starts) - 1, columns
        return csr_array((self.values, self.columns, self.starts), shape=shape)

    def turned(self, columns: int) -> SparseRows:
        """The transpose of a matrix of so many columns, its rows in the order of these."""
        order = np.argsort(self.columns, kind="stable")
        rows = np.repeat(np.arange(len(self.starts) - 1, dtype=np.int32), np.diff(self.starts))
        starts = np.zeros(columns + 1, np.int32)
        np.cumsum(np.bincount(self.columns, minlength=columns), out=starts[1:])
        return SparseRows(starts, rows[order], self.values[order])


class SplinePoints(NamedTuple):
    """Points on a shell, with the area at rest that each stands for."""

    rows: SparseRows
    """N (n, m)."""
    columns: SparseRows
    """Nᵀ (m, n)."""
    along_u: SparseRows
    """S_u (n, m)."""
    along_v: SparseRows
    """S_v (n, m)."""
    measure: FloatArray
    """(n,) area in the parameters; zero of points that are only drawn."""
    weight: FloatArray
    """(n,) area at rest."""
    facets: IntArray
    """(f, 3) triangles between the points of each patch."""

    def points(self, q: FloatArray) -> FloatArray:
        """Return the points N q (n, 3) of control points (m, 3); velocities likewise."""
        return self.rows.times(q)

    def normals(self, q: FloatArray) -> FloatArray:
        """S_u × S_v (n, 3): times `measure` it is the area that a point stands for, as a vector."""
        return np.cross(self.along_u.times(q), self.along_v.times(q))

    def spread(self, f: FloatArray) -> FloatArray:
        """Forces on the points (n, 3) as forces Nᵀ f (m, 3) on control points.

        The work of both is the same, and so are their sum and their moment, as the basis functions
        sum to one.
        """
        return self.columns.times(f)


def sparse_rows(columns: list[IntArray], values: list[FloatArray]) -> SparseRows:
    """A matrix of blocks of rows, each of (n, k) columns and values."""
    counts = np.concatenate([np.full(len(block), block.shape[1]) for block in columns])
    starts = np.zeros(len(counts) + 1, np.int32)
    np.cumsum(counts, out=starts[1:])
    flat = np.concatenate([block.ravel() for block in columns]).astype(np.int32)
    return SparseRows(starts, flat, np.concatenate([block.ravel() for block in values]))


def grid_facets(rows: int, columns: int, first: int) -> IntArray:
    """Return triangles (f, 3) of a grid of points from `first` on; columns run first."""
    corner = first + np.arange(rows * columns, dtype=np.int32).reshape(rows, columns)
    a, b = corner[:-1, :-1].ravel(), corner[1:, :-1].ravel()
    c, d = corner[1:, 1:].ravel(), corner[:-1, 1:].ravel()
    return np.stack([a, b, c, a, c, d], axis=1).reshape(-1, 3)
