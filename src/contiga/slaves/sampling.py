"""The contact points of a slave: its nodes, or quadrature points of its facets.

Points are x_q = Σ_j N_j(q) x_j of the nodes j, and forces on the nodes follow by the transpose:
F_j = Σ_q N_j(q) f_q. So the forces on the nodes do the same work as the forces at the points.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.arrays.layout import locked
from contiga.arrays.threads import run_ranges
from contiga.errors import InputError
from contiga.jit import straight
from contiga.records import FloatArray, IndexArray, IntArray
from contiga.slaves.kernels import facet_blocks_nb, facet_sums_nb
from contiga.slaves.kernels.facet_points_nb import points_of_facets
from contiga.slaves.quads import QuadRule, corners_of, quad_normals, quad_rule, triangle_normals
from contiga.slaves.slave import Slave

if TYPE_CHECKING:
    from scipy.sparse import csr_array

MIN_FACETS = 2000
"""Number of facets below which a second thread does not pay."""


class Rule(NamedTuple):
    """A quadrature rule on triangles, with weights above zero and points inside."""

    shape: FloatArray
    """(k, 3) barycentric coordinates: the corners' linear shape functions."""
    weight: FloatArray
    """(k,) shares of the triangle's area; their sum is one."""
    degree: int
    """Degree of the polynomials that it integrates without error."""


def _symmetric(
    orbits: list[tuple[float, tuple[float, float]]], degree: int, centre: bool = False
) -> Rule:
    """Return a rule of symmetric orbits: weight of a point, and its first two coordinates.

    An orbit has the points of all permutations of its coordinates. Weights are scaled to the sum
    one. A `centre` has the unscaled weight one, and stands alone.
    """
    shape, weights = ([[1.0 / 3.0] * 3], [1.0]) if centre else ([], [])
    for weight, (a, b) in orbits:
        c = 1.0 - a - b
        points = [[a, b, c], [b, c, a], [c, a, b]]
        if abs(b - c) > 1e-9:
            points += [[a, c, b], [c, b, a], [b, a, c]]
        shape += points
        weights += [weight] * len(points)
    total = np.array(weights)
    return Rule(np.array(shape), total / total.sum(), degree)


def _pair(a: float) -> tuple[float, float]:
    """Return the first two coordinates of the orbit (a, b, b), with b = (1 − a)/2."""
    return a, 0.5 * (1.0 - a)


RULES = {
    1: _symmetric([], 1, centre=True),
    3: _symmetric([(1.0 / 3.0, _pair(2.0 / 3.0))], 2),
    6: _symmetric(
        [
            (0.223381589678011, _pair(0.108103018168070)),
            (0.109951743655322, _pair(0.816847572980459)),
        ],
        4,
    ),
    12: _symmetric(
        [
            (0.116786275726379, _pair(0.501426509658179)),
            (0.050844906370207, _pair(0.873821971016996)),
            (0.082851075618374, (0.636502499121399, 0.310352451033784)),
        ],
        6,
    ),
}
"""Rules by number of points. D. A. Dunavant, High degree efficient symmetrical Gaussian quadrature
rules for the triangle, IJNME 21 (1985), degrees 1, 2, 4 and 6."""

QUADRATURES: tuple[str | int, ...] = ("nodes", *RULES)

QUAD_RULES: dict[int, QuadRule] = {n: quad_rule(k + 2) for k, n in enumerate(RULES)}
"""Rules on quadrilaterals by number of points of a triangle: Gauss rules of 4, 9, 16 and 25 points,
of degree 3, 5, 7 and 9 in u and in v: the smallest with at least the points of two triangles."""


def more_points(quadrature: str | int) -> str:
    """Return advice to use 6 points on facets, for messages; "" for a rule of 6 or more."""
    if quadrature in ("nodes", 1, 3):
        return ", or take quadrature = 6, which puts more points of contact on facets"
    return ""


