"""Radii of touching balls at feet, as kernels of contact ask for them."""

from __future__ import annotations

import numpy as np

import contiga as cg
from contiga.records import SurfacePlaces
from contiga.search.balls.kernels import ball_nb
from contiga.search.balls.radii import balls_of
from contiga.search.tables import tables_of


def radii_at(body: cg.Body, patch: np.ndarray, uv: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(n,) of the balls inside, and of those on the free side; zero where none is known."""
    tables, n = tables_of(body), len(patch)
    rows, inside, outside = np.arange(n, dtype=np.int32), np.empty(n), np.empty(n)
    for side, out in enumerate((inside, outside)):
        sides, feet = np.full(n, side, np.int8), SurfacePlaces(patch, uv)
        ball_nb.radii(balls_of(tables), tables.grid, feet, rows, sides, out, 0, n)
    return inside, outside
