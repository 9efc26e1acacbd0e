"""Curves and surfaces to and from the objects of geomdl, splinepy and scipy, without a file.

geomdl keeps the control points of a rational spline multiplied by their weights. There the
control points come back rounded once more; everything else comes back to the last bit.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.errors import GeometryError
from contiga.extras import imported
from contiga.records import FloatArray

Array = NDArray[Any]

KINDS = {1: "curve", 2: "surface"}
"""Kind of spline, by its number of parameters."""
ACCEPTED = {
    1: "NurbsCurve; BSpline.Curve or NURBS.Curve of geomdl; BSpline, NURBS, Bezier or "
    "RationalBezier of splinepy with one parameter; BSpline of scipy; points in 2 or 3 dimensions",
    2: "NurbsSurface; BSpline.Surface or NURBS.Surface of geomdl, without trims; BSpline, NURBS, "
    "Bezier or RationalBezier of splinepy with two parameters; NdBSpline of scipy with two; points "
    "in 2 or 3 dimensions",
}
_GEOMDL_AXES = {1: ("",), 2: ("_u", "_v")}
"""Suffixes of geomdl's attributes for each parameter, by the number of parameters."""


class SplineParts(NamedTuple):
    """Degrees, knots, control points and weights of a spline of d parameters."""

    degrees: tuple[int, ...]
    """d of them."""
    knots: tuple[Array, ...]
    """d of them, each (n_i + degree + 1,)."""
    control_points: Array
    """(n_1, …, n_d, 3), length."""
    weights: Array | None
    """(n_1, …, n_d); None for a B-spline."""


def parts_of(spline: object, n_parameters: int) -> SplineParts:
    """Return the parts of a curve (one parameter) or a surface (two) of geomdl, splinepy or scipy.

    Points (2,) get z = 0.

    Raises
    ------
    GeometryError
        It is none of `ACCEPTED`, is trimmed, or has no control points yet.
    """
    packages = {kind.__module__.partition(".")[0] for kind in type(spline).__mro__}
    readers = {"geomdl": _from_geomdl, "splinepy": _from_splinepy, "scipy": _from_scipy}
    reader = next((readers[name] for name in readers if name in packages), None)
    parts = None if reader is None else reader(spline, n_parameters)
    if parts is None or parts.control_points.shape[n_parameters:] not in ((2,), (3,)):
        raise GeometryError(
            f"cannot be read as a {KINDS[n_parameters]}",
            found=f"{type(spline).__module__}.{type(spline).__qualname__}",
            allowed=ACCEPTED[n_parameters],
        )
    points = parts.control_points
    if points.shape[-1] == 2:
        points = np.concatenate([points, np.zeros((*points.shape[:-1], 1))], axis=-1)
    return parts._replace(control_points=points)


def _from_geomdl(spline: Any, n_parameters: int) -> SplineParts | None:
    """Return the parts of a spline of geomdl; None if it has another number of parameters.

    Raises GeometryError without control points, and for a surface with trims.
    """
    axes = _GEOMDL_AXES[n_parameters]
    if getattr(spline, "pdimension", None) != n_parameters:
        return None
    if not spline.ctrlpts:
        raise GeometryError("has no control points yet", found=f"{spline!r} of geomdl")
    if n_parameters == 2 and spline.trims:
        raise GeometryError(
            "is trimmed, which a patch alone cannot be",
            found=f"{len(spline.trims)} trims",
            allowed="a surface of geomdl without trims",
            remedy="Take the patch without its trims, and give them to Body(patches, trims=…)",
        )
    shape = tuple(getattr(spline, f"ctrlpts_size{axis}") for axis in axes)
    weights = np.array(spline.weights).reshape(shape) if spline.rational else None
    return SplineParts(
        tuple(getattr(spline, f"degree{axis}") for axis in axes),
        tuple(np.array(getattr(spline, f"knotvector{axis}")) for axis in axes),
        np.array(spline.ctrlpts).reshape(*shape, -1),
        weights,
    )