class _FacePoints(NamedTuple):
    """Quadrature points on faces with c corners: point k of face f is row `first` + f n + k."""

    first: int
    corners: IntArray
    """(f, c) nodes."""
    shape: FloatArray
    """(n, c) shape functions."""
    area: FloatArray
    """(f n,) area of each point at rest."""
    share: FloatArray
    """(f n,) share of each point in the area of its face."""

    @classmethod
    def of(cls, first: int, corners: IntArray, shape: FloatArray, area: FloatArray) -> _FacePoints:
        """Return the points of faces with areas (f, n)."""
        total = area.sum(axis=1, keepdims=True)
        share = np.divide(area, total, out=np.zeros(area.shape), where=total > 0.0)
        return cls(first, locked(corners), shape, area.ravel(), share.ravel())

    @property
    def stop(self) -> int:
        """The row after the last."""
        return self.first + len(self.area)

    def corners_and_shape(self, rows: IndexArray) -> tuple[IntArray, FloatArray]:
        """Return corners (r, c) and shape functions (r, c) of some points."""
        face, k = np.divmod(rows - self.first, len(self.shape))
        return self.corners[face], self.shape[k]


class _Adjacent(NamedTuple):
    """Pairs of nodes that share a face: blocks of a sparse matrix, row after row."""

    start: IndexArray
    """(n + 1,) first block of each node."""
    column: IntArray
    """(b,) the other node of each block."""
    block_rows: dict[int, IntArray]
    """(f, c, c) block of each two corners, by the first row of the faces."""


