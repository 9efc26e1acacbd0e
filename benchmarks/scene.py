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

HEADFORM = NIST.with_name("headface_MED_full.step")
"""An open face of 123 splines: https://github.com/tetrabiodistributed/papr-print-files."""


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
    return with_feet(patch, n, order, seed)[0]


def with_feet(
    patch: cg.NurbsSurface, n: int, order: str, seed: int = 1
) -> tuple[np.ndarray, cg.Projection]:
    """The same points, and their feet on a body of the patch, known without a search."""
    rng = np.random.default_rng(seed)
    side = int(np.ceil(np.sqrt(n)))
    grid = np.linspace(0.05, 0.95, side)
    uv = np.stack(np.meshgrid(grid, grid, indexing="ij"), axis=-1).reshape(-1, 2)[:n]
    if order == "shuffled":
        uv = rng.permutation(uv)
    gap = rng.uniform(-OFFSET, OFFSET, n)
    foot, normal = patch.evaluate(uv), patch.normal(uv)
    codes = np.zeros(n, np.int32), np.full(n, cg.Feature.FACE, np.int8), np.zeros(n, np.int8)
    feet = cg.Projection(codes[0], uv, foot, normal, gap, codes[1], codes[2], codes[2])
    return foot + gap[:, None] * normal, feet


def path(start: np.ndarray, steps: int) -> Iterator[np.ndarray]:
    """Fresh arrays of the points, one small sideways and downward step further each time."""
    for k in range(1, steps + 1):
        yield moved(start, k)


def moved(start: np.ndarray, k: int, step: float = STEP) -> np.ndarray:
    """A fresh array of the points, `k` small sideways and downward steps on."""
    direction = np.array([0.6, 0.3, -0.2])
    return start + (k * step / np.linalg.norm(direction)) * direction


def around(body: cg.Body, n: int, touching: float, seed: int = 2) -> tuple[np.ndarray, np.ndarray]:
    """Points (n, 3) in no order over a body, all outside, and where a share of them has come in.

    Those that come in go from as far outside as they are then inside, up to 1e-3 of the body's
    size; the others stay, up to 5e-2 away.
    """
    rng = np.random.default_rng(seed)
    areas = np.array([patch.net_area() for patch in body.patches])
    counts = np.ceil(n * areas / areas.sum()).astype(int)
    on = [cg.clouds.random_on(p, int(k), seed=3) for p, k in zip(body.patches, counts, strict=True)]
    feet = body.project(rng.permutation(np.concatenate(on))[:n])
    inside = rng.random(n) < touching
    away = (rng.random(n) * np.where(inside, 1e-3, 5e-2) * body.size)[:, None] * feet.normal
    return feet.point + away, feet.point + np.where(inside, -1.0, 1.0)[:, None] * away


class Tracker:
    """Continues a projection over the steps it is given; `feet` of the start, or found.

    From the second step on feet are written over those of the step before, as a solver would.
    """

    def __init__(
        self,
        master: cg.Body | cg.TriMesh,
        start: np.ndarray,
        feet: cg.Projection | None = None,
    ) -> None:
        self.master = master
        self.feet = master.project(start) if feet is None else feet
        self.out: cg.Projection | None = None

    def __call__(self, p: np.ndarray) -> None:
        self.feet = self.out = self.master.project(p, start=self.feet, mode="track", out=self.out)
