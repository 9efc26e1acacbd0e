"""The points at which a slave is asked for contact: its nodes, or quadrature points of its facets.

Points are x_q = Σ_j N_j(q) x_j of the nodes j, and what they feel goes back by the transpose:
F_j = Σ_q N_j(q) f_q. So the work of the forces on the nodes is that of the forces at the points.
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

FACETS = 2000
"""Below so many a second thread does not pay."""


class Rule(NamedTuple):
    """A quadrature rule on triangles, with weights above zero and points inside."""

    shape: FloatArray
    """(k, 3) barycentric coordinates: the corners' linear shape functions."""
    weight: FloatArray
    """(k,) shares of the triangle's area; their sum is one."""
    degree: int
    """Of the polynomials it integrates without error."""


def _symmetric(
    orbits: list[tuple[float, tuple[float, float]]], degree: int, centre: bool = False
) -> Rule:
    """A rule of symmetric orbits (weight of one point, its first two coordinates)."""
    shape, weight = ([[1.0 / 3.0] * 3], [1.0]) if centre else ([], [])
    for share, (a, b) in orbits:
        c = 1.0 - a - b
        points = [[a, b, c], [b, c, a], [c, a, b]]
        if abs(b - c) > 1e-9:
            points += [[a, c, b], [c, b, a], [b, a, c]]
        shape += points
        weight += [share] * len(points)
    whole = np.array(weight)
    return Rule(np.array(shape), whole / whole.sum(), degree)


def _pair(a: float) -> tuple[float, float]:
    """The orbit (a, b, b)."""
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
"""Points a facet -> rule. D. A. Dunavant, High degree efficient symmetrical Gaussian quadrature
rules for the triangle, IJNME 21 (1985), degrees 1, 2, 4 and 6."""

QUADRATURES: tuple[str | int, ...] = ("nodes", *RULES)

QUAD_RULES: dict[int, QuadRule] = {n: quad_rule(k + 2) for k, n in enumerate(RULES)}


def more_points(quadrature: str | int) -> str:
    """Advice to put more points of contact on facets, for a remedy; "" where a rule has enough."""
    if quadrature in ("nodes", 1, 3):
        return ", or take quadrature = 6, which puts more points of contact on facets"
    return ""


"""Points a triangle -> rule on quadrilaterals: Gauss's of 4, 9, 16 and 25 points, in u and in v of
degree 3, 5, 7 and 9: the first with no fewer points than two triangles have."""


class _OnFaces(NamedTuple):
    """Quadrature points on faces of as many corners: point k of face f is row `first` + f n + k."""

    first: int
    corners: IntArray
    """(f, c) nodes."""
    shape: FloatArray
    """(n, c)."""
    area: FloatArray
    """(f n,) of the faces at rest, as the rule shares it."""
    share: FloatArray
    """(f n,) share of each point in the area of its face."""

    @property
    def stop(self) -> int:
        """After the last row."""
        return self.first + len(self.area)

    def of(self, rows: IndexArray) -> tuple[IntArray, FloatArray]:
        """Corners (r, c) and shape functions (r, c) of some of the points."""
        face, k = np.divmod(rows - self.first, len(self.shape))
        return self.corners[face], self.shape[k]


def _faces_of(slave: Slave, points: int) -> tuple[_OnFaces, ...]:
    """The quadrature points of a slave, `points` a triangle."""
    assert slave.facets is not None
    skin = corners_of(slave.facets, slave.quads)
    faces, first = [], len(slave)
    if len(skin.quads):
        on_quads = QUAD_RULES[points]
        jacobian = np.linalg.norm(quad_normals(slave.points, skin.quads, on_quads), axis=2)
        area = jacobian * on_quads.weight
        faces.append(_on_faces(first, skin.quads, on_quads.shape, area))
        first = faces[-1].stop
    if len(skin.triangles):
        rule = RULES[points]
        whole = 0.5 * np.linalg.norm(triangle_normals(slave.points, skin.triangles), axis=1)
        area = whole[:, None] * rule.weight
        faces.append(_on_faces(first, skin.triangles, rule.shape, area))
    return tuple(faces)


def _on_faces(first: int, corners: IntArray, shape: FloatArray, area: FloatArray) -> _OnFaces:
    """Return the points of faces, of areas (f, n)."""
    whole = area.sum(axis=1, keepdims=True)
    share = np.divide(area, whole, out=np.zeros(area.shape), where=whole > 0.0)
    return _OnFaces(first, locked(corners), shape, area.ravel(), share.ravel())


class _Adjacent(NamedTuple):
    """The nodes that share a face: blocks of a sparse matrix, row after row."""

    start: IndexArray
    """(n + 1,) where the blocks of each node begin."""
    column: IntArray
    """(b,) the other node of each block."""
    places: dict[int, IntArray]
    """By the first row of faces (f, c, c) which block is between each two corners."""


