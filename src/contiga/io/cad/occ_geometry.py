"""OpenCASCADE curves and surfaces as NURBS of contiga. Reached only from `step_iges`."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from contiga.geometry.curve import NurbsCurve
from contiga.geometry.surface import NurbsSurface
from contiga.io.cad.chart import cut_down
from contiga.io.cad.loops import whole_periods
from contiga.io.cad.occ_approximation import approximated, largest_miss
from contiga.io.cad.warp import AngleMap, Map, identity
from contiga.records import FloatArray

EXACT = 1e-10
"""Largest miss of an analytic surface's rational form, as a share of the size."""


class Patch(NamedTuple):
    """A converted surface and the change of its parameters."""

    surface: NurbsSurface
    maps: tuple[Map, Map]
    """Maps old u → new u and old v → new v."""
    off: float = 0.0
    """Largest distance from the surface of an approximation, length."""


def _values(array: Any) -> FloatArray:
    # Ending an iteration costs the bindings a C++ exception: counting is ten times faster.
    count = range(array.Lower(), array.Upper() + 1)
    return np.array([array.Value(i) for i in count], dtype=np.float64)


def _rational(weights: FloatArray) -> FloatArray | None:
    return None if np.ptp(weights) <= 1e-15 * abs(weights).max() else weights


def surface_from(spline: Any, shift: FloatArray, scale: float) -> NurbsSurface:
    """Return a `Geom_BSplineSurface` that is not periodic; knots + `shift`, points · `scale`."""
    n, m = spline.NbUPoles(), spline.NbVPoles()
    points = np.empty((n, m, 3))
    weights = np.ones((n, m))
    rational = spline.IsURational() or spline.IsVRational()
    for i in range(n):
        for j in range(m):
            pole = spline.Pole(i + 1, j + 1)
            points[i, j] = pole.X(), pole.Y(), pole.Z()
            if rational:
                weights[i, j] = spline.Weight(i + 1, j + 1)
    knots = (_values(spline.UKnotSequence()) + shift[0], _values(spline.VKnotSequence()) + shift[1])
    degrees = (spline.UDegree(), spline.VDegree())
    return NurbsSurface(degrees, knots, points * scale, _rational(weights))


def curve_from(spline: Any, scale: float = 1.0) -> NurbsCurve:
    """Return a `Geom_BSplineCurve` or `Geom2d_BSplineCurve`; coordinates times `scale`."""
    if spline.IsPeriodic():
        spline = spline.Copy()
        spline.SetNotPeriodic()
    poles = [spline.Pole(i + 1) for i in range(spline.NbPoles())]
    plane = not hasattr(poles[0], "Z")
    points = np.array([(p.X(), p.Y()) if plane else (p.X(), p.Y(), p.Z()) for p in poles])
    weights = np.ones(len(poles))
    if spline.IsRational():
        weights = np.array([spline.Weight(i + 1) for i in range(len(poles))])
    return NurbsCurve(
        spline.Degree(), _values(spline.KnotSequence()), points * scale, _rational(weights)
    )


def pcurve_from(curve: Any, first: float, last: float) -> NurbsCurve:
    """Return a `Geom2d_Curve` over [first, last], by growing parameter; lines get degree 1."""
    from OCP.Geom2d import Geom2d_BSplineCurve, Geom2d_Line, Geom2d_TrimmedCurve
    from OCP.Geom2dConvert import Geom2dConvert

    base = curve
    while isinstance(base, Geom2d_TrimmedCurve):
        base = base.BasisCurve()
    if isinstance(base, Geom2d_Line):
        a, b = base.Value(first), base.Value(last)
        return NurbsCurve(1, [first, first, last, last], [[a.X(), a.Y()], [b.X(), b.Y()]])
    if isinstance(base, Geom2d_BSplineCurve):
        return _part(base, first, last, 1.0)
    trimmed = Geom2d_TrimmedCurve(base, first, last)
    return curve_from(Geom2dConvert.CurveToBSplineCurve_s(trimmed))


