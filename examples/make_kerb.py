"""A road with a kerb across it as one solid, its upper edge rounded, written as STEP.

    python make_kerb.py kerb.step

Lengths in mm, the road at z = 0, the kerb beyond x = 200.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np

from contiga_validation.rivals.headform import filleted, joined, only_solid, write_step

HEIGHT, EDGE, AT = 30.0, 12.0, 200.0
"""Of the kerb, the radius of its edge, and where it begins."""


def box(low: tuple[float, float, float], high: tuple[float, float, float]) -> Any:
    """A block between two corners."""
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox
    from OCP.gp import gp_Pnt

    return BRepPrimAPI_MakeBox(gp_Pnt(*low), gp_Pnt(*high)).Shape()


def kerb() -> Any:
    """The solid."""
    road = box((-450.0, -150.0, -40.0), (AT, 150.0, 0.0))
    walk = box((AT, -150.0, -40.0), (700.0, 150.0, HEIGHT))

    def upper_edge(points: np.ndarray) -> bool:
        return np.allclose(points[:, 0], AT) and np.allclose(points[:, 2], HEIGHT)

    return filleted(joined(road, walk), EDGE, upper_edge)


if __name__ == "__main__":
    write_step(only_solid(kerb()), Path(sys.argv[1] if len(sys.argv) > 1 else "kerb.step"))
