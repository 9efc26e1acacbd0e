"""Surfaces of revolution that intersect themselves on their axis: lemons and apples.

A torus whose tube reaches over its axis (STEP's `DEGENERATE_TOROIDAL_SURFACE`), or any meridian
that crosses the axis it is turned about, makes a surface with an outer and an inner part. A face on
one of them is sound. On both it has no side: it meets itself where its meridian crosses the axis.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from contiga.errors import FileError
from contiga.records import FloatArray

SAMPLES = 257
"""Samples of a meridian."""
WITHIN = 1e-7
"""Share of an interval by which a face may extend over a crossing: rounding of its bounds."""

Point = tuple[float, float, float]


def refuse_pierced(surface: Any, box: FloatArray, scale: float, where: str) -> None:
    """Refuse a face over `box` that intersects itself; `scale` is for the lengths in the message.

    Raises
    ------
    FileError
        As said.
    """
    point = pierced_at(surface, box)
    if point is not None:
        x, y, z = (scale * c for c in point)
        raise FileError(
            "a face goes through itself: it has no side",
            where=where,
            found=f"an outer and an inner part that meet at ({x:.6g}, {y:.6g}, {z:.6g})",
            allowed="one of them: the apple or the lemon of a torus that reaches over its axis",
            remedy="Cut it there in the program that wrote the file, or choose other parts",
        )


def pierced_at(surface: Any, box: FloatArray) -> Point | None:
    """Return a point where a face over `box` (low and high (u, v)) intersects itself, or None.

    Tori and surfaces of revolution are looked at.
    """
    from OCP.Geom import Geom_SurfaceOfRevolution, Geom_ToroidalSurface

    (u, low), (_, high) = box.tolist()
    if isinstance(surface, Geom_ToroidalSurface):
        at = _of_torus(surface.MajorRadius(), surface.MinorRadius(), low, high)
    elif isinstance(surface, Geom_SurfaceOfRevolution):
        at = _of_meridian(surface, low, high)
    else:
        return None
    if at is None:
        return None
    point = surface.Value(u, at)
    return point.X(), point.Y(), point.Z()


def _of_torus(major: float, minor: float, low: float, high: float) -> float | None:
    """Return where major + minor cos(v) changes its sign between `low` and `high`."""
    if not minor > major:
        return None
    half = math.acos(-major / minor)
    margin = WITHIN * (high - low)
    for crossing in (half, -half):
        turns = math.ceil((low + margin - crossing) / (2.0 * math.pi))
        at = crossing + 2.0 * math.pi * turns
        if at < high - margin:
            return at
    return None


def _of_meridian(surface: Any, low: float, high: float) -> float | None:
    """Return where a meridian crosses its axis of revolution, between `low` and `high`."""
    curve, axis = surface.BasisCurve(), surface.Axis()
    origin, direction = axis.Location(), axis.Direction()
    begin = np.array([origin.X(), origin.Y(), origin.Z()])
    way = np.array([direction.X(), direction.Y(), direction.Z()])

    def off(v: float) -> FloatArray:
        point = curve.Value(v)
        along = np.array([point.X(), point.Y(), point.Z()]) - begin
        return along - (along @ way) * way

    margin = WITHIN * (high - low)
    places = np.linspace(low + margin, high - margin, SAMPLES)
    rows = np.array([off(v) for v in places.tolist()])
    reach = float(np.linalg.norm(rows, axis=1).max())
    for k in np.flatnonzero((rows[1:] * rows[:-1]).sum(axis=1) < 0.0).tolist():
        a, b = float(places[k]), float(places[k + 1])
        for _ in range(60):
            middle = 0.5 * (a + b)
            a, b = (a, middle) if off(middle) @ off(b) > 0.0 else (middle, b)
        if np.linalg.norm(off(a)) <= WITHIN * reach:
            return a
    return None