def curve3d_from(curve: Any, first: float, last: float, scale: float) -> NurbsCurve:
    """Return a `Geom_Curve` over [first, last], by growing parameter."""
    from OCP.Geom import Geom_BSplineCurve, Geom_TrimmedCurve
    from OCP.GeomConvert import GeomConvert

    base = curve
    while isinstance(base, Geom_TrimmedCurve):
        base = base.BasisCurve()
    if isinstance(base, Geom_BSplineCurve):
        return _part(base, first, last, scale)
    trimmed = Geom_TrimmedCurve(base, first, last)
    return curve_from(GeomConvert.CurveToBSplineCurve_s(trimmed), scale)


def _part(spline: Any, first: float, last: float, scale: float) -> NurbsCurve:
    """Return a B-spline over [first, last]; a periodic one is unrolled over the interval."""
    period = spline.Period() if spline.IsPeriodic() else 0.0
    curve = curve_from(spline, scale)
    a, b = curve.domain
    near = 1e-9 * (b - a)
    if period:
        turns = math.floor((first + near - a) / period)
        curve = _shift(curve, turns * period)
        a, b = curve.domain
        if last > b + near:
            curve = _join(curve, _shift(curve, period))
            b = curve.domain[1]
    low = a if first - a <= near else first
    high = b if b - last <= near else last
    return curve if (low, high) == (a, b) else curve.restricted(low, high)


def _shift(curve: NurbsCurve, by: float) -> NurbsCurve:
    return NurbsCurve(curve.degree, curve.knots + by, curve.control_points, curve.weights)


def _join(one: NurbsCurve, two: NurbsCurve) -> NurbsCurve:
    """Join two curves of one degree that meet."""
    p = one.degree
    knots = np.concatenate([one.knots[:-1], two.knots[p + 1 :]])
    points = np.concatenate([one.control_points, two.control_points[1:]])
    weights = None
    if one.weights is not None and two.weights is not None:
        weights = np.concatenate(
            [one.weights, two.weights[1:] * (one.weights[-1] / two.weights[0])]
        )
    return NurbsCurve(p, knots, points, weights)


def periods_of(surface: Any) -> FloatArray:
    """Return the periods (2,) in u and v, 0 if there is none."""
    return np.array(
        [
            surface.UPeriod() if surface.IsUPeriodic() else 0.0,
            surface.VPeriod() if surface.IsVPeriodic() else 0.0,
        ]
    )


def base_surface(surface: Any) -> Any:
    """Return the surface below any rectangular trimming."""
    from OCP.Geom import Geom_RectangularTrimmedSurface

    while isinstance(surface, Geom_RectangularTrimmedSurface):
        surface = surface.BasisSurface()
    return surface


def speed_of(surface: Any, box: FloatArray) -> FloatArray:
    """Return the largest |S_u|, |S_v| (2,) at a few points of `box`."""
    from OCP.gp import gp_Pnt, gp_Vec

    best = np.zeros(2)
    point, du, dv = gp_Pnt(), gp_Vec(), gp_Vec()
    for u in np.linspace(box[0, 0], box[1, 0], 4):
        for v in np.linspace(box[0, 1], box[1, 1], 4):
            surface.D1(float(u), float(v), point, du, dv)
            best = np.maximum(best, [du.Magnitude(), dv.Magnitude()])
    return best


def patch_from(surface: Any, box: FloatArray, whole: bool, scale: float) -> Patch:
    """Return `surface` as a NURBS patch.

    Parameters
    ----------
    surface : Geom_Surface below any rectangular trimming
    box : (2, 2) low and high (u, v) of the face
    whole : keep a B-spline's full natural rectangle instead of cutting it down to `box`
    scale : factor on coordinates

    B-splines, Bézier patches and planes keep their parameters; circles of analytic surfaces get
    an `AngleMap`. What has no exact form (offset surfaces) is approximated by OpenCASCADE to
    `EXACT` · size at best, with its parameters kept.
    """
    from OCP.Geom import Geom_BezierSurface, Geom_BSplineSurface, Geom_Plane

    if isinstance(surface, Geom_Plane):
        return Patch(_plane(surface, box, scale), (identity, identity))
    if isinstance(surface, Geom_BezierSurface):
        from OCP.GeomConvert import GeomConvert

        surface = GeomConvert.SurfaceToBSplineSurface_s(surface)
    if isinstance(surface, Geom_BSplineSurface):
        spline = surface_from(*_cut_open(surface, box), scale)
        return Patch(spline if whole else cut_down(spline, box), (identity, identity))
    return _analytic(surface, box, scale)


