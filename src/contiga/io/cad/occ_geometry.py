"""OpenCASCADE curves and surfaces as NURBS of contiga."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from contiga.errors import GeometryError
from contiga.geometry.curve import NurbsCurve
from contiga.geometry.surface import NurbsSurface
from contiga.io.cad.chart import join_splines, restrict_patch
from contiga.io.cad.loops import whole_periods
from contiga.io.cad.warp import AngleMap, Map, identity
from contiga.records import FloatArray

EXACT_TOL = 1e-10
"""Largest error of an analytic surface's rational form, as a share of the size."""
APPROXIMATION_TOLS = (1e-8, 1e-7, 1e-6, 1e-5)
"""Tolerances of approximations that are tried in turn, as shares of the size."""
N_GRID = 41
"""Points in each direction at which an approximation is compared."""


class Patch(NamedTuple):
    """A converted surface and the change of its parameters."""

    surface: NurbsSurface
    maps: tuple[Map, Map]
    """Maps old u → new u and old v → new v."""
    error: float = 0.0
    """Largest distance of an approximation from the surface, length."""


def _values(array: Any) -> FloatArray:
    """Return the numbers (n,) of an array of OpenCASCADE."""
    # Ending an iteration costs the bindings a C++ exception: counting is ten times faster.
    count = range(array.Lower(), array.Upper() + 1)
    return np.array([array.Value(i) for i in count], dtype=np.float64)


def _weights_or_none(weights: FloatArray) -> FloatArray | None:
    """Return weights, or None if they are equal to a relative 1e-15."""
    return None if np.ptp(weights) <= 1e-15 * abs(weights).max() else weights


def surface_from(spline: Any, shift: FloatArray, scale: float) -> NurbsSurface:
    """Convert a `Geom_BSplineSurface` that is not periodic; knots + `shift` (2,), points · `scale`.

    Equal weights are dropped.
    """
    n, m = spline.NbUPoles(), spline.NbVPoles()
    points = np.empty((n, m, 3))
    weights = np.ones((n, m))
    is_rational = spline.IsURational() or spline.IsVRational()
    for i in range(n):
        for j in range(m):
            pole = spline.Pole(i + 1, j + 1)
            points[i, j] = pole.X(), pole.Y(), pole.Z()
            if is_rational:
                weights[i, j] = spline.Weight(i + 1, j + 1)
    knots = (_values(spline.UKnotSequence()) + shift[0], _values(spline.VKnotSequence()) + shift[1])
    degrees = (spline.UDegree(), spline.VDegree())
    return NurbsSurface(degrees, knots, points * scale, _weights_or_none(weights))


def curve_from(spline: Any, scale: float = 1.0) -> NurbsCurve:
    """Convert a `Geom_BSplineCurve` or `Geom2d_BSplineCurve`; coordinates times `scale`.

    A periodic one is opened at its start; equal weights are dropped.
    """
    if spline.IsPeriodic():
        spline = spline.Copy()
        spline.SetNotPeriodic()
    poles = [spline.Pole(i + 1) for i in range(spline.NbPoles())]
    is_planar = not hasattr(poles[0], "Z")
    points = np.array([(p.X(), p.Y()) if is_planar else (p.X(), p.Y(), p.Z()) for p in poles])
    weights = np.ones(len(poles))
    if spline.IsRational():
        weights = np.array([spline.Weight(i + 1) for i in range(len(poles))])
    return NurbsCurve(
        spline.Degree(), _values(spline.KnotSequence()), points * scale, _weights_or_none(weights)
    )


def pcurve_from(curve: Any, first: float, last: float) -> NurbsCurve:
    """Convert a `Geom2d_Curve` over [first, last], by growing parameter; lines get degree 1."""
    from OCP.Geom2d import Geom2d_BSplineCurve, Geom2d_Line, Geom2d_TrimmedCurve
    from OCP.Geom2dConvert import Geom2dConvert

    base = curve
    while isinstance(base, Geom2d_TrimmedCurve):
        base = base.BasisCurve()
    if isinstance(base, Geom2d_Line):
        a, b = base.Value(first), base.Value(last)
        return NurbsCurve(1, [first, first, last, last], [[a.X(), a.Y()], [b.X(), b.Y()]])
    if isinstance(base, Geom2d_BSplineCurve):
        return _spline_part(base, first, last, 1.0)
    trimmed = Geom2d_TrimmedCurve(base, first, last)
    return curve_from(Geom2dConvert.CurveToBSplineCurve_s(trimmed))


