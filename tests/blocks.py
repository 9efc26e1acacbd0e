"""Blocks of elements and small matter for tests of what deforms."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import contiga as cg
from contiga.matter import MatterEnergy, MatterForces, MatterState
from contiga.slaves.skin import CellBlock, skin

_CORNERS = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))
_TETRA = ((0, 1, 2, 6), (0, 2, 3, 6), (0, 3, 7, 6), (0, 7, 4, 6), (0, 4, 5, 6), (0, 5, 1, 6))


def block(counts, sides, low=(0.0, 0.0, 0.0), kind="tetra"):
    """A block as a slave: `counts` cells along `sides` from the corner `low`."""
    lines = [
        o + np.linspace(0.0, side, n + 1) for o, side, n in zip(low, sides, counts, strict=True)
    ]
    points = np.stack(np.meshgrid(*lines, indexing="ij"), -1).reshape(-1, 3)
    index = np.arange(len(points)).reshape([n + 1 for n in counts])
    nx, ny, nz = counts
    hexahedra = np.stack(
        [index[a : a + nx, b : b + ny, c : c + nz].ravel() for a, b, c in _CORNERS], axis=1
    )
    cells = hexahedra
    if kind == "tetra":
        cells = np.concatenate([hexahedra[:, list(k)] for k in _TETRA])
    facets = skin(points, [CellBlock(kind, cells.astype(np.int64))])
    return cg.Slave(points, facets, elements={kind: cells})


@dataclass(frozen=True)
class Chain:
    """Matter of a user's own: masses along a line, each joined to the next by a linear spring."""

    mass: np.ndarray
    spring: float
    length: float
    facets: np.ndarray

    @classmethod
    def of(cls, slave, mass, spring):
        length = float(np.linalg.norm(slave.points[1] - slave.points[0]))
        return cls(np.full(len(slave), mass), spring, length, np.zeros((0, 3), np.int32))

    def points(self, q):
        return q

    velocities = spread = points

    def start(self):
        return MatterState(np.zeros((len(self.mass), 3)), np.zeros(1))

    def forces(self, state, q, v, dt):
        way = np.diff(q, axis=0)
        now = np.linalg.norm(way, axis=1)
        pull = self.spring * (now - self.length)
        force = np.zeros_like(q)
        along = pull[:, None] * way / now[:, None]
        force[:-1] += along
        force[1:] -= along
        energy = 0.5 * float((self.spring * (now - self.length) ** 2).sum())
        return MatterForces(force, MatterEnergy(energy), MatterState(q, state.memory + dt))

    def stiffness(self, state):
        sums = np.full(len(self.mass), 4.0 * self.spring)
        sums[[0, -1]] = 2.0 * self.spring
        return sums


def facet_areas(points: np.ndarray, facets: np.ndarray) -> np.ndarray:
    """(m,) areas of triangles (m, 3) on `points` (n, 3)."""
    a, b, c = (points[facets[:, k]] for k in range(3))
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