def _plane(plane: Any, box: FloatArray, scale: float) -> NurbsSurface:
    (u0, v0), (u1, v1) = box
    net = np.empty((2, 2, 3))
    for i, u in enumerate((u0, u1)):
        for j, v in enumerate((v0, v1)):
            point = plane.Value(float(u), float(v))
            net[i, j] = point.X(), point.Y(), point.Z()
    return NurbsSurface((1, 1), ([u0, u0, u1, u1], [v0, v0, v1, v1]), net * scale)


def _cut_open(surface: Any, box: FloatArray) -> tuple[Any, FloatArray]:
    """Return a copy that is not periodic, cut where `box` begins, and its knots' shift.

    Where a period starts is arbitrary, so the cut goes where the face begins; OpenCASCADE may
    number the cut surface a period further on.
    """
    spline = surface.Copy()
    periods = periods_of(spline)
    if not periods.any():
        return spline, np.zeros(2)
    u0, u1, v0, v1 = spline.Bounds()
    natural = np.array([[u0, v0], [u1, v1]])
    part = np.where(periods > 0.0, box, natural)
    part[1] = np.where(periods > 0.0, np.minimum(part[1], part[0] + periods), part[1])
    spline.Segment(*(float(x) for x in (part[0, 0], part[1, 0], part[0, 1], part[1, 1])))
    return spline, _unroll(spline, part[0], periods)


def _unroll(spline: Any, start: FloatArray, periods: FloatArray) -> FloatArray:
    """Make a spline not periodic; return whole periods from its first knots to `start` (u, v)."""
    if spline.IsUPeriodic():
        spline.SetUNotPeriodic()
    if spline.IsVPeriodic():
        spline.SetVNotPeriodic()
    u0, _, v0, _ = spline.Bounds()
    return whole_periods(start - np.array([u0, v0]), periods)


def _analytic(surface: Any, box: FloatArray, scale: float) -> Patch:
    """Return the exact rational form of a surface with circles; a whole turn is two halves.

    OpenCASCADE converts a whole turn by cutting a periodic spline at a parameter that is not the
    angle, so that it starts in the wrong place; halves come out right.
    """
    from OCP.Geom import Geom_RectangularTrimmedSurface

    for axis, period in enumerate(periods_of(surface)):
        if period > 0.0 and box[1, axis] - box[0, axis] > 0.95 * period:
            parts = np.array([box, box])
            parts[0, 1, axis] = parts[1, 0, axis] = 0.5 * (box[0, axis] + box[1, axis])
            one, two = (_analytic(surface, part, scale) for part in parts)
            joined = _joined_patches(one, two, axis)
            if joined is not None:
                return joined
    (u0, v0), (u1, v1) = (tuple(map(float, corner)) for corner in box)
    trimmed = Geom_RectangularTrimmedSurface(surface, u0, u1, v0, v1)
    exact = _exact_form(surface, trimmed, box)
    if exact is not None:
        spline, shift, maps = exact
        return Patch(surface_from(spline, shift, scale), maps)
    near = approximated(trimmed)
    off = largest_miss(trimmed, near) * scale
    return Patch(surface_from(near, np.zeros(2), scale), (identity, identity), off)


