"""Surfaces of revolution that intersect themselves on their axis: lemons and apples.

A torus whose tube reaches over its axis (STEP's `DEGENERATE_TOROIDAL_SURFACE`), or any meridian
that crosses its axis of revolution, makes a surface with an outer and an inner part. A face on one
of them is sound. A face on both has no side: it meets itself where its meridian crosses the axis.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from contiga.errors import FileError
from contiga.records import FloatArray

N_SAMPLES = 257
"""Samples of a meridian."""
MARGIN = 1e-7
"""Share of an interval by which a face may extend over a crossing: rounding of its bounds."""
MAX_BISECTIONS = 60
"""Number of bisections of a crossing, down to rounding."""

Point = tuple[float, float, float]


def refuse_self_intersection(surface: Any, box: FloatArray, scale: float, where: str) -> None:
    """Refuse a face over `box` that intersects itself; `scale` is for the lengths in the message.

    Raises
    ------
    FileError
        The face intersects itself.
    """
    point = self_intersection(surface, box)
    if point is not None:
        x, y, z = (scale * c for c in point)
        raise FileError(
            "a face goes through itself: it has no side",
            where=where,
            found=f"an outer and an inner part that meet at ({x:.6g}, {y:.6g}, {z:.6g})",
            allowed="one of them: the apple or the lemon of a torus that reaches over its axis",
            remedy="Cut it there in the program that wrote the file, or choose other parts",
        )


def self_intersection(surface: Any, box: FloatArray) -> Point | None:
    """Return a point on its axis where a face over `box` (low, high (u, v)) meets itself, or None.

    Only tori and surfaces of revolution are checked; a crossing within `MARGIN` of the ends of the
    meridian does not count. Coordinates are OpenCASCADE's.
    """
    from OCP.Geom import Geom_SurfaceOfRevolution, Geom_ToroidalSurface

    (u, low), (_, high) = box.tolist()
    crossing: float | None = None
    if isinstance(surface, Geom_ToroidalSurface):
        # The tube crosses the axis where major + minor cos(v) changes its sign.
        major, minor = surface.MajorRadius(), surface.MinorRadius()
        margin = MARGIN * (high - low)
        angles = [math.acos(-major / minor), -math.acos(-major / minor)] if minor > major else []
        for first in angles:
            turns = math.ceil((low + margin - first) / (2.0 * math.pi))
            v = first + 2.0 * math.pi * turns
            if v < high - margin:
                crossing = v
                break
    elif isinstance(surface, Geom_SurfaceOfRevolution):
        crossing = _axis_crossing(surface, low, high)
    if crossing is None:
        return None
    point = surface.Value(u, crossing)
    return point.X(), point.Y(), point.Z()


def _axis_crossing(surface: Any, low: float, high: float) -> float | None:
    """Return the first parameter in (low, high) at which a meridian crosses its axis, or None.

    Crossings are sought between `N_SAMPLES` samples, where the direction from the axis turns back;
    two within one interval are missed. A turn farther from the axis than `MARGIN` of the largest
    radius does not count.
    """
    curve, axis = surface.BasisCurve(), surface.Axis()
    location, direction = axis.Location(), axis.Direction()
    origin = np.array([location.X(), location.Y(), location.Z()])
    unit = np.array([direction.X(), direction.Y(), direction.Z()])

    def radius_vector(v: float) -> FloatArray:
        point = curve.Value(v)
        offset = np.array([point.X(), point.Y(), point.Z()]) - origin
        return offset - (offset @ unit) * unit

    margin = MARGIN * (high - low)
    places = np.linspace(low + margin, high - margin, N_SAMPLES)
    rows = np.array([radius_vector(v) for v in places.tolist()])
    largest = float(np.linalg.norm(rows, axis=1).max())
    for k in np.flatnonzero((rows[1:] * rows[:-1]).sum(axis=1) < 0.0).tolist():
        a, b = float(places[k]), float(places[k + 1])
        for _ in range(MAX_BISECTIONS):
            middle = 0.5 * (a + b)
            is_same_side = radius_vector(middle) @ radius_vector(b) > 0.0
            a, b = (a, middle) if is_same_side else (middle, b)
        if np.linalg.norm(radius_vector(a)) <= MARGIN * largest:
            return a
    return None
