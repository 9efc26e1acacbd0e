"""Move places on a surface along with its control points, and spread forces at places to these.

A place moves along with the surface at its foot: with u the parameters of the foot S(u) and
r = x − S(u), the motion of x is δ = Σ N_i δP_i + ω × r, where ω turns the surface there. With
a_α = ∂S/∂u^α, their duals a^α and the normal n,

    ω = Σ_α (n·δa_α) a^α × n + ½ n Σ_α (n × a^α)·δa_α,

which is the spin itself where the surface moves rigidly. Forces on control points are the
transpose: the work of f over δ is that of F_i over δP_i. So Σ F_i = f and Σ P_i × F_i = x × f, both
to rounding.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from contiga.arrays.kernels.vector_nb import cross, dot
from contiga.geometry.kernels.basis_nb import basis_derivatives, find_span
from contiga.geometry.kernels.evaluate_nb import SurfaceArrays
from contiga.jit import inner, kernel
from contiga.jit.scratch import scratch, stack_int64
from contiga.pointer_records import pass_by_pointer

MIN_SQUARE_SINE = 1e-14
"""Squared sine between S_u and S_v below which a surface has no normal, and no rotation."""
MAX_ORDER = 16
"""Highest degree plus one."""
MAX_POINTS = 256
"""Largest number of control points that a place depends on."""


@pass_by_pointer
class NetPatch(NamedTuple):
    """A patch of a body whose control points are rows of one array."""

    surface: SurfaceArrays
    """Surface at rest; only degrees, knots and weights are read."""
    control: np.ndarray
    """(n, m) rows."""


@pass_by_pointer
class Influence(NamedTuple):
    """Influence of c control points on each of k places on a patch."""

    control: np.ndarray
    """(k, c) rows of the control points."""
    value: np.ndarray
    """(k, c) their basis functions."""
    gradient: np.ndarray
    """(k, c, 3) gradients of these along the surface, one over length."""
    hessian: np.ndarray
    """(k, c, 3, 3) second covariant derivatives along the surface, one over length squared."""
    normal: np.ndarray
    """(k, 3) unit normals of the surface; zero where it has none."""


class Frame(NamedTuple):
    """Axes of a surface at a place."""

    normal: tuple[float, float, float]
    dual_u: tuple[float, float, float]
    dual_v: tuple[float, float, float]


@inner()
def _span(knots, degree, count, t):
    """Return the span of `find_span`; a guess for uniform knots mostly avoids the search."""
    share = (t - knots[degree]) / (knots[count] - knots[degree])
    k = degree + int(min(max(share, 0.0), 1.0) * (count - degree))
    if k < count and knots[k] <= t < knots[k + 1]:
        return k
    return find_span(knots, degree, count, t)


@inner()
def _functions(knots, degree, span, t, N):
    """Write the basis functions of one parameter to N[0], their first derivatives to N[1].

    The NURBS Book, Eq. 2.5 and 2.7.
    """
    N[0, 0] = 1.0
    for j in range(1, degree + 1):
        saved = 0.0
        for r in range(j):
            low, high = knots[span + r + 1 - j], knots[span + r + 1]
            share = N[0, r] / (high - low)
            N[1, r] = degree * share  # after the last round: terms of the derivatives
            N[0, r] = saved + (high - t) * share
            saved = (t - low) * share
        N[0, j] = saved
    above = 0.0
    for r in range(degree):
        below = N[1, r]
        N[1, r] = above - below
        above = below
    N[1, degree] = above


@inner()
def _basis(patch, u, v, N_u, N_v, rows, values):
    """Write the k control points `rows` that a place depends on, and `values` (k, 3); return k.

    Values are the rational basis functions there and their derivatives by u and by v. `N_u` and
    `N_v` are work arrays for basis functions of one parameter.
    """
    s, control = patch.surface, patch.control
    span_u = _span(s.U, s.p, s.net.shape[0], u)
    span_v = _span(s.V, s.q, s.net.shape[1], v)
    _functions(s.U, s.p, span_u, u, N_u)
    _functions(s.V, s.q, span_v, v, N_v)
    k = 0
    w = w_u = w_v = 0.0
    for i in range(s.p + 1):
        for j in range(s.q + 1):
            row, column = span_u - s.p + i, span_v - s.q + j
            weight = s.net[row, column, 3]
            rows[k] = control[row, column]
            values[k, 0] = N_u[0, i] * N_v[0, j] * weight
            values[k, 1] = N_u[1, i] * N_v[0, j] * weight
            values[k, 2] = N_u[0, i] * N_v[1, j] * weight
            w += values[k, 0]
            w_u += values[k, 1]
            w_v += values[k, 2]
            k += 1
    if s.rational:
        inverse = 1.0 / w
        for i in range(k):
            values[i, 0] *= inverse
            values[i, 1] = (values[i, 1] - values[i, 0] * w_u) * inverse
            values[i, 2] = (values[i, 2] - values[i, 0] * w_v) * inverse
    return k


@inner()
def _second_derivatives(patch, u, v, values, N_u, N_v, second):
    """Write the second derivatives of basis functions by uu, uv and vv to `second` (k, 3).

    `values` (k, 3) are those of `_basis` at the same place. `N_u` and `N_v` are work arrays for
    basis functions of one parameter and two derivatives.
    """
    s = patch.surface
    span_u = _span(s.U, s.p, s.net.shape[0], u)
    span_v = _span(s.V, s.q, s.net.shape[1], v)
    basis_derivatives(s.U, s.p, span_u, u, 2, N_u)
    basis_derivatives(s.V, s.q, span_v, v, 2, N_v)
    k = 0
    w = w_u = w_v = w_uu = w_uv = w_vv = 0.0
    for i in range(s.p + 1):
        for j in range(s.q + 1):
            weight = s.net[span_u - s.p + i, span_v - s.q + j, 3]
            second[k, 0] = N_u[2, i] * N_v[0, j] * weight
            second[k, 1] = N_u[1, i] * N_v[1, j] * weight
            second[k, 2] = N_u[0, i] * N_v[2, j] * weight
            w += N_u[0, i] * N_v[0, j] * weight
            w_u += N_u[1, i] * N_v[0, j] * weight
            w_v += N_u[0, i] * N_v[1, j] * weight
            w_uu += second[k, 0]
            w_uv += second[k, 1]
            w_vv += second[k, 2]
            k += 1
    if s.rational:
        inverse = 1.0 / w
        for i in range(k):
            N, R_u, R_v = values[i, 0], values[i, 1], values[i, 2]
            second[i, 0] = inverse * (second[i, 0] - 2.0 * R_u * w_u - N * w_uu)
            second[i, 1] = inverse * (second[i, 1] - R_u * w_v - R_v * w_u - N * w_uv)
            second[i, 2] = inverse * (second[i, 2] - 2.0 * R_v * w_v - N * w_vv)


class Sums(NamedTuple):
    """Sums over control points of the basis functions, and of their derivatives by u and by v."""

    value: tuple[float, float, float]
    by_u: tuple[float, float, float]
    by_v: tuple[float, float, float]


@inner()
def _sums(points, rows, values, k):
    """Return the `Sums` over the k control points of a place, `rows` of `points` (m, 3)."""
    x = y = z = x_u = y_u = z_u = x_v = y_v = z_v = 0.0
    for i in range(k):
        row, N, N_u, N_v = rows[i], values[i, 0], values[i, 1], values[i, 2]
        a, b, c = points[row, 0], points[row, 1], points[row, 2]
        x += N * a
        y += N * b
        z += N * c
        x_u += N_u * a
        y_u += N_u * b
        z_u += N_u * c
        x_v += N_v * a
        y_v += N_v * b
        z_v += N_v * c
    return Sums((x, y, z), (x_u, y_u, z_u), (x_v, y_v, z_v))


@inner()
def _frame(a_u, a_v):
    """Return the `Frame` of S_u and S_v; zeros if their squared sine is below `MIN_SQUARE_SINE`."""
    uu, uv, vv = dot(a_u, a_u), dot(a_u, a_v), dot(a_v, a_v)
    det = uu * vv - uv * uv
    if not det > MIN_SQUARE_SINE * uu * vv:
        zero = 0.0, 0.0, 0.0
        return Frame(zero, zero, zero)
    x, y, z = cross(a_u, a_v)
    size = 1.0 / math.sqrt(x * x + y * y + z * z)
    inverse = 1.0 / det
    return Frame(
        (x * size, y * size, z * size),
        (
            inverse * (vv * a_u[0] - uv * a_v[0]),
            inverse * (vv * a_u[1] - uv * a_v[1]),
            inverse * (vv * a_u[2] - uv * a_v[2]),
        ),
        (
            inverse * (uu * a_v[0] - uv * a_u[0]),
            inverse * (uu * a_v[1] - uv * a_u[1]),
            inverse * (uu * a_v[2] - uv * a_u[2]),
        ),
    )


@kernel()
def carry(patch, shape, change, uv, points, out, start, stop):
    """Write rows start … stop − 1 of the motions of `points` (k, 3), carried with their feet.

    They go to `out` (k, 3). The feet are at parameters `uv` (k, 2) of control points `shape`
    (m, 3), which change by `change` (m, 3). Motions are of first order in that; without a normal
    points do not rotate.
    """
    N_u, N_v = scratch(2, MAX_ORDER), scratch(2, MAX_ORDER)
    rows, values = stack_int64(MAX_POINTS), scratch(MAX_POINTS, 3)
    for k in range(start, stop):
        count = _basis(patch, uv[k, 0], uv[k, 1], N_u, N_v, rows, values)
        place, a_u, a_v = _sums(shape, rows, values, count)
        translation, d_u, d_v = _sums(change, rows, values, count)
        frame = _frame(a_u, a_v)
        n = frame.normal
        drill = 0.5 * (dot(cross(n, frame.dual_u), d_u) + dot(cross(n, frame.dual_v), d_v))
        u, v = dot(n, d_u), dot(n, d_v)
        tilt = cross(
            (
                u * frame.dual_u[0] + v * frame.dual_v[0],
                u * frame.dual_u[1] + v * frame.dual_v[1],
                u * frame.dual_u[2] + v * frame.dual_v[2],
            ),
            n,
        )
        spin = tilt[0] + drill * n[0], tilt[1] + drill * n[1], tilt[2] + drill * n[2]
        arm = points[k, 0] - place[0], points[k, 1] - place[1], points[k, 2] - place[2]
        rotation = cross(spin, arm)
        for c in range(3):
            out[k, c] = translation[c] + rotation[c]


@kernel()
def spread(patch, shape, uv, points, forces, out):
    """Add to `out` (m, 3) the forces on control points that are equivalent to `forces` (k, 3).

    These act at `points` (k, 3), which the surface with control points `shape` (m, 3) carries along
    at parameters `uv` (k, 2): the transpose of `carry`.
    """
    N_u, N_v = scratch(2, MAX_ORDER), scratch(2, MAX_ORDER)
    rows, values = stack_int64(MAX_POINTS), scratch(MAX_POINTS, 3)
    for k in range(uv.shape[0]):
        count = _basis(patch, uv[k, 0], uv[k, 1], N_u, N_v, rows, values)
        place, a_u, a_v = _sums(shape, rows, values, count)
        frame = _frame(a_u, a_v)
        n, f = frame.normal, (forces[k, 0], forces[k, 1], forces[k, 2])
        arm = points[k, 0] - place[0], points[k, 1] - place[1], points[k, 2] - place[2]
        couple = cross(arm, f)
        tilt, drill = cross(n, couple), 0.5 * dot(n, couple)
        u, v = dot(tilt, frame.dual_u), dot(tilt, frame.dual_v)
        tangent_u, tangent_v = cross(n, frame.dual_u), cross(n, frame.dual_v)
        x_u, y_u, z_u = (
            u * n[0] + drill * tangent_u[0],
            u * n[1] + drill * tangent_u[1],
            u * n[2] + drill * tangent_u[2],
        )
        x_v, y_v, z_v = (
            v * n[0] + drill * tangent_v[0],
            v * n[1] + drill * tangent_v[1],
            v * n[2] + drill * tangent_v[2],
        )
        for i in range(count):
            row, N, N_u_i, N_v_i = rows[i], values[i, 0], values[i, 1], values[i, 2]
            out[row, 0] += N * f[0] + N_u_i * x_u + N_v_i * x_v
            out[row, 1] += N * f[1] + N_u_i * y_u + N_v_i * y_v
            out[row, 2] += N * f[2] + N_u_i * z_u + N_v_i * z_v


@kernel()
def influence(patch, shape, uv, out, start, stop):
    """Write rows start … stop − 1 of the `Influence` of control points `shape` (m, 3) on places.

    The places are at parameters `uv` (k, 2); derivatives are zero where there is no normal. With
    the Christoffel symbols Γ^γ_αβ = a^γ·S_αβ a Hessian is (N_αβ − Γ^γ_αβ N_γ) a^α ⊗ a^β.
    """
    N_u, N_v = scratch(2, MAX_ORDER), scratch(2, MAX_ORDER)
    D_u, D_v = scratch(3, MAX_ORDER), scratch(3, MAX_ORDER)
    rows, values, second = stack_int64(MAX_POINTS), scratch(MAX_POINTS, 3), scratch(MAX_POINTS, 3)
    for k in range(start, stop):
        u, v = uv[k, 0], uv[k, 1]
        count = _basis(patch, u, v, N_u, N_v, rows, values)
        _second_derivatives(patch, u, v, values, D_u, D_v, second)
        _, a_u, a_v = _sums(shape, rows, values, count)
        S_uu, S_uv, S_vv = _sums(shape, rows, second, count)
        frame = _frame(a_u, a_v)
        dual_u, dual_v = frame.dual_u, frame.dual_v
        for c in range(3):
            out.normal[k, c] = frame.normal[c]
        for i in range(count):
            by_u, by_v = values[i, 1], values[i, 2]
            uu = second[i, 0] - dot(dual_u, S_uu) * by_u - dot(dual_v, S_uu) * by_v
            mixed = second[i, 1] - dot(dual_u, S_uv) * by_u - dot(dual_v, S_uv) * by_v
            vv = second[i, 2] - dot(dual_u, S_vv) * by_u - dot(dual_v, S_vv) * by_v
            out.control[k, i] = rows[i]
            out.value[k, i] = values[i, 0]
            for c in range(3):
                out.gradient[k, i, c] = by_u * dual_u[c] + by_v * dual_v[c]
                along_u, along_v = (
                    uu * dual_u[c] + mixed * dual_v[c],
                    mixed * dual_u[c] + vv * dual_v[c],
                )
                for d in range(3):
                    out.hessian[k, i, c, d] = along_u * dual_u[d] + along_v * dual_v[d]
