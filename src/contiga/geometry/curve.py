"""B-spline and NURBS curves: immutable, any degree from 1 to 15."""

from __future__ import annotations

from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from contiga.arrays.layout import read_only, real
from contiga.errors import GeometryError
from contiga.geometry import knots as kv
from contiga.geometry import refine
from contiga.geometry.exchange import SplineParts, parts_of
from contiga.geometry.kernels.evaluate_nb import CurveArrays, curve_range
from contiga.geometry.quadrature import curve_length
from contiga.geometry.spline import Spline, cartesian, homogeneous
from contiga.records import FloatArray
from contiga.rigid import transform


class NurbsCurve(Spline[CurveArrays]):
    """A B-spline curve, or with weights a NURBS curve. It never changes; methods return new ones.

    The domain is ``[U_p, U_n]``. Knots that are not clamped there are clamped by knot insertion,
    with the parameters unchanged.

    Parameters
    ----------
    degree : int, 1 to 15
    knots : (n + degree + 1,), not decreasing, interior knots at most `degree` times
    control_points : (n, 3), or (n, 2) with z = 0
    weights : (n,) positive; None for a B-spline

    Raises
    ------
    GeometryError
        counts that do not fit, knots that decrease, weights that are not positive, NaN.

    >>> line = NurbsCurve(1, [0, 0, 1, 1], [[0, 0, 0], [2, 0, 0]])
    >>> line.evaluate(0.5)
    array([[1., 0., 0.]])
    """

    __slots__ = ()

    def __init__(
        self,
        degree: int,
        knots: ArrayLike,
        control_points: ArrayLike,
        weights: ArrayLike | None = None,
    ) -> None:
        p = kv.check_degree(degree, "degree")
        points = kv.check_numbers(control_points, "control_points")
        if points.ndim != 2 or points.shape[1] not in (2, 3):
            raise GeometryError(
                "control points of a curve must have shape (n, 3)",
                where="control_points",
                found=points.shape,
                allowed="(n, 3), or (n, 2) in the plane",
            )
        n = points.shape[0]
        factors = kv.check_weights(weights, (n,), "weights")
        U = kv.check_knots(knots, p, n, "knots")
        net = np.zeros((n, 4))
        net[:, : points.shape[1]] = points
        net[:, 3] = 1.0 if factors is None else factors
        if not kv.is_clamped(U, p, n):
            new_U = kv.clamped(U, p, float(U[p]), float(U[n]))
            net = cartesian(refine.refine_points(U, p, homogeneous(net), new_U))
            U = new_U
        self._set(p, U, net, factors is not None)

    @classmethod
    def from_any(cls, spline: object) -> Self:
        """Read a curve of geomdl, splinepy or scipy; a `NurbsCurve` comes back as it is.

        Parameters
        ----------
        spline : BSpline.Curve or NURBS.Curve of geomdl; BSpline, NURBS, Bezier or RationalBezier of
            splinepy with one parameter; BSpline of scipy. Points (2,) lie in the plane z = 0

        Raises
        ------
        GeometryError
            It is none of these.

        >>> from scipy.interpolate import BSpline
        >>> NurbsCurve.from_any(BSpline([0, 0, 1, 1], [[0, 0, 0], [2, 0, 0]], 1)).length()
        2.0
        """
        if isinstance(spline, cls):
            return spline
        parts = parts_of(spline, 1)
        return cls(parts.degrees[0], parts.knots[0], parts.control_points, parts.weights)

    @property
    def _parts(self) -> SplineParts:
        return SplineParts((self.degree,), (self.knots,), self.control_points, self.weights)

    def _set(self, degree: int, knots: FloatArray, net: FloatArray, rational: bool) -> None:
        """Set the arrays, as read-only copies, of a new curve."""
        arrays = CurveArrays(degree, read_only(knots), read_only(net), rational)
        object.__setattr__(self, "_arrays", arrays)

    @classmethod
    def _from_net(cls, degree: int, knots: FloatArray, net: FloatArray, rational: bool) -> Self:
        """Return a curve from clamped knots and a net (n, 4) of (x, y, z, w), unchecked."""
        curve = cls.__new__(cls)
        curve._set(degree, knots, net, rational)
        return curve

    @classmethod
    def _from_homogeneous(
        cls, degree: int, knots: FloatArray, points: FloatArray, rational: bool
    ) -> Self:
        """Return a curve from (n, 4) (wx, wy, wz, w)."""
        return cls._from_net(degree, knots, cartesian(points, rational), rational)

    def __reduce__(self) -> tuple[Any, ...]:
        # Through its own net, not through weights divided out: the copy has the same bits.
        return self._from_net, (self.degree, self.knots, self._arrays.net, self.is_rational)

    def __repr__(self) -> str:
        kind = "NURBS" if self.is_rational else "B-spline"
        a, b = self.domain
        return (
            f"<{kind} curve, degree {self.degree}, {len(self.control_points)} points, [{a}, {b}]>"
        )

    @property
    def degree(self) -> int:
        return self._arrays.degree

    @property
    def knots(self) -> FloatArray:
        """Knots (n + degree + 1,), clamped, read-only."""
        return self._arrays.knots

    @property
    def domain(self) -> tuple[float, float]:
        return float(self.knots[0]), float(self.knots[-1])

    def evaluate(self, u: ArrayLike) -> FloatArray:
        """Return points (k, 3) at parameters `u` (k,) or a single one; errors as `derivatives`."""
        return self.derivatives(u, 0)[:, 0]

    def derivatives(self, u: ArrayLike, order: int = 2) -> FloatArray:
        """Return (k, order + 1, 3): entry [:, a] is the a-th derivative, [:, 0] the point.

        At a knot the derivatives are those of the piece to its right, at the last one to its left.

        Raises
        ------
        InputError
            a parameter outside the domain by more than rounding.
        """
        t = np.atleast_1d(np.asarray(real(u), dtype=np.float64)).ravel()
        t = kv.check_parameters(t, self.domain, "u")
        out = np.zeros((t.size, kv.check_order(order) + 1, 3))
        curve_range(self._arrays, t, order, out)
        return out

    def insert_knots(self, u: ArrayLike) -> Self:
        """Return the same curve with the knots `u` inserted.

        Several may be inserted at once, and existing ones again. Raises GeometryError for a knot
        outside the open domain, or more than `degree` times.
        """
        return self._refined(refine.with_inserted(self.knots, self.degree, u, "u"))

    def _refined(self, refined: FloatArray) -> Self:
        """Return the same curve, or a part of it, on finer clamped knots."""
        points = refine.refine_points(self.knots, self.degree, self.homogeneous, refined)
        return self._from_homogeneous(self.degree, refined, points, self.is_rational)

    def elevate(self, t: int = 1) -> Self:
        """Return the same curve with its degree `t` higher and its smoothness kept."""
        kv.check_degree(self.degree + kv.check_order(t), "degree after elevation")
        knots, points = self.knots, self.homogeneous
        for degree in range(self.degree, self.degree + t):
            knots, points = refine.elevate_points(knots, degree, points)
        return self._from_homogeneous(self.degree + t, knots, points, self.is_rational)

    def k_refined(self, t: int, u: ArrayLike = ()) -> Self:
        """Return the same curve elevated by `t`, then refined by knots `u` (k-refinement)."""
        return self.elevate(t).insert_knots(u)

    def restricted(self, low: float, high: float) -> Self:
        """Return the part over ``[low, high]``, with its parameters unchanged.

        Raises GeometryError unless that is a part of the domain, of some length.
        """
        a, b = self.domain
        if not a <= low < high <= b:
            raise GeometryError(
                "not a part of the domain", found=(low, high), allowed=f"within [{a}, {b}]"
            )
        return self._refined(kv.clamped(self.knots, self.degree, float(low), float(high)))

    def split(self, u: float) -> tuple[Self, Self]:
        """Return the parts before and after the parameter `u`, strictly inside the domain."""
        t = kv.check_inner_parameter(u, self.domain, "u")
        a, b = self.domain
        return self.restricted(a, t), self.restricted(t, b)

    def reversed(self) -> Self:
        """Return the same curve reversed over the same domain: u becomes ``u0 + u1 - u``."""
        return self._from_net(
            self.degree, kv.mirrored(self.knots), self._arrays.net[::-1], self.is_rational
        )

    def _moved(self, matrix: FloatArray) -> Self:
        net = np.array(self._arrays.net)
        net[:, :3] = transform.apply(matrix, self.control_points)
        return self._from_net(self.degree, self.knots, net, self.is_rational)

    def length(self, rtol: float = 1e-10) -> float:
        """Return the arc length, to the relative tolerance `rtol` (adaptive Gauss quadrature)."""
        return curve_length(self, rtol)