def curve3d_from(curve: Any, first: float, last: float, scale: float) -> NurbsCurve:
    """Convert a `Geom_Curve` over [first, last], by growing parameter; coordinates · `scale`."""
    from OCP.Geom import Geom_BSplineCurve, Geom_TrimmedCurve
    from OCP.GeomConvert import GeomConvert

    base = curve
    while isinstance(base, Geom_TrimmedCurve):
        base = base.BasisCurve()
    if isinstance(base, Geom_BSplineCurve):
        return _spline_part(base, first, last, scale)
    trimmed = Geom_TrimmedCurve(base, first, last)
    return curve_from(GeomConvert.CurveToBSplineCurve_s(trimmed), scale)


def _spline_part(spline: Any, first: float, last: float, scale: float) -> NurbsCurve:
    """Convert a B-spline over [first, last]; bounds within 1e-9 of the domain become the domain's.

    Coordinates are multiplied by `scale`. A periodic spline is shifted by whole periods, and
    doubled if the interval goes over its end.
    """
    period = spline.Period() if spline.IsPeriodic() else 0.0
    curve = curve_from(spline, scale)
    a, b = curve.domain
    near = 1e-9 * (b - a)
    if period:
        shift = period * math.floor((first + near - a) / period)
        curve = NurbsCurve(curve.degree, curve.knots + shift, curve.control_points, curve.weights)
        a, b = curve.domain
        if last > b + near:
            knots, points, weights = join_splines(
                curve.degree,
                (curve.knots, curve.control_points, curve.weights),
                (curve.knots + period, curve.control_points, curve.weights),
            )
            curve = NurbsCurve(curve.degree, knots, points, weights)
            b = curve.domain[1]
    low = a if first - a <= near else first
    high = b if b - last <= near else last
    return curve if (low, high) == (a, b) else curve.restricted(low, high)


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
    """Return the largest |S_u|, |S_v| (2,) at 4 × 4 points of `box`."""
    from OCP.gp import gp_Pnt, gp_Vec

    largest = np.zeros(2)
    point, du, dv = gp_Pnt(), gp_Vec(), gp_Vec()
    for u in np.linspace(box[0, 0], box[1, 0], 4):
        for v in np.linspace(box[0, 1], box[1, 1], 4):
            surface.D1(float(u), float(v), point, du, dv)
            largest = np.maximum(largest, [du.Magnitude(), dv.Magnitude()])
    return largest


def patch_from(surface: Any, box: FloatArray, whole: bool, scale: float) -> Patch:
    """Return `surface` as a NURBS patch over `box`.

    B-splines, Bézier patches and planes keep their parameters; circles of analytic surfaces get
    an `AngleMap`. Surfaces without an exact form (offset surfaces) are approximated by
    OpenCASCADE, to the first of `APPROXIMATION_TOLS` it reaches, and keep their parameters. A
    periodic B-spline is cut where the box begins, since the start of a period is arbitrary.

    Parameters
    ----------
    surface : Geom_Surface below any rectangular trimming
    box : (2, 2) low and high (u, v) of the face
    whole : keep a B-spline's full natural rectangle instead of cutting it down to `box`
    scale : factor on coordinates

    Raises
    ------
    GeometryError
        OpenCASCADE finds no approximation.
    """
    from OCP.Geom import Geom_BezierSurface, Geom_BSplineSurface, Geom_Plane

    if isinstance(surface, Geom_Plane):
        (u0, v0), (u1, v1) = box
        net = np.empty((2, 2, 3))
        for i, u in enumerate((u0, u1)):
            for j, v in enumerate((v0, v1)):
                point = surface.Value(float(u), float(v))
                net[i, j] = point.X(), point.Y(), point.Z()
        plane = NurbsSurface((1, 1), ([u0, u0, u1, u1], [v0, v0, v1, v1]), net * scale)
        return Patch(plane, (identity, identity))
    if isinstance(surface, Geom_BezierSurface):
        from OCP.GeomConvert import GeomConvert

        surface = GeomConvert.SurfaceToBSplineSurface_s(surface)
    if not isinstance(surface, Geom_BSplineSurface):
        return _analytic_patch(surface, box, scale)
    spline, shift = surface.Copy(), np.zeros(2)
    periods = periods_of(spline)
    if periods.any():
        u0, u1, v0, v1 = spline.Bounds()
        part = np.where(periods > 0.0, box, [[u0, v0], [u1, v1]])
        part[1] = np.where(periods > 0.0, np.minimum(part[1], part[0] + periods), part[1])
        spline.Segment(*(float(x) for x in (part[0, 0], part[1, 0], part[0, 1], part[1, 1])))
        shift = _unroll(spline, part[0], periods)
    patch = surface_from(spline, shift, scale)
    return Patch(patch if whole else restrict_patch(patch, box), (identity, identity))


