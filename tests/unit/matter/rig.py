"""Small meshes, and what all matter is held to: forces by differences of what is stored."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from contiga.matter import Assembled, MatterState, Part, assemble
from contiga.matter.coefficients import Material

ONE_TET = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
TETS = ((0, 1, 3, 7), (0, 3, 2, 7), (0, 2, 6, 7), (0, 6, 4, 7), (0, 4, 5, 7), (0, 5, 1, 7))
"""Of a cube whose corner is i + 2 j + 4 k."""


def grid(counts: Sequence[int], size: Sequence[float] = (1.0, 1.0, 1.0)) -> np.ndarray:
    """(n, 3) nodes of an even grid, x first to run."""
    axes = [np.linspace(0.0, s, c + 1) for s, c in zip(size, counts, strict=True)]
    z, y, x = np.meshgrid(*axes[::-1], indexing="ij")
    return np.stack([x.ravel(), y.ravel(), z.ravel()], axis=1)


def cells(counts: Sequence[int]) -> np.ndarray:
    """(n, 8) corners of its cells, i + 2 j + 4 k."""
    nx, ny, nz = counts
    rows = np.arange((nx + 1) * (ny + 1) * (nz + 1)).reshape(nz + 1, ny + 1, nx + 1)
    corners = [
        rows[k : nz + k, j : ny + j, i : nx + i].ravel()
        for k in (0, 1)
        for j in (0, 1)
        for i in (0, 1)
    ]
    return np.stack(corners, axis=1)


def hexes(counts: Sequence[int]) -> np.ndarray:
    """(n, 8) one a cell, corners in VTK's order."""
    return cells(counts)[:, [0, 1, 3, 2, 4, 5, 7, 6]]


def tets(counts: Sequence[int]) -> np.ndarray:
    """(n, 4) six tetrahedra a cell."""
    found = cells(counts)[:, np.array(TETS)].reshape(-1, 4)
    return found[:, [0, 2, 1, 3]] if _volume(grid(counts), found)[0] < 0.0 else found


def _volume(nodes: np.ndarray, elements: np.ndarray) -> np.ndarray:
    edges = nodes[elements[:, 1:]] - nodes[elements[:, :1]]
    return np.linalg.det(edges) / 6.0


def sheet(nx: int, ny: int) -> np.ndarray:
    """(n, 3) two triangles a cell of a grid (nx, ny, 0)."""
    rows = np.arange((nx + 1) * (ny + 1)).reshape(ny + 1, nx + 1)
    a, b = rows[:-1, :-1].ravel(), rows[:-1, 1:].ravel()
    c, d = rows[1:, 1:].ravel(), rows[1:, :-1].ravel()
    return np.stack([a, b, c, a, c, d], axis=1).reshape(-1, 3)


def moved(nodes: np.ndarray, by: float, seed: int = 0) -> np.ndarray:
    """Nodes at random beside where they were."""
    return nodes + by * np.random.default_rng(seed).normal(size=nodes.shape)


def one_part(
    kind: str, nodes: np.ndarray, elements: np.ndarray, material: Material, **more: float
) -> Assembled:
    """Matter of one part of density 2."""
    part = Part(kind=kind, elements=elements, material=material, density=2.0, **more)
    return assemble(nodes, [part])


def still(
    matter: Assembled, q: np.ndarray, state: MatterState | None = None
) -> tuple[np.ndarray, float]:
    """Forces and what is stored at q, at rest."""
    start = matter.start() if state is None else state
    answer = matter.forces(start, q, np.zeros_like(q), 0.0)
    return answer.force, answer.energy.strain + answer.energy.hourglass


def by_differences(
    matter: Assembled, q: np.ndarray, state: MatterState | None = None, h: float = 1e-3
) -> np.ndarray:
    """Minus the gradient of what is stored, by differences of fourth order."""
    found = np.zeros(q.size)
    for k in range(q.size):
        way = np.zeros(q.size)
        way[k] = h
        way = way.reshape(q.shape)
        near, far = (
            still(matter, q + c * way, state)[1] - still(matter, q - c * way, state)[1]
            for c in (1.0, 2.0)
        )
        found[k] = -(8.0 * near - far) / (12.0 * h)
    return found.reshape(q.shape)


def tangent(matter: Assembled, q: np.ndarray, h: float = 1e-6) -> np.ndarray:
    """(3 m, 3 m) stiffness, by differences of the forces."""
    columns = []
    for k in range(q.size):
        way = np.zeros(q.size)
        way[k] = h
        way = way.reshape(q.shape)
        columns.append((still(matter, q - way)[0] - still(matter, q + way)[0]).ravel() / (2.0 * h))
    return np.stack(columns, axis=1)


def pull(material: Material, stretches: tuple[float, float, float]) -> tuple[np.ndarray, float]:
    """Nominal stresses of a unit cube that is stretched along its edges, and energy."""
    nodes = grid((1, 1, 1))
    matter = one_part("tet4", nodes, tets((1, 1, 1)), material)
    force, energy = still(matter, nodes * stretches)
    return np.array([-force[nodes[:, k] == 1.0, k].sum() for k in range(3)]), energy


def pull_sheet(material: Material, stretches: tuple[float, float]) -> tuple[np.ndarray, float]:
    """Nominal stresses of a unit square of thickness one, and energy."""
    nodes = grid((1, 1, 0))
    matter = one_part("tri3", nodes, sheet(1, 1), material, thickness=1.0)
    force, energy = still(matter, nodes * [*stretches, 1.0])
    return np.array([-force[nodes[:, k] == 1.0, k].sum() for k in range(2)]), energy


ONE_HEX = moved(grid((1, 1, 1)), 0.08, seed=1)
"""A cube whose corners are pushed about, so that none of its faces is flat."""
