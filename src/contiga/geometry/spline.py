"""Common base of curves and surfaces: an immutable net of control points."""

from __future__ import annotations

from typing import Any, Generic, TypeVar

import numpy as np

from contiga.geometry import exchange
from contiga.geometry.exchange import SplineParts
from contiga.geometry.kernels.evaluate_nb import CurveArrays, SurfaceArrays
from contiga.records import FloatArray
from contiga.rigid.movable import Movable

Arrays = TypeVar("Arrays", CurveArrays, SurfaceArrays)


class Spline(Movable, Generic[Arrays]):
    """A B-spline, or with weights a NURBS, known by the arrays that kernels take."""

    __slots__ = ("__weakref__", "_arrays")
    _arrays: Arrays

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"a {type(self).__name__} cannot be changed: {name}")

    @property
    def arrays(self) -> Arrays:
        """The arrays that kernels take."""
        return self._arrays

    @property
    def control_points(self) -> FloatArray:
        """Control points (n, 3), for a surface (n, m, 3); read-only."""
        return self._arrays.net[..., :3]

    @property
    def weights(self) -> FloatArray | None:
        """Weights (n,), for a surface (n, m); read-only; None for a B-spline."""
        return self._arrays.net[..., 3] if self.is_rational else None

    @property
    def is_rational(self) -> bool:
        return self._arrays.rational

    @property
    def homogeneous(self) -> FloatArray:
        """Control points (wx, wy, wz, w): (n, 4), for a surface (n, m, 4); a new array."""
        return homogeneous(self._arrays.net)

    @property
    def _parts(self) -> SplineParts:
        raise NotImplementedError

    def to_geomdl(self) -> Any:
        """Return a spline of geomdl: BSpline, or NURBS if it is rational.

        Its knots keep their values (``normalize_kv=False``).

        Raises
        ------
        MissingPackageError
            geomdl is not installed.
        """
        return exchange.to_geomdl(self._parts)

    def to_splinepy(self) -> Any:
        """Return a spline of splinepy: BSpline, or NURBS if it is rational.

        Raises
        ------
        MissingPackageError
            splinepy is not installed.
        """
        return exchange.to_splinepy(self._parts)

    def bounds(self) -> FloatArray:
        """Return (2, 3) lower and upper corner of the control points, which hold the spline."""
        points = self.control_points.reshape(-1, 3)
        return np.array([points.min(axis=0), points.max(axis=0)])


def homogeneous(net: FloatArray) -> FloatArray:
    """Return (..., 4) (x, y, z, w) as (wx, wy, wz, w)."""
    out = np.array(net)
    out[..., :3] *= net[..., 3:]
    return out


def cartesian(points: FloatArray, rational: bool = True) -> FloatArray:
    """Return (..., 4) (wx, wy, wz, w) as (x, y, z, w); a B-spline's weights are exactly one."""
    out = np.array(points)
    if rational:
        out[..., :3] /= points[..., 3:]
    else:
        out[..., 3] = 1.0
    return out