class Sampling:
    """The nodes of a slave, or its nodes and after them the quadrature points of its facets.

    The nodes come first in any case: areas and fields are about them. With quadrature points they
    carry nothing.

    Parameters
    ----------
    slave : with facets, where there is a rule
    weight : (n,) fixed areas of the nodes, None where they are not known; with a rule those of the
        facets at rest are taken
    points : quadrature points a triangle, a key of `RULES`; quadrilaterals have those of
        `QUAD_RULES`. None for the nodes alone
    """

    n_nodes: int
    n_points: int
    """Nodes and quadrature points."""
    first: int
    """Points from here on carry forces."""
    weight: FloatArray | None
    """(n_points,) fixed areas, zero of nodes that carry nothing; None where they are not known."""
    active: NDArray[np.bool_]
    """(n_points,) which take part: quadrature points of facets whose corners all do. Locked."""
    thickness: FloatArray | None
    """(n_points,) of the slave there, the mean of the corners that have one."""
    mass: FloatArray | None
    """(n_points,) shares of the nodes' masses."""

    def __init__(self, slave: Slave, weight: FloatArray | None, points: int | None = None) -> None:
        self.n_nodes = len(slave)
        self._faces: tuple[_OnFaces, ...] = ()
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
        self._faces = _faces_of(slave, points)
        self.first, self.n_points = self.n_nodes, self._faces[-1].stop
        self.weight = np.concatenate([np.zeros(self.n_nodes), *(on.area for on in self._faces)])
        whole = [
            np.repeat(slave.active[on.corners].all(axis=1), len(on.shape)) for on in self._faces
        ]
        self.active = locked(np.concatenate([slave.active, *whole]))
        self.thickness = None if slave.thickness is None else self._mean(slave.thickness)
        self.mass = None if slave.mass is None else self._shared(slave.mass)

    def points(self, nodal: FloatArray) -> FloatArray:
        """Return (n_points, 3) for `values` (n, 3) at the nodes: places or velocities."""
        if not self._faces:
            return nodal
        points = np.empty((self.n_points, 3))
        points[: self.n_nodes] = nodal
        for on in self._faces:
            given = locked(nodal), on.corners, on.shape, points[on.first : on.stop]
            run_ranges(points_of_facets, len(on.corners), FACETS, *given)
        return points

    def points_at(self, rows: IndexArray, nodal: FloatArray) -> FloatArray:
        """Return `points` (len(rows), 3) at some of them, ascending."""
        k = int(np.searchsorted(rows, self.n_nodes))
        out = np.empty((len(rows), 3))
        out[:k] = nodal.take(rows[:k], axis=0)
        nodal = locked(np.ascontiguousarray(nodal, np.float64))
        for on, part in self._split(rows):
            some = np.ascontiguousarray(rows[part], np.int32)
            given = some, on.first, nodal, on.corners, on.shape, out[part]
            straight(facet_sums_nb.from_corners)(*given)
        return out

    def nodal(self, rows: IndexArray, values: FloatArray) -> FloatArray:
        """Return (n, 3) at the nodes for `values` (k, 3) at the points `rows` (k,), ascending."""
        out = np.zeros((self.n_nodes, values.shape[1]))
        if not self._faces:
            out[rows] = values
        for on, part in self._split(rows):
            some = np.ascontiguousarray(rows[part], np.int32)
            each = np.ascontiguousarray(values[part], np.float64)
            given = some, on.first, each, on.corners, on.shape, out
            straight(facet_sums_nb.to_corners)(*given)
        return out

    def nodal_sum(self, rows: IndexArray, values: FloatArray) -> FloatArray:
        """Return (n,) at the nodes for `values` (k,) at the points `rows` (k,), ascending."""
        return self.nodal(rows, values[:, None])[:, 0]

    def covered(self, rows: IndexArray, slave: Slave) -> FloatArray:
        """Return the share (f,) of each facet of `slave` that some of its points represent.

        `rows` are numbers of points, ascending. Shares are by area at rest; those of nodes are a
        third for each corner.
        """
        assert slave.facets is not None
        if not self._faces:
            nodes = np.zeros(self.n_nodes)
            nodes[rows] = 1.0
            return nodes[slave.facets].mean(axis=1)
        shares = np.zeros(len(slave.facets))
        alone = np.ones(len(shares), np.bool_)
        alone[slave.quads] = False
        for on, part in self._split(rows):
            places = rows[part] - on.first
            share = np.bincount(places // len(on.shape), on.share[places], len(on.corners))
            if on.corners.shape[1] == 4:
                shares[slave.quads] = share[:, None]
            else:
                shares[alone] = share
        return shares

    def matrix(self, rows: IndexArray, blocks: FloatArray) -> csr_array:
        """Return a sparse (3 n, 3 n) over the nodes for `blocks` (k, 3, 3) at points `rows`.

        With x_q = Σ_a N_qa x_a and F_a = Σ_q N_qa f_q it is Σ_q N_qa N_qb K_q between nodes a, b.
        """
        from scipy.sparse import bsr_array

        n = self.n_nodes
        if not self._faces:
            count = np.zeros(n + 1, np.int32)
            count[rows + 1] = 1
            start, column, values = np.cumsum(count, dtype=np.int32), rows.astype(np.int32), blocks
        else:
            start, column, values = self._between(rows, blocks)
        return bsr_array((values, column, start), shape=(3 * n, 3 * n)).tocsr()

    def shares(self, rows: IndexArray) -> csr_array:
        """Return the sparse weights N (n, len(rows)) of the nodes at points: x_q = Σ_a N_aq x_a.

        `rows` are numbers of points, ascending.

        The rows are ascending.
        """
        from scipy.sparse import coo_array

        each = np.arange(len(rows))
        parts = [] if self._faces else [(np.ones(len(rows)), rows, each)]
        for on, part in self._split(rows):
            corner, shape = on.of(rows[part])
            points = np.repeat(each[part], corner.shape[1])
            parts.append((shape.ravel(), corner.ravel(), points))
        parts = parts or [(np.zeros(0), each, each)]
        values, nodes, points = (np.concatenate(column) for column in zip(*parts, strict=True))
        return coo_array((values, (nodes, points)), shape=(self.n_nodes, len(rows))).tocsr()

    def _between(
        self, rows: IndexArray, blocks: FloatArray
    ) -> tuple[IntArray, IntArray, FloatArray]:
        """Return first rows of nodes, columns and blocks, for points between the nodes."""
        adjacent = self._adjacent
        used = np.zeros(len(adjacent.column), np.int8)
        parts = []
        for on, part in self._split(rows):
            face, k = np.divmod(rows[part].astype(np.int64) - on.first, len(on.shape))
            places = adjacent.places[on.first]
            facet_blocks_nb.mark(places, face, used)
            parts.append((blocks[part], face, k, on.shape, places))
        kept = np.flatnonzero(used)
        new = np.zeros(len(used) + 1, np.int32)
        np.cumsum(used, out=new[1:])
        values = np.zeros((len(kept), 3, 3))
        for block, face, k, shape, places in parts:
            facet_blocks_nb.add(block, face, k, shape, new[places], values)
        return new[adjacent.start], adjacent.column[kept], values

    @cached_property
    def _adjacent(self) -> _Adjacent:
        """Found when it is first asked for."""
        n = self.n_nodes
        pairs = [
            on.corners[:, :, None].astype(np.int64) * n + on.corners[:, None] for on in self._faces
        ]
        keys, place = np.unique(np.concatenate([p.ravel() for p in pairs]), return_inverse=True)
        start = np.searchsorted(keys, np.arange(n + 1, dtype=np.int64) * n)
        ends = np.cumsum([p.size for p in pairs])[:-1]
        places = {
            on.first: part.reshape(p.shape).astype(np.int32)
            for on, p, part in zip(self._faces, pairs, np.split(place.ravel(), ends), strict=True)
        }
        return _Adjacent(start, (keys % n).astype(np.int32), places)

    def _split(self, rows: IndexArray) -> Iterator[tuple[_OnFaces, slice]]:
        """Yield which of `rows`, ascending, are on faces of each number of corners."""
        for on in self._faces:
            start, stop = np.searchsorted(rows, (on.first, on.stop)).tolist()
            if stop > start:
                yield on, slice(start, stop)

    def _mean(self, nodal: FloatArray) -> FloatArray:
        """Return (n_points,) means of the corners that have a value."""
        means = [nodal]
        for on in self._faces:
            at = nodal[on.corners]
            whole = np.einsum("fj,kj->fk", at, on.shape, optimize=False)
            there = np.einsum("fj,kj->fk", (at > 0.0) * 1.0, on.shape, optimize=False)
            inner = np.zeros_like(whole)
            np.divide(whole, there, out=inner, where=there > 0.0)
            means.append(inner.ravel())
        return np.concatenate(means)

    def _shared(self, nodal: FloatArray) -> FloatArray:
        """Return (n_points,) shares of what the nodes have, by area, whose sum is theirs."""
        assert self.weight is not None
        rows = np.arange(self.n_nodes, self.n_points, dtype=np.int64)
        whole = self.nodal_sum(rows, self.weight[self.n_nodes :])
        each = np.zeros(self.n_nodes)
        np.divide(nodal, whole, out=each, where=whole > 0.0)
        shares = [np.zeros(self.n_nodes)]
        for on in self._faces:
            corner, shape = on.of(np.arange(on.first, on.stop, dtype=np.int64))
            shares.append((shape * on.area[:, None] * each[corner]).sum(axis=1))
        return np.concatenate(shares)
