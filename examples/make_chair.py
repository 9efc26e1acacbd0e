"""A chair as one solid, its edges rounded, written as STEP.

    python make_chair.py chair.step

A seat with a back and four round legs. Lengths in mm, the floor at z = 0, the back at y > 0.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np

from contiga_validation.rivals.headform import (
    cylinder,
    filleted,
    joined,
    only_solid,
    write_step,
)

WIDTH, DEPTH, SEAT, HEIGHT = 400.0, 400.0, 450.0, 800.0
"""Of the seat, height of its upper side, and of the back."""
THICKNESS, EDGE, LEG = 40.0, 12.0, 18.0
"""Of seat and back, the radius of their edges, and of the legs."""


def box(low: tuple[float, float, float], high: tuple[float, float, float]) -> Any:
    """A block between two corners."""
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox
    from OCP.gp import gp_Pnt

    return BRepPrimAPI_MakeBox(gp_Pnt(*low), gp_Pnt(*high)).Shape()


def chair() -> Any:
    """The solid."""
    x, y = 0.5 * WIDTH, 0.5 * DEPTH
    seat = box((-x, -y, SEAT - THICKNESS), (x, y, SEAT))
    back = box((-x, y - THICKNESS, SEAT - THICKNESS), (x, y, HEIGHT))
    # neither where they meet: what is round there is left of the other as a sliver
    seat = filleted(seat, EDGE, lambda points: not np.allclose(points[:, 1], y))
    back = filleted(back, EDGE, lambda points: not np.allclose(points[:, 2], SEAT - THICKNESS))
    whole = joined(seat, back)
    for side_x in (-1.0, 1.0):
        for side_y in (-1.0, 1.0):
            foot = (side_x * (x - 40.0), side_y * (y - 40.0), 0.0)
            leg = cylinder(foot, (0.0, 0.0, 1.0), LEG, SEAT - 0.5 * THICKNESS)
            whole = joined(whole, leg)
    return whole


if __name__ == "__main__":
    write_step(only_solid(chair()), Path(sys.argv[1] if len(sys.argv) > 1 else "chair.step"))