def _exact_form(
    surface: Any, trimmed: Any, box: FloatArray
) -> tuple[Any, FloatArray, tuple[Map, Map]] | None:
    """Return rational form, shift of knots and parameter maps of a trimmed surface, or None."""
    from OCP.GeomConvert import GeomConvert

    try:
        spline = GeomConvert.SurfaceToBSplineSurface_s(trimmed)
    except Exception:  # OpenCASCADE raises its own kinds for surfaces without an exact form
        return None
    shift = _unroll(spline, box[0], periods_of(surface))
    for maps in _possible_maps(spline, shift):
        if _agrees(surface, spline, maps, (box, shift)):
            return spline, shift, maps
    return None


def _joined_patches(one: Patch, two: Patch, axis: int) -> Patch | None:
    """Join two patches that meet at a line of constant u (axis 0) or v; None if unlike."""
    a, b = one.surface, two.surface
    other = 1 - axis
    if a.degrees != b.degrees or not np.array_equal(a.knots[other], b.knots[other]):
        return None
    p = a.degrees[axis]
    knots = list(a.knots)
    knots[axis] = np.concatenate([a.knots[axis][:-1], b.knots[axis][p + 1 :]])
    weights = [
        np.ones(s.control_points.shape[:2]) if s.weights is None else s.weights for s in (a, b)
    ]
    rest = (slice(1, None), slice(None)) if axis == 0 else (slice(None), slice(1, None))
    points = np.concatenate([a.control_points, b.control_points[rest]], axis=axis)
    joined = np.concatenate([weights[0], weights[1][rest]], axis=axis)
    maps = list(one.maps)
    first, second = one.maps[axis], two.maps[axis]
    if isinstance(first, AngleMap) and isinstance(second, AngleMap):
        maps[axis] = AngleMap(np.concatenate([first.breaks, second.breaks[1:]]))
    elif first is not second:
        return None
    surface = NurbsSurface(a.degrees, (knots[0], knots[1]), points, _rational(joined))
    return Patch(surface, (maps[0], maps[1]), max(one.off, two.off))


def _possible_maps(spline: Any, shift: FloatArray) -> list[tuple[Map, Map]]:
    """Return the parameter maps a conversion may have made: angles in both, in u, in v, in none."""
    of_u: list[Map] = [identity]
    of_v: list[Map] = [identity]
    if spline.UDegree() == 2:
        of_u.insert(0, AngleMap(_values(spline.UKnots()) + shift[0]))
    if spline.VDegree() == 2:
        of_v.insert(0, AngleMap(_values(spline.VKnots()) + shift[1]))
    return list(product(of_u, of_v))


def _agrees(
    surface: Any, spline: Any, maps: tuple[Map, Map], place: tuple[FloatArray, FloatArray]
) -> bool:
    """Return whether the spline at mapped parameters is the surface, on a grid off all symmetries.

    `place` is the box of the face and the shift of the spline's knots.
    """
    box, shift = place
    share = np.array([0.0, 0.137, 0.291, 0.418, 0.593, 0.761, 0.902, 1.0])
    u = box[0, 0] + share * (box[1, 0] - box[0, 0])
    v = box[0, 1] + share * (box[1, 1] - box[0, 1])
    u0, u1, v0, v1 = spline.Bounds()
    mapped_u = np.clip(maps[0](u) - shift[0], u0, u1)
    mapped_v = np.clip(maps[1](v) - shift[1], v0, v1)
    worst, size = 0.0, 0.0
    origin = surface.Value(float(u[0]), float(v[0]))
    for a, x in zip(u, mapped_u, strict=True):
        for b, y in zip(v, mapped_v, strict=True):
            point = surface.Value(float(a), float(b))
            worst = max(worst, point.Distance(spline.Value(float(x), float(y))))
            size = max(size, point.Distance(origin), abs(point.X()), abs(point.Y()))
    return worst <= EXACT * size


@contextmanager
def quiet() -> Iterator[None]:
    """Keep OpenCASCADE's messages off the terminal."""
    from OCP.Message import Message

    printers = Message.DefaultMessenger_s().ChangePrinters()
    kept = list(printers)
    printers.Clear()
    try:
        yield
    finally:
        for printer in kept:
            printers.Append(printer)
