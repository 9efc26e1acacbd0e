"""Points of a shell for contact or pictures: x = N q, and forces Nᵀ f on its control points."""

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

MIN_POINTS = 4000
"""Number of points above which a second thread pays."""


@pass_by_pointer
class SparseRows(NamedTuple):
    """A sparse matrix by its rows (CSR)."""

    starts: IntArray
    """(n + 1,) first entry of each row."""
    columns: IntArray
    """(e,) column of each entry."""
    values: FloatArray
    """(e,) value of each entry."""

    def times(self, vectors: FloatArray) -> FloatArray:
        """Return the products (n, 3) of the rows with `vectors` (m, 3), on several threads."""
        out = np.empty((len(self.starts) - 1, 3))
        columns = locked(np.ascontiguousarray(vectors, np.float64))
        run_ranges(straight(map_rows), len(out), MIN_POINTS, self, columns, out)
        return out

    def at(self, rows: IndexArray) -> SparseRows:
        """Return the matrix of `rows` (k,), in their order."""
        counts = np.diff(self.starts)[rows]
        starts = np.zeros(len(rows) + 1, np.int32)
        np.cumsum(counts, out=starts[1:])
        entries = np.repeat(self.starts[:-1][rows] - starts[:-1], counts) + np.arange(starts[-1])
        return SparseRows(starts, self.columns[entries], self.values[entries])

    def matrix(self, columns: int) -> csr_array:
        """Return the rows as a SciPy `csr_array` with `columns` columns; the arrays are shared."""
        shape = len(self.starts) - 1, columns
        return csr_array((self.values, self.columns, self.starts), shape=shape)

    def turned(self, columns: int) -> SparseRows:
        """Return the transpose of the matrix, which has as many `columns`.

        Entries of a new row are in the ascending order of the old rows.
        """
        order = np.argsort(self.columns, kind="stable")
        rows = np.repeat(np.arange(len(self.starts) - 1, dtype=np.int32), np.diff(self.starts))
        starts = np.zeros(columns + 1, np.int32)
        np.cumsum(np.bincount(self.columns, minlength=columns), out=starts[1:])
        return SparseRows(starts, rows[order], self.values[order])


class SplinePoints(NamedTuple):
    """Points on a shell with their nodal areas at rest."""

    rows: SparseRows
    """N (n, m)."""
    columns: SparseRows
    """Nᵀ (m, n)."""
    along_u: SparseRows
    """N_u (n, m), so that S_u = N_u q."""
    along_v: SparseRows
    """N_v (n, m)."""
    measure: FloatArray
    """(n,) area in the parameters, du dv; zero for points of pictures."""
    weight: FloatArray
    """(n,) area at rest."""
    facets: IntArray
    """(f, 3) triangles between the points of each patch."""

    def points(self, q: FloatArray) -> FloatArray:
        """Return the points N q (n, 3) of control points (m, 3); velocities likewise."""
        return self.rows.times(q)

    def normals(self, q: FloatArray) -> FloatArray:
        """Return S_u × S_v (n, 3); times `measure` it is the area vector of a point."""
        return np.cross(self.along_u.times(q), self.along_v.times(q))

    def spread(self, f: FloatArray) -> FloatArray:
        """Return forces on the points (n, 3) as forces Nᵀ f (m, 3) on control points.

        Work, sum and moment stay the same, as the basis functions sum to one.
        """
        return self.columns.times(f)


def sparse_rows(columns: list[IntArray], values: list[FloatArray]) -> SparseRows:
    """Stack blocks of rows into a matrix; each block has columns and values (n, k)."""
    counts = np.concatenate([np.full(len(block), block.shape[1]) for block in columns])
    starts = np.zeros(len(counts) + 1, np.int32)
    np.cumsum(counts, out=starts[1:])
    flat = np.concatenate([block.ravel() for block in columns]).astype(np.int32)
    return SparseRows(starts, flat, np.concatenate([block.ravel() for block in values]))


def grid_facets(rows: int, columns: int, first: int) -> IntArray:
    """Return triangles (2 (rows − 1) (columns − 1), 3), two per cell of a grid of points.

    Points are numbered from `first` on, row by row; cells are split from their lowest point, which
    both of their triangles begin with.
    """
    corner = first + np.arange(rows * columns, dtype=np.int32).reshape(rows, columns)
    a, b = corner[:-1, :-1].ravel(), corner[1:, :-1].ravel()
    c, d = corner[1:, 1:].ravel(), corner[:-1, 1:].ravel()
    return np.stack([a, b, c, a, c, d], axis=1).reshape(-1, 3)
