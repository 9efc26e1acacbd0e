"""The scenes of the benchmarks: surfaces, bodies, and points that move near them."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

import contiga as cg

NET = 12
OFFSET = 0.02
STEP = 1e-3
NIST = Path(__file__).resolve().parents[2] / "shared" / "data" / "nist_ctc_02_asme1_ap242.stp"
"""A public test part: https://www.nist.gov/ctl/smart-connected-systems-division, MBE PMI CTC 02."""


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
    for k in range(1, steps + 1):
        yield moved(start, k)


def moved(start: np.ndarray, k: int, step: float = STEP) -> np.ndarray:
    """A fresh array of the points, `k` small sideways and downward steps on."""
    direction = np.array([0.6, 0.3, -0.2])
    return start + (k * step / np.linalg.norm(direction)) * direction


def around(body: cg.Body, n: int, touching: float, seed: int = 2) -> np.ndarray:
    """(n, 3) points in no order over a body: a share of them in it, the others outside.

    Those in it are up to 1e-3 of the body's size deep, the others up to 5e-2 away.
    """
    rng = np.random.default_rng(seed)
    areas = np.array([patch.net_area() for patch in body.patches])
    counts = np.ceil(n * areas / areas.sum()).astype(int)
    on = [cg.clouds.random_on(p, int(k), seed=3) for p, k in zip(body.patches, counts, strict=True)]
    feet = body.project(rng.permutation(np.concatenate(on))[:n])
    inside = rng.random(n) < touching
    gap = rng.random(n) * np.where(inside, -1e-3, 5e-2) * body.size
    return feet.point + gap[:, None] * feet.normal


class Tracker:
    """Continues a projection over the steps it is given."""

    def __init__(self, master: cg.Body | cg.TriMesh, start: np.ndarray) -> None:
        self.master = master
        self.feet = master.project(start)

    def __call__(self, p: np.ndarray) -> None:
        self.feet = self.master.project(p, start=self.feet, mode="track")
