"""The points at which a slave is asked for contact: its nodes, or quadrature points of its facets.

Points are x_q = Σ_j N_j(q) x_j of the nodes j, and what they feel goes back by the transpose:
F_j = Σ_q N_j(q) f_q. So the work of the forces on the nodes is that of the forces at the points.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.arrays.layout import locked
from contiga.arrays.threads import run_ranges
from contiga.errors import InputError
from contiga.records import FloatArray, IndexArray, IntArray
from contiga.slaves.kernels.facet_points_nb import points_of_facets
from contiga.slaves.skin import facet_areas
from contiga.slaves.slave import Slave

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


class Sampling:
    """The nodes of a slave, or its nodes and after them the quadrature points of its facets.

    The nodes come first in any case: areas and fields are about them. With quadrature points they
    carry nothing.

    Parameters
    ----------
    slave : with facets, where there is a rule
    weight : (n,) fixed areas of the nodes, None where they are not known; with a rule those of the
        facets at rest are taken
    rule : None for the nodes alone
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

    def __init__(self, slave: Slave, weight: FloatArray | None, rule: Rule | None = None) -> None:
        self.n_nodes = len(slave)
        self._rule = rule
        if rule is None:
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
        self._facets = slave.facets
        self.n_points = self.n_nodes + len(rule.weight) * len(slave.facets)
        self.first = self.n_nodes
        area = (facet_areas(slave.points, slave.facets)[:, None] * rule.weight).ravel()
        self.weight = np.concatenate([np.zeros(self.n_nodes), area])
        whole = slave.active[slave.facets].all(axis=1)
        self.active = locked(np.concatenate([slave.active, np.repeat(whole, len(rule.weight))]))
        self.thickness = None if slave.thickness is None else self._mean(slave.thickness)
        self.mass = None if slave.mass is None else self._shared(slave.mass, area)

    def weights(self, rows: IndexArray) -> FloatArray:
        """(len(rows),) fixed areas of some points; one each where they are not known."""
        return np.ones(len(rows)) if self.weight is None else self.weight.take(rows)

    def points(self, nodal: FloatArray) -> FloatArray:
        """(n_points, 3) of what (n, 3) is at the nodes: places or velocities."""
        if self._rule is None:
            return nodal
        points = np.empty((self.n_points, 3))
        points[: self.n_nodes] = nodal
        inner = points[self.n_nodes :]
        given = locked(nodal), self._facets, self._rule.shape, inner
        run_ranges(points_of_facets, len(self._facets), FACETS, *given)
        return points

    def points_at(self, rows: IndexArray, nodal: FloatArray) -> FloatArray:
        """(len(rows), 3) of `points` at some of them, ascending."""
        k = int(np.searchsorted(rows, self.n_nodes))
        at_nodes = nodal.take(rows[:k], axis=0)
        if k == len(rows):
            return at_nodes
        corner, shape = self._corners(rows[k:])
        inner = np.zeros((len(corner), 3))
        for j in range(3):
            inner += shape[:, j, None] * nodal.take(corner[:, j], axis=0)
        return np.concatenate([at_nodes, inner])

    def nodal(self, rows: IndexArray, values: FloatArray) -> FloatArray:
        """(n, 3) at the nodes, of `values` (len(rows), 3) at the points `rows`."""
        if self._rule is None:
            out = np.zeros((self.n_nodes, 3))
            out[rows] = values
            return out
        corner, shape = self._corners(rows)
        columns = [self._gathered(corner, shape * values[:, d, None]) for d in range(3)]
        return np.stack(columns, axis=1)

    def nodal_sum(self, rows: IndexArray, values: FloatArray) -> FloatArray:
        """(n,) at the nodes, of `values` (len(rows),) at the points `rows`."""
        if self._rule is None:
            out = np.zeros(self.n_nodes)
            out[rows] = values
            return out
        corner, shape = self._corners(rows)
        return self._gathered(corner, shape * values[:, None])

    def _corners(self, rows: IndexArray) -> tuple[IntArray, FloatArray]:
        """Corners (r, 3) and shape functions (r, 3) of quadrature points."""
        assert self._rule is not None
        facet, k = np.divmod(rows - self.n_nodes, len(self._rule.weight))
        return self._facets[facet], self._rule.shape[k]

    def _gathered(self, corner: IntArray, values: FloatArray) -> FloatArray:
        whole = np.bincount(corner.ravel(), weights=values.ravel(), minlength=self.n_nodes)
        return whole.astype(np.float64)

    def _mean(self, nodal: FloatArray) -> FloatArray:
        """(n_points,) means of the corners that have a value."""
        assert self._rule is not None
        at = nodal[self._facets]
        whole = np.einsum("fj,kj->fk", at, self._rule.shape, optimize=False)
        there = np.einsum("fj,kj->fk", (at > 0.0) * 1.0, self._rule.shape, optimize=False)
        inner = np.zeros_like(whole)
        np.divide(whole, there, out=inner, where=there > 0.0)
        return np.concatenate([nodal, inner.ravel()])

    def _shared(self, nodal: FloatArray, area: FloatArray) -> FloatArray:
        """(n_points,) shares of what the nodes have, whose sum is theirs."""
        rows = np.arange(self.n_nodes, self.n_points, dtype=np.int64)
        corner, shape = self._corners(rows)
        part = shape * area[:, None]
        whole = self._gathered(corner, part)
        each = np.zeros(self.n_nodes)
        np.divide(nodal, whole, out=each, where=whole > 0.0)
        return np.concatenate([np.zeros(self.n_nodes), (part * each[corner]).sum(axis=1)])
