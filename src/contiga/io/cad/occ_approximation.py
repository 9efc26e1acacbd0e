"""Approximations of surfaces without an exact NURBS form (offset surfaces), and their error."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from contiga.errors import GeometryError

GRID = 41
"""Points in each direction at which an approximation is compared."""


def approximated(trimmed: Any) -> Any:
    """Return a B-spline near `trimmed` with the same parameters, as close as OpenCASCADE gets."""
    from OCP.GeomAbs import GeomAbs_Shape
    from OCP.GeomConvert import GeomConvert_ApproxSurface

    u0, u1, v0, v1 = trimmed.Bounds()
    corner = trimmed.Value(u0, v0)
    size = max(
        corner.Distance(trimmed.Value(u, v)) for u in (u0, u1) for v in (v0, 0.5 * (v0 + v1), v1)
    )
    smooth = GeomAbs_Shape.GeomAbs_C1
    for tolerance in (1e-8, 1e-7, 1e-6, 1e-5):
        made = GeomConvert_ApproxSurface(
            trimmed, tolerance * max(size, 1e-3), smooth, smooth, 9, 9, 200, 1
        )
        if made.IsDone() and made.HasResult() and math.isfinite(made.MaxError()):
            return made.Surface()
    raise GeometryError(
        "its surface has no NURBS form and could not be approximated",
        found=type(trimmed.BasisSurface()).__name__,
    )


def largest_miss(surface: Any, near: Any) -> float:
    """Return the largest error, on a grid, of an approximation with the same parameters."""
    u0, u1, v0, v1 = surface.Bounds()
    places = [(u, v) for u in np.linspace(u0, u1, GRID) for v in np.linspace(v0, v1, GRID)]
    return max(float(surface.Value(u, v).Distance(near.Value(u, v))) for u, v in places)