def _unroll(spline: Any, start: FloatArray, periods: FloatArray) -> FloatArray:
    """Make `spline` itself not periodic; return the shift (2,) of its knots, in whole periods.

    OpenCASCADE may number knots a period later; the shift brings the first ones to `start` (u, v).
    """
    if spline.IsUPeriodic():
        spline.SetUNotPeriodic()
    if spline.IsVPeriodic():
        spline.SetVNotPeriodic()
    u0, _, v0, _ = spline.Bounds()
    return whole_periods(start - np.array([u0, v0]), periods)


def _analytic_patch(surface: Any, box: FloatArray, scale: float) -> Patch:
    """Return the exact rational form of a surface over `box`, or an approximation if it has none.

    A direction over more than 95 % of its period is made of two halves, if they fit together:
    OpenCASCADE converts a whole turn by cutting a periodic spline at a parameter that is not the
    angle, so that it starts in the wrong place; halves come out right.

    Raises
    ------
    GeometryError
        OpenCASCADE finds no approximation.
    """
    from OCP.Geom import Geom_RectangularTrimmedSurface

    for axis, period in enumerate(periods_of(surface)):
        if period > 0.0 and box[1, axis] - box[0, axis] > 0.95 * period:
            halves = np.array([box, box])
            halves[0, 1, axis] = halves[1, 0, axis] = 0.5 * (box[0, axis] + box[1, axis])
            first, second = (_analytic_patch(surface, half, scale) for half in halves)
            joined = _join_patches(first, second, axis)
            if joined is not None:
                return joined
    (u0, v0), (u1, v1) = (tuple(map(float, corner)) for corner in box)
    trimmed = Geom_RectangularTrimmedSurface(surface, u0, u1, v0, v1)
    exact = _exact_form(surface, trimmed, box)
    if exact is not None:
        spline, shift, maps = exact
        return Patch(surface_from(spline, shift, scale), maps)
    spline, error = _approximate(trimmed)
    return Patch(surface_from(spline, np.zeros(2), scale), (identity, identity), error * scale)


def _exact_form(
    surface: Any, trimmed: Any, box: FloatArray
) -> tuple[Any, FloatArray, tuple[Map, Map]] | None:
    """Return B-spline, shift (2,) of its knots and maps of u and v of a trimmed surface, or None.

    The maps are angles in both directions, in u, in v or in none: the first that `_is_same_surface`
    accepts. None if it accepts none, or OpenCASCADE has no form.
    """
    from OCP.GeomConvert import GeomConvert

    try:
        spline = GeomConvert.SurfaceToBSplineSurface_s(trimmed)
    except Exception:  # OpenCASCADE raises its own kinds for surfaces without an exact form
        return None
    shift = _unroll(spline, box[0], periods_of(surface))
    u_maps: list[Map] = [identity]
    v_maps: list[Map] = [identity]
    if spline.UDegree() == 2:
        u_maps.insert(0, AngleMap(_values(spline.UKnots()) + shift[0]))
    if spline.VDegree() == 2:
        v_maps.insert(0, AngleMap(_values(spline.VKnots()) + shift[1]))
    for maps in product(u_maps, v_maps):
        if _is_same_surface(surface, spline, maps, box, shift):
            return spline, shift, maps
    return None


