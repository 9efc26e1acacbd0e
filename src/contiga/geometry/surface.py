"""B-spline and NURBS surfaces: immutable, any degrees from 1 to 15."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal, Self

import numpy as np
from numpy.typing import ArrayLike

from contiga.arrays.layout import as_parameters, read_only
from contiga.arrays.ordered import product
from contiga.arrays.threads import run_ranges
from contiga.errors import GeometryError
from contiga.geometry import knots as kv
from contiga.geometry import refine, tessellate
from contiga.geometry.curve import NurbsCurve
from contiga.geometry.exchange import SplineParts, parts_of
from contiga.geometry.kernels import evaluate_nb as nb
from contiga.geometry.quadrature import surface_area
from contiga.geometry.spline import Spline, cartesian, homogeneous
from contiga.records import FloatArray
from contiga.rigid import transform

if TYPE_CHECKING:
    from contiga.triangles.trimesh import TriMesh

MIN_POINTS = 2048
"""Number of points from which several threads are faster than one."""

Pair = tuple[FloatArray, FloatArray]


class NurbsSurface(Spline[nb.SurfaceArrays]):
    """A B-spline surface, or with weights a NURBS surface. It never changes.

    The normal ``S_u × S_v`` points to the free side (see `contiga.conventions`). The domain is
    ``[U_p, U_n] × [V_q, V_m]``. Knots that are not clamped there are clamped by knot insertion,
    with the parameters unchanged.

    Parameters
    ----------
    degrees : (p, q), each 1 to 15
    knots : (U, V) with n + p + 1 and m + q + 1 entries, not decreasing, interior knots at most
        p (q) times
    control_points : (n, m, 3), n along u
    weights : (n, m) positive; None for a B-spline

    Raises
    ------
    GeometryError
        counts that do not fit, knots that decrease, weights that are not positive, NaN.

    >>> corners = [[[0, 0, 0], [0, 1, 0]], [[1, 0, 0], [1, 1, 0]]]
    >>> NurbsSurface((1, 1), ([0, 0, 1, 1],) * 2, corners).normal([0.5, 0.5])
    array([[0., 0., 1.]])
    """

    __slots__ = ()

    def __init__(
        self,
        degrees: tuple[int, int],
        knots: tuple[ArrayLike, ArrayLike],
        control_points: ArrayLike,
        weights: ArrayLike | None = None,
    ) -> None:
        if not isinstance(degrees, tuple | list) or len(degrees) != 2:
            raise GeometryError(
                "a surface needs two degrees (p, q)", where="degrees", found=degrees
            )
        p = kv.check_degree(degrees[0], "degree in u")
        q = kv.check_degree(degrees[1], "degree in v")
        points = kv.check_numbers(control_points, "control_points")
        if points.ndim != 3 or points.shape[2] != 3:
            raise GeometryError(
                "control points of a surface must have shape (n, m, 3)",
                where="control_points",
                found=points.shape,
                allowed="(n, m, 3)",
            )
        n, m = points.shape[:2]
        factors = kv.check_weights(weights, (n, m), "weights")
        if not isinstance(knots, tuple | list) or len(knots) != 2:
            raise GeometryError("a surface needs two knot vectors (U, V)", where="knots")
        U = kv.check_knots(knots[0], p, n, "knots in u")
        V = kv.check_knots(knots[1], q, m, "knots in v")
        net = np.empty((n, m, 4))
        net[..., :3] = points
        net[..., 3] = 1.0 if factors is None else factors
        if not (kv.is_clamped(U, p, n) and kv.is_clamped(V, q, m)):
            new_U = kv.clamped(U, p, float(U[p]), float(U[n]))
            new_V = kv.clamped(V, q, float(V[q]), float(V[m]))
            points = refine.refine_points(U, p, homogeneous(net), new_U, 0)
            net = cartesian(refine.refine_points(V, q, points, new_V, 1))
            U, V = new_U, new_V
        self._set((p, q), (U, V), net, factors is not None)

    @classmethod
    def from_any(cls, spline: object) -> Self:
        """Read a surface of geomdl, splinepy or scipy; a `NurbsSurface` comes back as it is.

        Parameters
        ----------
        spline : BSpline.Surface or NURBS.Surface of geomdl, without trims; BSpline, NURBS, Bezier
            or RationalBezier of splinepy with two parameters; NdBSpline of scipy with two. Points
            (2,) lie in the plane z = 0

        Raises
        ------
        GeometryError
            It is none of these.

        >>> import contiga as cg
        >>> ball = cg.shapes.sphere(radius=2.0)
        >>> NurbsSurface.from_any(ball.to_geomdl())
        <NURBS surface, degrees (2, 2), 9 x 5 points>
        """
        if isinstance(spline, cls):
            return spline
        parts = parts_of(spline, 2)
        degrees, knots = (parts.degrees[0], parts.degrees[1]), (parts.knots[0], parts.knots[1])
        return cls(degrees, knots, parts.control_points, parts.weights)

    @property
    def _parts(self) -> SplineParts:
        return SplineParts(self.degrees, self.knots, self.control_points, self.weights)

    def _set(self, degrees: tuple[int, int], knots: Pair, net: FloatArray, rational: bool) -> None:
        """Set the arrays, as read-only copies, of a new surface."""
        arrays = nb.SurfaceArrays(
            degrees[0],
            degrees[1],
            read_only(knots[0]),
            read_only(knots[1]),
            read_only(net),
            rational,
        )
        object.__setattr__(self, "_arrays", arrays)

    @classmethod
    def _from_net(
        cls, degrees: tuple[int, int], knots: Pair, net: FloatArray, rational: bool
    ) -> Self:
        """Return a surface from clamped knots and a net (n, m, 4) of (x, y, z, w), unchecked."""
        surface = cls.__new__(cls)
        surface._set(degrees, knots, net, rational)
        return surface

    def __reduce__(self) -> tuple[Any, ...]:
        # Through its own net, not through weights divided out: the copy has the same bits.
        return self._from_net, (self.degrees, self.knots, self._arrays.net, self.is_rational)

    def __repr__(self) -> str:
        kind = "NURBS" if self.is_rational else "B-spline"
        n, m = self.control_points.shape[:2]
        return f"<{kind} surface, degrees {self.degrees}, {n} x {m} points>"

    def _repr_png_(self) -> bytes:
        """Return the picture of the surface for a notebook."""
        from contiga.rendering.picture import TOLERANCE, picture_of  # kernels of its own

        low, high = self.bounds()
        mesh = self.tessellate(TOLERANCE * float(np.linalg.norm(high - low)))
        return picture_of(mesh.vertices, mesh.triangles)

    @property
    def degrees(self) -> tuple[int, int]:
        return self._arrays.p, self._arrays.q

    @property
    def knots(self) -> Pair:
        """Knots (U, V), clamped, read-only."""
        return self._arrays.U, self._arrays.V

    @property
    def domain(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Ranges of the parameters: ((u0, u1), (v0, v1))."""
        U, V = self.knots
        return (float(U[0]), float(U[-1])), (float(V[0]), float(V[-1]))

    def checked(self, uv: ArrayLike) -> FloatArray:
        """Return `uv` as a new (k, 2) array, clipped to the domain; InputError beyond rounding."""
        pairs = as_parameters(uv)
        out = np.empty_like(pairs)
        out[:, 0] = kv.check_parameters(pairs[:, 0], self.domain[0], "u")
        out[:, 1] = kv.check_parameters(pairs[:, 1], self.domain[1], "v")
        return out

    def evaluate(self, uv: ArrayLike) -> FloatArray:
        """Return points (k, 3) at parameters `uv` (k, 2) or a single pair; errors as `checked`."""
        return self.derivatives(uv, 0)[:, 0, 0]

    def derivatives(self, uv: ArrayLike, order: int = 2) -> FloatArray:
        """Return points and mixed derivatives, each direction up to `order`.

        Rational surfaces by the quotient rule (The NURBS Book, Algorithm A4.4). On a knot line
        the derivatives are those of the element to the right, at the last one to the left.

        Returns
        -------
        (k, order + 1, order + 1, 3) float64; entry [:, a, b] is ∂^(a+b)S / ∂u^a ∂v^b

        Raises
        ------
        InputError
            a parameter outside the domain by more than rounding.
        """
        pairs = self.checked(uv)
        k = kv.check_order(order) + 1
        out = np.zeros((len(pairs), k, k, 3))
        run_ranges(nb.surface_range, len(pairs), MIN_POINTS, self._arrays, pairs, order, out)
        return out

    def normal(self, uv: ArrayLike) -> FloatArray:
        """Return unit normals (k, 3) to the free side at `uv` (k, 2); errors of `checked`.

        Where ``S_u × S_v`` vanishes (a pole, a collapsed corner) it is the limit from inside the
        domain. At the apex of a cone, where that limit depends on the direction, it is the limit
        along the iso-line that runs into it: the normal of that generator. Rows are NaN
        where the surface has no area around the point, and where all derivatives of ``S_u × S_v``
        along the inward direction vanish up to order 5, as at a pole to which the surface contracts
        like u⁴.
        """
        pairs = self.checked(uv)
        out = np.zeros((len(pairs), 3))
        run_ranges(nb.normal_range, len(pairs), MIN_POINTS, self._arrays, pairs, out)
        return out

    def _refined(self, U: FloatArray, V: FloatArray) -> Self:
        """Return the same surface, or a part of it, on finer clamped knots."""
        points = self.homogeneous
        for axis, old, new in ((0, self.knots[0], U), (1, self.knots[1], V)):
            if new is not old:
                points = refine.refine_points(old, self.degrees[axis], points, new, axis)
        return self._from_net(
            self.degrees, (U, V), cartesian(points, self.is_rational), self.is_rational
        )

    def insert_knots(self, u: ArrayLike = (), v: ArrayLike = ()) -> Self:
        """Return the same surface with knots inserted (several at once, existing ones too).

        Raises GeometryError for a knot outside the open domain, or more often than its degree.
        """
        (p, q), (U, V) = self.degrees, self.knots
        return self._refined(refine.with_inserted(U, p, u, "u"), refine.with_inserted(V, q, v, "v"))

    def elevate(self, u: int = 0, v: int = 0) -> Self:
        """Return the same surface with its degrees raised by `u` and `v`, as smooth as before.

        Raises
        ------
        InputError
            `u` or `v` is not a whole number from 0 on.
        GeometryError
            A degree would exceed 15.
        """
        points, degrees, knots = self.homogeneous, list(self.degrees), list(self.knots)
        for axis, steps in enumerate((u, v)):
            kv.check_degree(degrees[axis] + kv.check_order(steps), "degree after elevation")
            for _ in range(steps):
                knots[axis], points = refine.elevate_points(
                    knots[axis], degrees[axis], points, axis
                )
                degrees[axis] += 1
        return self._from_net(
            (degrees[0], degrees[1]),
            (knots[0], knots[1]),
            cartesian(points, self.is_rational),
            self.is_rational,
        )

    def k_refined(self, degrees: tuple[int, int], u: ArrayLike = (), v: ArrayLike = ()) -> Self:
        """Return the same surface elevated by `degrees`, then refined by knots (k-refinement)."""
        return self.elevate(*degrees).insert_knots(u, v)

    def restricted(self, u: tuple[float, float], v: tuple[float, float]) -> Self:
        """Return the part over the box `u` × `v`, with its parameters unchanged.

        Raises GeometryError unless that is a part of the domain, of some width.
        """
        for (low, high), (a, b), name in zip((u, v), self.domain, "uv", strict=True):
            if not a <= low < high <= b:
                raise GeometryError(
                    "not a part of the domain",
                    where=name,
                    found=(low, high),
                    allowed=f"within [{a!r}, {b!r}]",
                )
        (p, q), (U, V) = self.degrees, self.knots
        return self._refined(
            kv.clamped(U, p, float(u[0]), float(u[1])), kv.clamped(V, q, float(v[0]), float(v[1]))
        )

    def split(self, *, u: float | None = None, v: float | None = None) -> tuple[Self, Self]:
        """Return the parts before and after the iso-line at `u` or at `v`, one of which is given.

        Raises GeometryError for both or none, or a parameter that is not strictly inside.
        """
        axis, t = _one_of(u, v)
        inner = kv.check_inner_parameter(t, self.domain[axis], "uv"[axis])
        (a, b), full = self.domain[axis], self.domain[1 - axis]
        if axis == 0:
            return self.restricted((a, inner), full), self.restricted((inner, b), full)
        return self.restricted(full, (a, inner)), self.restricted(full, (inner, b))

    def isocurve(self, *, u: float | None = None, v: float | None = None) -> NurbsCurve:
        """Return the iso-curve at a fixed `u` (running along v) or a fixed `v`.

        Raises GeometryError for both or none, InputError outside the domain.
        """
        axis, t = _one_of(u, v)
        weights = kv.basis(self.knots[axis], self.degrees[axis], [t])[0, 0]
        net = np.moveaxis(self.homogeneous, axis, 0)
        points = product(weights, net.reshape(len(net), -1)).reshape(-1, 4)
        return NurbsCurve._from_homogeneous(
            self.degrees[1 - axis], self.knots[1 - axis], points, self.is_rational
        )

    def flipped(self) -> Self:
        """Return the same surface with its sides swapped: u is reversed over the same domain."""
        U, V = self.knots
        return self._from_net(
            self.degrees, (kv.mirrored(U), V), self._arrays.net[::-1], self.is_rational
        )

    def transposed(self) -> Self:
        """Return the same surface with u and v exchanged, which swaps its sides too."""
        (p, q), (U, V) = self.degrees, self.knots
        return self._from_net((q, p), (V, U), self._arrays.net.transpose(1, 0, 2), self.is_rational)

    def _moved(self, matrix: FloatArray) -> Self:
        net = np.array(self._arrays.net)
        net[..., :3] = transform.apply(matrix, self.control_points)
        moved = self._from_net(self.degrees, self.knots, net, self.is_rational)
        return moved.flipped() if transform.reflects(matrix) else moved

    def area(self, rtol: float = 1e-10) -> float:
        """Return the area to the relative tolerance `rtol`, by Gauss quadrature on each element."""
        return surface_area(self, rtol)

    def net_area(self) -> float:
        """Return the area of the triangulated control net: see `tessellate.net_area`."""
        return tessellate.net_area(self)

    def base_area(self) -> float:
        """Return the area of the flat bases of elements: see `tessellate.base_area`."""
        return tessellate.base_area(self)

    def tessellate(self, tol: float, *, method: Literal["net", "chord"] = "chord") -> TriMesh:
        """Return triangles to a tolerance: see `contiga.geometry.tessellate.tessellate`."""
        return tessellate.tessellate(self, tol, method)


def _one_of(u: float | None, v: float | None) -> tuple[int, float]:
    """Return axis and value of the parameter that is not None; GeometryError for both or none."""
    if (u is None) == (v is None):
        raise GeometryError("give either u or v", found={"u": u, "v": v})
    return (0, float(u)) if u is not None else (1, float(v))  # type: ignore[arg-type]
