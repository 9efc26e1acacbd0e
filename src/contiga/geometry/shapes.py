"""Exact shapes, one curve or one patch each. Sizes are positive; angles are in radians.

Closed surfaces have their normals outward; open ones along +`axis`. `centre` and `axis` place a
shape: it is built about the origin along z and then moved by `contiga.rigid.transform.frame`.
Sizes that are not positive and finite, and other invalid arguments, raise GeometryError.

>>> ring = torus(major=3.0, minor=1.0, centre=(0.0, 0.0, 5.0))
>>> round(ring.area(1e-9), 6) == round(4 * math.pi**2 * 3.0, 6)
True
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from contiga.arrays.layout import real
from contiga.arrays.ordered import product, solve
from contiga.errors import GeometryError
from contiga.geometry import knots as kv
from contiga.geometry.curve import NurbsCurve
from contiga.geometry.surface import NurbsSurface
from contiga.records import FloatArray
from contiga.rigid import transform

Axis = transform.Axis
ORIGIN = (0.0, 0.0, 0.0)
_LINE = np.array([0.0, 0.0, 1.0, 1.0])
_LARGEST = float(np.finfo(np.float64).max)
_MAX_WAVES = 100


# ---------------------------------------------------------------- curves


def line(start: ArrayLike, end: ArrayLike) -> NurbsCurve:
    """The straight line from `start` to `end`."""
    a, b = transform.vector(start, "start"), transform.vector(end, "end")
    if np.array_equal(a, b):
        raise GeometryError("a line needs two different points", found=a.tolist())
    return NurbsCurve(1, _LINE, [a, b])


def arc(
    *,
    radius: float = 1.0,
    start: float = 0.0,
    end: float = 0.5 * math.pi,
    centre: ArrayLike = ORIGIN,
    axis: Axis = "z",
) -> NurbsCurve:
    """Circular arc about `axis` from `start` to `end` > start, radians, at most a full turn.

    Rational quadratic pieces of at most a quarter turn (The NURBS Book, Algorithm A7.1).
    """
    r = _size(radius, "radius")
    knots, points, weights = _unit_arc(_number(start, "start"), _number(end, "end"))
    net = np.column_stack([r * points, np.zeros(len(points))])
    return NurbsCurve(2, knots, net, weights)._moved(transform.frame(axis, centre))


def circle(*, radius: float = 1.0, centre: ArrayLike = ORIGIN, axis: Axis = "z") -> NurbsCurve:
    """Full circle about `axis`, anticlockwise seen from its tip."""
    return arc(radius=radius, start=0.0, end=2.0 * math.pi, centre=centre, axis=axis)


def ellipse(
    *,
    axes: ArrayLike = (2.0, 1.0),
    centre: ArrayLike = ORIGIN,
    axis: Axis = "z",
) -> NurbsCurve:
    """Full ellipse with the half axes `axes` = (a along x, b along y) before it is placed."""
    a, b = _sizes(axes, 2, "axes")
    return circle().scaled((a, b, 1.0))._moved(transform.frame(axis, centre))


# ---------------------------------------------------------------- surfaces from points and curves


def bilinear(p00: ArrayLike, p10: ArrayLike, p01: ArrayLike, p11: ArrayLike) -> NurbsSurface:
    """Bilinear patch; ``pij`` is the corner at u = i, v = j."""
    corners = [[transform.vector(p00, "p00"), transform.vector(p01, "p01")]]
    corners.append([transform.vector(p10, "p10"), transform.vector(p11, "p11")])
    return NurbsSurface((1, 1), (_LINE, _LINE), corners)


def ruled(first: NurbsCurve, second: NurbsCurve) -> NurbsSurface:
    """Straight lines between equal shares of two curves: u along them, v from first to second.

    The curves are brought to one degree and one knot vector on [0, 1] first.
    """
    degree = max(_curve(first, "first").degree, _curve(second, "second").degree)
    curves = []
    for curve in (first, second):
        raised = curve.elevate(degree - curve.degree)
        low, high = raised.domain
        knots = (raised.knots - low) / (high - low)
        curves.append(NurbsCurve(degree, knots, raised.control_points, raised.weights))
    values = np.union1d(curves[0].knots, curves[1].knots)
    times = np.max([[kv.multiplicity(c.knots, t) for t in values] for c in curves], axis=0)
    knots = np.repeat(values, times)
    net = np.stack([curve._refined(knots).arrays.net for curve in curves], axis=1)
    rational = first.is_rational or second.is_rational
    return NurbsSurface(
        (degree, 1), (knots, _LINE), net[..., :3], net[..., 3] if rational else None
    )


def extruded(curve: NurbsCurve, direction: ArrayLike) -> NurbsSurface:
    """Surface of `curve` moved by the vector `direction`: u along the curve, v along the vector."""
    d = transform.vector(direction, "direction")
    _curve(curve, "curve")
    if not d.any():
        raise GeometryError("must not be zero", where="direction", found=d.tolist())
    points = np.stack([curve.control_points, curve.control_points + d], axis=1)
    weights = None if curve.weights is None else np.stack([curve.weights] * 2, axis=1)
    return NurbsSurface((curve.degree, 1), (curve.knots, _LINE), points, weights)


def revolved(
    curve: NurbsCurve,
    angle: float = 2.0 * math.pi,
    *,
    axis: Axis = "z",
    origin: ArrayLike = ORIGIN,
) -> NurbsSurface:
    """Surface of `curve` turned by `angle` in (0, 2π] about `axis`: u is the angle, v the curve.

    The axis goes through `origin`. The normal is outward for a curve that runs along +axis. Points
    on the axis become poles (The NURBS Book, Algorithm A8.1).

    Raises
    ------
    GeometryError
        An angle outside of its range, or a curve that runs round the axis only, or lies on it.
    """
    _curve(curve, "curve")
    if not 0.0 < _size(angle, "angle") <= 2.0 * math.pi * (1.0 + 1e-15):
        raise GeometryError("must be in (0, 2π]", where="angle", found=angle)
    k, centre = transform.unit_axis(axis), transform.vector(origin, "origin")
    places = curve.evaluate(np.linspace(*curve.domain, 33)) - centre
    height = product(places, k)
    radius = np.linalg.norm(places - np.outer(height, k), axis=1)
    if min(radius.max(), max(np.ptp(radius), np.ptp(height))) <= 1e-12 * np.abs(places).max():
        reason = "sweeps no area: it lies on the axis or runs round it at one height"
        raise GeometryError(reason, where="curve")
    knots, circle_points, circle_weights = _unit_arc(0.0, angle)
    from_centre = curve.control_points - centre
    axial = np.outer(product(from_centre, k), k)
    radial = from_centre - axial
    distance = np.linalg.norm(from_centre, axis=1, keepdims=True)
    radial[np.linalg.norm(radial, axis=1) <= 1e-15 * distance[:, 0]] = 0.0
    tangential = np.cross(k, radial)
    cosine, sine = circle_points[:, None, :1], circle_points[:, None, 1:2]
    points = centre + axial + cosine * radial + sine * tangential
    factors = np.ones(len(axial)) if curve.weights is None else curve.weights
    return NurbsSurface(
        (2, curve.degree), (knots, curve.knots), points, np.outer(circle_weights, factors)
    )


# ---------------------------------------------------------------- surfaces with a name


def plane(
    *, width: float = 1.0, length: float = 1.0, centre: ArrayLike = ORIGIN, axis: Axis = "z"
) -> NurbsSurface:
    """Flat rectangle, `width` along x (u) and `length` along y (v), normal along `axis`."""
    a, b = 0.5 * _size(width, "width"), 0.5 * _size(length, "length")
    patch = bilinear((-a, -b, 0.0), (a, -b, 0.0), (-a, b, 0.0), (a, b, 0.0))
    return patch._moved(transform.frame(axis, centre))


def disc(*, radius: float = 1.0, centre: ArrayLike = ORIGIN, axis: Axis = "z") -> NurbsSurface:
    """Flat disc, u from the centre (a pole) to the rim, v the angle; normal along `axis`."""
    rim = revolved(line(ORIGIN, (_size(radius, "radius"), 0.0, 0.0)))
    return rim.transposed()._moved(transform.frame(axis, centre))


def cylinder(
    *,
    radius: float = 1.0,
    height: float = 1.0,
    angle: float = 2.0 * math.pi,
    centre: ArrayLike = ORIGIN,
    axis: Axis = "z",
) -> NurbsSurface:
    """Side of a cylinder without its ends, `centre` at half its height, normals outward.

    It goes round the axis by `angle`, at most 2π.
    """
    r, h = _size(radius, "radius"), 0.5 * _size(height, "height")
    side = revolved(line((r, 0.0, -h), (r, 0.0, h)), angle)
    return side._moved(transform.frame(axis, centre))


def cone(
    *,
    radius: float = 1.0,
    height: float = 1.0,
    top_radius: float = 0.0,
    angle: float = 2.0 * math.pi,
    centre: ArrayLike = ORIGIN,
    axis: Axis = "z",
) -> NurbsSurface:
    """Side of a cone (or, with `top_radius` > 0, of its stump) without its base.

    `centre` is the centre of the base and the apex lies along +`axis`; normals outward. The
    side goes round the axis by `angle`, at most 2π.
    """
    r, h = _size(radius, "radius"), _size(height, "height")
    top = float(_number(top_radius, "top_radius"))
    if not (math.isfinite(top) and top >= 0.0):
        raise GeometryError("must not be negative", where="top_radius", found=top_radius)
    side = revolved(line((r, 0.0, 0.0), (top, 0.0, h)), angle)
    return side._moved(transform.frame(axis, centre))


def sphere(*, radius: float = 1.0, centre: ArrayLike = ORIGIN, axis: Axis = "z") -> NurbsSurface:
    """Sphere: u the longitude, v from the south to the north pole of `axis`; normals outward."""
    return ellipsoid(axes=(_size(radius, "radius"),) * 3, centre=centre, axis=axis)


def ellipsoid(
    *,
    axes: ArrayLike = (3.0, 2.0, 1.0),
    centre: ArrayLike = ORIGIN,
    axis: Axis = "z",
) -> NurbsSurface:
    """Ellipsoid with half axes `axes` (it is twice as long) along x, y, z before it is placed."""
    a, b, c = _sizes(axes, 3, "axes")
    half = revolved(_meridian(-0.5 * math.pi, 0.5 * math.pi, 0.0, 1.0))
    return half.scaled((a, b, c))._moved(transform.frame(axis, centre))


def torus(
    *,
    major: float = 2.0,
    minor: float = 0.5,
    centre: ArrayLike = ORIGIN,
    axis: Axis = "z",
) -> NurbsSurface:
    """Torus: tube of radius `minor` about a circle of radius `major` > minor; normals outward."""
    ring_radius, tube_radius = _size(major, "major"), _size(minor, "minor")
    if tube_radius >= ring_radius:
        raise GeometryError(
            "the tube of a torus must not reach its axis",
            where="minor",
            found=minor,
            allowed=f"less than major = {major!r}",
        )
    ring = revolved(_meridian(0.0, 2.0 * math.pi, ring_radius, tube_radius))
    return ring._moved(transform.frame(axis, centre))


def saddle(
    *,
    width: float = 1.0,
    length: float = 1.0,
    height: float = 0.25,
    centre: ArrayLike = ORIGIN,
    axis: Axis = "z",
) -> NurbsSurface:
    """Hyperbolic paraboloid z = height (ξ² − η²), ξ and η from −1 to 1 over width and length."""
    a, b = 0.5 * _size(width, "width"), 0.5 * _size(length, "length")
    c = _size(height, "height")
    square = np.array([1.0, -1.0, 1.0])  # Bernstein coefficients of ξ² on [-1, 1]
    net = np.empty((3, 3, 3))
    net[..., 0] = a * np.array([-1.0, 0.0, 1.0])[:, None]
    net[..., 1] = b * np.array([-1.0, 0.0, 1.0])[None, :]
    net[..., 2] = c * (square[:, None] - square[None, :])
    knots = kv.open_knots(2, 3)
    return NurbsSurface((2, 2), (knots, knots), net)._moved(transform.frame(axis, centre))


def bumpy_plate(
    *,
    width: float = 1.0,
    length: float = 1.0,
    amplitude: float = 0.05,
    waves: int | tuple[int, int] = 2,
    centre: ArrayLike = ORIGIN,
    axis: Axis = "z",
) -> NurbsSurface:
    """Bicubic plate with bumps, z = amplitude · sin(2π m x / width) · sin(2π n y / length).

    `waves` = (m, n) or one number for both. The spline interpolates this height at its Greville
    points, eight spans a wave (the height is met within 0.2 % of the amplitude); x and y are exact.
    """
    a, b = _size(width, "width"), _size(length, "length")
    c = _size(amplitude, "amplitude")
    pair = tuple(waves) if isinstance(waves, tuple | list) else (waves, waves)
    if len(pair) != 2 or any(
        isinstance(w, bool) or not isinstance(w, int | np.integer) or not 1 <= w <= _MAX_WAVES
        for w in pair
    ):
        raise GeometryError(
            "the number of waves must be a whole number within limits",
            where="waves",
            found=waves,
            allowed=f"1, 2, 3, ... {_MAX_WAVES} or a pair",
        )
    U, x, sine_x = _sine(int(pair[0]))
    V, y, sine_y = _sine(int(pair[1]))
    net = np.empty((len(x), len(y), 3))
    net[..., 0] = a * (x[:, None] - 0.5)
    net[..., 1] = b * (y[None, :] - 0.5)
    net[..., 2] = c * np.outer(sine_x, sine_y)
    return NurbsSurface((3, 3), (U, V), net)._moved(transform.frame(axis, centre))


# ---------------------------------------------------------------- checks and parts


def _curve(value: NurbsCurve, name: str) -> NurbsCurve:
    """Return `value` if it is a NurbsCurve; raise GeometryError otherwise."""
    if not isinstance(value, NurbsCurve):
        raise GeometryError(
            "must be a curve", where=name, found=type(value).__name__, allowed="NurbsCurve"
        )
    return value


def _number(value: float, name: str) -> float:
    """Return `value` if it is a number; raise GeometryError for text or a truth value."""
    if not isinstance(real(value, name), int | float | np.number) or isinstance(value, bool):
        raise GeometryError("must be a number", where=name, found=value)
    return value


def _size(value: float, name: str) -> float:
    """Return `value` as a float; raise GeometryError unless it is positive and finite."""
    if not 0.0 < _number(value, name) <= _LARGEST:
        raise GeometryError("a size must be positive", where=name, found=value, allowed="> 0")
    return float(value)


def _sizes(values: ArrayLike, count: int, name: str) -> FloatArray:
    """Return `values` as (count,) floats; GeometryError unless all are positive and finite."""
    array = kv.check_numbers(values, name)
    if array.shape != (count,) or (array <= 0.0).any():
        raise GeometryError(
            "sizes must be positive", where=name, found=values, allowed=f"{count} numbers > 0"
        )
    return array


def _unit_arc(start: float, end: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return knots on [0, 1], points (n, 2) and weights (n,) of an arc of the unit circle.

    It has quadratic pieces of equal angles, a quarter turn at most. A full turn ends in its start
    to the last bit. Raises GeometryError unless 0 < end − start ≤ 2π.
    """
    sweep = end - start
    if not (math.isfinite(sweep) and 0.0 < sweep <= 2.0 * math.pi * (1.0 + 1e-15)):
        raise GeometryError(
            "the arc must run from start to end, at most a full turn", found=(start, end)
        )
    pieces = max(1, math.ceil(sweep / (0.5 * math.pi) - 1e-9))
    step = sweep / pieces
    weight = math.cos(0.5 * step) if pieces * 0.5 * math.pi != sweep else math.sqrt(0.5)
    points = np.empty((2 * pieces + 1, 2))
    for i in range(2 * pieces + 1):
        radius = 1.0 if i % 2 == 0 else 1.0 / weight
        cosine, sine = transform.cos_sin(start + 0.5 * i * step)
        points[i] = (radius * cosine, radius * sine)
        if i % 2 == 1 and weight == math.sqrt(0.5):
            points[i] = points[i - 1] + product(points[i - 1], [[0.0, 1.0], [-1.0, 0.0]])
    if sweep >= 2.0 * math.pi:
        points[-1] = points[0]
    weights = np.where(np.arange(2 * pieces + 1) % 2 == 0, 1.0, weight)
    inner = np.repeat(np.arange(1, pieces) / pieces, 2)
    return np.concatenate([np.zeros(3), inner, np.ones(3)]), points, weights


def _meridian(start: float, end: float, x0: float, radius: float) -> NurbsCurve:
    """Return an arc of a radius in the x-z plane about (`x0`, 0, 0), the angle from x to z."""
    knots, points, weights = _unit_arc(start, end)
    x, z = points.T
    return NurbsCurve(2, knots, np.column_stack([x0 + radius * x, 0.0 * x, radius * z]), weights)


def _sine(count: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return knots, Greville points and coefficients of a cubic that interpolates sin(2π count t).

    It has eight spans a wave on [0, 1], and equals the sine at the Greville points.
    """
    knots = kv.open_knots(3, 8 * count + 3)
    at = kv.greville(knots, 3)
    matrix = kv.basis(knots, 3, at)[:, 0]
    heights = solve(matrix, np.sin(2.0 * math.pi * count * at))
    return knots, at, np.asarray(heights, dtype=np.float64)
