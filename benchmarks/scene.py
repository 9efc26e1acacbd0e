"""The scene of the benchmarks: a bicubic rational surface and points that move near it."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

import contiga as cg

NET = 12
OFFSET = 0.02
STEP = 1e-3


def surface(seed: int = 0) -> cg.NurbsSurface:
    """A wavy bicubic rational surface over the unit square, 12 × 12 control points."""
    rng = np.random.default_rng(seed)
    x = np.linspace(0.0, 1.0, NET)
    net = np.empty((NET, NET, 3))
    net[..., 0], net[..., 1] = np.meshgrid(x, x, indexing="ij")
    net[..., 2] = 0.06 * rng.normal(size=(NET, NET))
    weights = rng.uniform(0.5, 2.0, (NET, NET))
    knots = np.concatenate((np.zeros(3), np.linspace(0.0, 1.0, NET - 2), np.ones(3)))
    return cg.NurbsSurface((3, 3), (knots, knots), net, weights)


def points(patch: cg.NurbsSurface, n: int, order: str, seed: int = 1) -> np.ndarray:
    """(n, 3) points within `OFFSET` of the surface, away from its border.

    order "sorted": along the surface, as nodes of a mesh come; "shuffled": at random.
    """
    rng = np.random.default_rng(seed)
    side = int(np.ceil(np.sqrt(n)))
    grid = np.linspace(0.05, 0.95, side)
    uv = np.stack(np.meshgrid(grid, grid, indexing="ij"), axis=-1).reshape(-1, 2)[:n]
    if order == "shuffled":
        uv = rng.permutation(uv)
    gap = rng.uniform(-OFFSET, OFFSET, (n, 1))
    return patch.evaluate(uv) + gap * patch.normal(uv)


def path(start: np.ndarray, steps: int) -> Iterator[np.ndarray]:
    """Fresh arrays of the points, one small sideways and downward step further each time."""
    direction = np.array([0.6, 0.3, -0.2])
    direction *= STEP / np.linalg.norm(direction)
    for k in range(1, steps + 1):
        yield start + k * direction