def _join_patches(first: Patch, second: Patch, axis: int) -> Patch | None:
    """Return one patch of two that meet at a line of constant u (axis 0) or v.

    None if degrees, knots along the line, or the kinds of maps across it differ. Weights are taken
    as they are: the halves have equal ones at the line.
    """
    a, b = first.surface, second.surface
    if a.degrees != b.degrees or not np.array_equal(a.knots[1 - axis], b.knots[1 - axis]):
        return None
    maps = list(first.maps)
    first_map, second_map = first.maps[axis], second.maps[axis]
    if isinstance(first_map, AngleMap) and isinstance(second_map, AngleMap):
        maps[axis] = AngleMap(np.concatenate([first_map.breaks, second_map.breaks[1:]]))
    elif first_map is not second_map:
        return None
    p = a.degrees[axis]
    knots = list(a.knots)
    knots[axis] = np.concatenate([a.knots[axis][:-1], b.knots[axis][p + 1 :]])
    weights_a, weights_b = (
        np.ones(s.control_points.shape[:2]) if s.weights is None else s.weights for s in (a, b)
    )
    # The first row of the second patch is the last row of the first one.
    rows = (slice(1, None), slice(None)) if axis == 0 else (slice(None), slice(1, None))
    points = np.concatenate([a.control_points, b.control_points[rows]], axis=axis)
    weights = np.concatenate([weights_a, weights_b[rows]], axis=axis)
    surface = NurbsSurface(a.degrees, (knots[0], knots[1]), points, _weights_or_none(weights))
    return Patch(surface, (maps[0], maps[1]), max(first.error, second.error))


def _is_same_surface(
    surface: Any, spline: Any, maps: tuple[Map, Map], box: FloatArray, shift: FloatArray
) -> bool:
    """Return whether the spline at mapped parameters is the surface, to `EXACT_TOL` of its size.

    They are compared at 8 × 8 places of `box`, off all symmetries; the size is the largest distance
    of these points from the first, or their largest |x| or |y|. `shift` is that of the knots.
    """
    share = np.array([0.0, 0.137, 0.291, 0.418, 0.593, 0.761, 0.902, 1.0])
    u = box[0, 0] + share * (box[1, 0] - box[0, 0])
    v = box[0, 1] + share * (box[1, 1] - box[0, 1])
    u0, u1, v0, v1 = spline.Bounds()
    mapped_u = np.clip(maps[0](u) - shift[0], u0, u1)
    mapped_v = np.clip(maps[1](v) - shift[1], v0, v1)
    error, size = 0.0, 0.0
    origin = surface.Value(float(u[0]), float(v[0]))
    for a, x in zip(u, mapped_u, strict=True):
        for b, y in zip(v, mapped_v, strict=True):
            point = surface.Value(float(a), float(b))
            error = max(error, point.Distance(spline.Value(float(x), float(y))))
            size = max(size, point.Distance(origin), abs(point.X()), abs(point.Y()))
    return error <= EXACT_TOL * size


def _approximate(trimmed: Any) -> tuple[Any, float]:
    """Return a B-spline near `trimmed` with its parameters, and their largest distance on a grid.

    It is the first that OpenCASCADE finds for `APPROXIMATION_TOLS` times the size.

    Raises
    ------
    GeometryError
        OpenCASCADE finds no approximation.
    """
    from OCP.GeomAbs import GeomAbs_Shape
    from OCP.GeomConvert import GeomConvert_ApproxSurface

    u0, u1, v0, v1 = trimmed.Bounds()
    corner = trimmed.Value(u0, v0)
    size = max(
        corner.Distance(trimmed.Value(u, v)) for u in (u0, u1) for v in (v0, 0.5 * (v0 + v1), v1)
    )
    smooth = GeomAbs_Shape.GeomAbs_C1
    for tolerance in APPROXIMATION_TOLS:
        result = GeomConvert_ApproxSurface(
            trimmed, tolerance * max(size, 1e-3), smooth, smooth, 9, 9, 200, 1
        )
        if result.IsDone() and result.HasResult() and math.isfinite(result.MaxError()):
            spline = result.Surface()
            grid = product(np.linspace(u0, u1, N_GRID), np.linspace(v0, v1, N_GRID))
            return spline, max(float(trimmed.Value(*uv).Distance(spline.Value(*uv))) for uv in grid)
    raise GeometryError(
        "its surface has no NURBS form and could not be approximated",
        found=type(trimmed.BasisSurface()).__name__,
    )


@contextmanager
def quiet() -> Iterator[None]:
    """Keep OpenCASCADE's messages off the terminal."""
    from OCP.Message import Message

    printers = Message.DefaultMessenger_s().ChangePrinters()
    removed = list(printers)
    printers.Clear()
    try:
        yield
    finally:
        for printer in removed:
            printers.Append(printer)