def _from_splinepy(spline: Any, n_parameters: int) -> SplineParts | None:
    """Return the parts of a spline of splinepy; None if it has another number of parameters."""
    if getattr(spline, "para_dim", None) != n_parameters:
        return None
    degrees = tuple(int(degree) for degree in spline.degrees)
    shape = tuple(int(n) for n in spline.control_mesh_resolutions)
    if spline.has_knot_vectors:
        knots = tuple(np.array(list(vector)) for vector in spline.knot_vectors)
    else:  # Bézier
        knots = tuple(np.repeat([0.0, 1.0], degree + 1) for degree in degrees)
    points = np.array(spline.control_points)
    weights = np.array(spline.weights) if spline.is_rational else None
    return SplineParts(
        degrees,
        knots,
        _first_slowest(points, shape),
        None if weights is None else _first_slowest(weights, shape)[..., 0],
    )


def _from_scipy(spline: Any, n_parameters: int) -> SplineParts | None:
    """Return the parts of a spline of scipy; None without t, c, k or for other `n_parameters`."""
    if not all(hasattr(spline, name) for name in "tck"):
        return None
    knots = spline.t if isinstance(spline.t, tuple) else (spline.t,)
    degrees = tuple(int(k) for k in np.atleast_1d(spline.k))
    if len(knots) != n_parameters:
        return None
    # SciPy allows more coefficients than the knots need.
    used = tuple(slice(len(t) - k - 1) for t, k in zip(knots, degrees, strict=True))
    return SplineParts(degrees, tuple(map(np.array, knots)), np.array(spline.c)[used], None)


def _first_slowest(rows: Array, shape: tuple[int, ...]) -> Array:
    """Return (n_1, …, n_d, k) from rows (n, k) whose first index runs fastest (splinepy)."""
    return np.ascontiguousarray(_swapped(rows.reshape(*shape[::-1], -1)))


def _swapped(net: Array) -> Array:
    """Return a net with the order of its indices reversed, except that of the coordinates."""
    return net.transpose(*range(net.ndim - 2, -1, -1), net.ndim - 1)


def to_geomdl(parts: SplineParts) -> Any:
    """Return a BSpline or NURBS of geomdl whose knots keep their values.

    Raises
    ------
    MissingPackageError
        geomdl is not installed.
    """
    axes, shape = _GEOMDL_AXES[len(parts.degrees)], parts.control_points.shape[:-1]
    rational = parts.weights is not None
    module = imported("to_geomdl", "geomdl.NURBS" if rational else "geomdl.BSpline")
    spline = getattr(module, KINDS[len(parts.degrees)].capitalize())(normalize_kv=False)
    for axis, degree in zip(axes, parts.degrees, strict=True):
        setattr(spline, f"degree{axis}", degree)
    points = parts.control_points
    if parts.weights is not None:
        w = parts.weights[..., None]
        points = np.concatenate([points * w, w], axis=-1)
    spline.set_ctrlpts(points.reshape(-1, points.shape[-1]).tolist(), *shape)
    for axis, knots in zip(axes, parts.knots, strict=True):
        setattr(spline, f"knotvector{axis}", knots.tolist())
    return spline


def to_splinepy(parts: SplineParts) -> Any:
    """Return a BSpline, or a NURBS if there are weights, of splinepy.

    Raises
    ------
    MissingPackageError
        splinepy is not installed.
    """
    splinepy = imported("to_splinepy", "splinepy")

    def rows(net: FloatArray) -> FloatArray:
        return np.ascontiguousarray(_swapped(net)).reshape(-1, net.shape[-1])

    arguments = {
        "degrees": list(parts.degrees),
        "knot_vectors": [knots.tolist() for knots in parts.knots],
        "control_points": rows(parts.control_points),
    }
    if parts.weights is None:
        return splinepy.BSpline(**arguments)
    return splinepy.NURBS(**arguments, weights=rows(parts.weights[..., None]))