class Sampling:
    """Contact points: the nodes of a slave, or these followed by quadrature points of its facets.

    The nodes always come first, since areas and fields refer to them. With quadrature points they
    carry no forces.

    Parameters
    ----------
    slave : slave; it must have facets for a rule
    weight : (n,) fixed areas of the nodes, None if unknown; a rule uses the areas of facets at rest
    points : quadrature points of a triangle, a key of `RULES`; quadrilaterals use `QUAD_RULES`.
        None for the nodes alone

    Raises
    ------
    InputError
        Quadrature points on a slave without facets.
    """

    n_nodes: int
    n_points: int
    """Nodes and quadrature points."""
    first: int
    """First point that carries forces."""
    weight: FloatArray | None
    """(n_points,) fixed areas, zero for nodes that carry no forces; None if unknown."""
    active: NDArray[np.bool_]
    """(n_points,) active points: quadrature points of facets with active corners. Locked."""
    thickness: FloatArray | None
    """(n_points,) thickness of the slave, the mean of the corners that have one."""
    mass: FloatArray | None
    """(n_points,) shares of the nodes' masses."""

    def __init__(self, slave: Slave, weight: FloatArray | None, points: int | None = None) -> None:
        self.n_nodes = len(slave)
        self._faces: tuple[_FacePoints, ...] = ()
        if points is None:
            self.n_points, self.first = self.n_nodes, 0
            self.weight = weight
            self.active, self.thickness, self.mass = (
                locked(slave.active),
                slave.thickness,
                slave.mass,
            )
            return
        if slave.facets is None or len(slave.facets) == 0:
            raise InputError(
                "quadrature points lie on facets, and the slave has none",
                where="quadrature",
                allowed='"nodes" for a cloud',
            )
        skin = corners_of(slave.facets, slave.quads)
        faces, first = [], len(slave)
        if len(skin.quads):
            quads = QUAD_RULES[points]
            jacobian = np.linalg.norm(quad_normals(slave.points, skin.quads, quads), axis=2)
            area = jacobian * quads.weight
            faces.append(_FacePoints.of(first, skin.quads, quads.shape, area))
            first = faces[-1].stop
        if len(skin.triangles):
            rule = RULES[points]
            facet_area = 0.5 * np.linalg.norm(
                triangle_normals(slave.points, skin.triangles), axis=1
            )
            area = facet_area[:, None] * rule.weight
            faces.append(_FacePoints.of(first, skin.triangles, rule.shape, area))
        self._faces = tuple(faces)
        self.first, self.n_points = self.n_nodes, faces[-1].stop
        self.weight = np.concatenate([np.zeros(self.n_nodes), *(group.area for group in faces)])
        is_active = [
            np.repeat(slave.active[group.corners].all(axis=1), len(group.shape)) for group in faces
        ]
        self.active = locked(np.concatenate([slave.active, *is_active]))
        self.thickness = None if slave.thickness is None else self._mean(slave.thickness)
        self.mass = None if slave.mass is None else self._shared(slave.mass)

    def points(self, nodal: FloatArray) -> FloatArray:
        """Return positions or velocities (n_points, 3) of the points for `nodal` ones (n, 3).

        Without quadrature points it is `nodal` itself.
        """
        if not self._faces:
            return nodal
        points = np.empty((self.n_points, 3))
        points[: self.n_nodes] = nodal
        for group in self._faces:
            out = points[group.first : group.stop]
            arguments = locked(nodal), group.corners, group.shape, out
            run_ranges(points_of_facets, len(group.corners), MIN_FACETS, *arguments)
        return points

    def points_at(self, rows: IndexArray, nodal: FloatArray) -> FloatArray:
        """Return positions or velocities (r, 3) of some points, at ascending rows (r,)."""
        k = int(np.searchsorted(rows, self.n_nodes))
        out = np.empty((len(rows), 3))
        out[:k] = nodal.take(rows[:k], axis=0)
        nodal = locked(np.ascontiguousarray(nodal, np.float64))
        for group, part in self._split(rows):
            face_rows = np.ascontiguousarray(rows[part], np.int32)
            arguments = face_rows, group.first, nodal, group.corners, group.shape, out[part]
            straight(facet_sums_nb.from_corners)(*arguments)
        return out

    def nodal(self, rows: IndexArray, values: FloatArray) -> FloatArray:
        """Return nodal sums (n, c) of `values` (k, c) at the points `rows` (k,).

        Rows must be ascending, each once. With quadrature points, values at nodes do not count.
        """
        out = np.zeros((self.n_nodes, values.shape[1]))
        if not self._faces:
            out[rows] = values
        for group, part in self._split(rows):
            face_rows = np.ascontiguousarray(rows[part], np.int32)
            face_values = np.ascontiguousarray(values[part], np.float64)
            arguments = face_rows, group.first, face_values, group.corners, group.shape, out
            straight(facet_sums_nb.to_corners)(*arguments)
        return out

    def nodal_sum(self, rows: IndexArray, values: FloatArray) -> FloatArray:
        """Return nodal sums (n,) of `values` (k,) at the points `rows` (k,), as `nodal`."""
        return self.nodal(rows, values[:, None])[:, 0]

    def covered(self, rows: IndexArray, slave: Slave) -> FloatArray:
        """Return the share (f,) of each facet of `slave` that the points `rows` represent, 0 to 1.

        `rows` are numbers of points, ascending. Shares are by area at rest; both halves of a
        quadrilateral have that of the quadrilateral. Without quadrature points a node represents a
        third of each of its facets.
        """
        assert slave.facets is not None
        if not self._faces:
            nodes = np.zeros(self.n_nodes)
            nodes[rows] = 1.0
            return nodes[slave.facets].mean(axis=1)
        shares = np.zeros(len(slave.facets))
        is_triangle = np.ones(len(shares), np.bool_)
        is_triangle[slave.quads] = False
        for group, part in self._split(rows):
            k = rows[part] - group.first
            share = np.bincount(k // len(group.shape), group.share[k], len(group.corners))
            if group.corners.shape[1] == 4:
                shares[slave.quads] = share[:, None]
            else:
                shares[is_triangle] = share
        return shares

    def matrix(self, rows: IndexArray, blocks: FloatArray) -> csr_array:
        """Return a sparse matrix (3 n, 3 n) over the nodes for `blocks` (k, 3, 3) at points `rows`.

        With x_q = Σ_a N_qa x_a and F_a = Σ_q N_qa f_q it is Σ_q N_qa N_qb K_q between nodes a, b.
        Rows must be ascending, each once. With quadrature points, blocks at nodes do not count.
        """
        from scipy.sparse import bsr_array

        n = self.n_nodes
        if not self._faces:
            count = np.zeros(n + 1, np.int32)
            count[rows + 1] = 1
            start, column, values = np.cumsum(count, dtype=np.int32), rows.astype(np.int32), blocks
        else:
            pairs = self._adjacent
            is_used = np.zeros(len(pairs.column), np.int8)
            parts = []
            for group, part in self._split(rows):
                face, k = np.divmod(rows[part].astype(np.int64) - group.first, len(group.shape))
                block_rows = pairs.block_rows[group.first]
                facet_blocks_nb.mark(block_rows, face, is_used)
                parts.append((blocks[part], face, k, group.shape, block_rows))
            # Only blocks of faces with points in `rows` are stored.
            new_rows = np.zeros(len(is_used) + 1, np.int32)
            np.cumsum(is_used, out=new_rows[1:])
            column = pairs.column[np.flatnonzero(is_used)]
            values = np.zeros((len(column), 3, 3))
            for block, face, k, shape, block_rows in parts:
                facet_blocks_nb.add(block, face, k, shape, new_rows[block_rows], values)
            start = new_rows[pairs.start]
        return bsr_array((values, column, start), shape=(3 * n, 3 * n)).tocsr()

    def shares(self, rows: IndexArray) -> csr_array:
        """Return the sparse weights N (n, len(rows)) of the nodes at points: x_q = Σ_a N_aq x_a.

        `rows` are numbers of points, ascending. With quadrature points, columns of nodes are empty.
        """
        from scipy.sparse import coo_array

        columns = np.arange(len(rows))
        parts = [] if self._faces else [(np.ones(len(rows)), rows, columns)]
        for group, part in self._split(rows):
            corner, shape = group.corners_and_shape(rows[part])
            points = np.repeat(columns[part], corner.shape[1])
            parts.append((shape.ravel(), corner.ravel(), points))
        parts = parts or [(np.zeros(0), columns, columns)]
        values, nodes, points = (np.concatenate(column) for column in zip(*parts, strict=True))
        return coo_array((values, (nodes, points)), shape=(self.n_nodes, len(rows))).tocsr()

    @cached_property
    def _adjacent(self) -> _Adjacent:
        """Pairs of nodes that share a face, a node and itself included; computed once."""
        n = self.n_nodes
        pairs = [
            group.corners[:, :, None].astype(np.int64) * n + group.corners[:, None]
            for group in self._faces
        ]
        keys, inverse = np.unique(np.concatenate([p.ravel() for p in pairs]), return_inverse=True)
        start = np.searchsorted(keys, np.arange(n + 1, dtype=np.int64) * n)
        ends = np.cumsum([p.size for p in pairs])[:-1]
        block_rows = {
            group.first: rows.reshape(p.shape).astype(np.int32)
            for group, p, rows in zip(
                self._faces, pairs, np.split(inverse.ravel(), ends), strict=True
            )
        }
        return _Adjacent(start, (keys % n).astype(np.int32), block_rows)

    def _split(self, rows: IndexArray) -> Iterator[tuple[_FacePoints, slice]]:
        """Yield each group of faces with points in ascending `rows`, and the slice of these."""
        for group in self._faces:
            start, stop = np.searchsorted(rows, (group.first, group.stop)).tolist()
            if stop > start:
                yield group, slice(start, stop)

    def _mean(self, nodal: FloatArray) -> FloatArray:
        """Return (n_points,) nodal values, then means of the corners with a value above zero.

        Means are weighted by the shape functions; zero if no corner has a value.
        """
        means = [nodal]
        for group in self._faces:
            values = nodal[group.corners]
            total = np.einsum("fj,kj->fk", values, group.shape, optimize=False)
            weight = np.einsum("fj,kj->fk", (values > 0.0) * 1.0, group.shape, optimize=False)
            mean = np.zeros_like(total)
            np.divide(total, weight, out=mean, where=weight > 0.0)
            means.append(mean.ravel())
        return np.concatenate(means)

    def _shared(self, nodal: FloatArray) -> FloatArray:
        """Return (n_points,) shares of nodal values by the areas of the points; zero at the nodes.

        The sum stays the same but for nodes without area, whose values are lost.
        """
        assert self.weight is not None
        rows = np.arange(self.n_nodes, self.n_points, dtype=np.int64)
        area = self.nodal_sum(rows, self.weight[self.n_nodes :])
        per_area = np.zeros(self.n_nodes)
        np.divide(nodal, area, out=per_area, where=area > 0.0)
        shares = [np.zeros(self.n_nodes)]
        for group in self._faces:
            face_rows = np.arange(group.first, group.stop, dtype=np.int64)
            corner, shape = group.corners_and_shape(face_rows)
            shares.append((shape * group.area[:, None] * per_area[corner]).sum(axis=1))
        return np.concatenate(shares)
