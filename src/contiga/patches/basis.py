"""B-spline and NURBS basis functions of a patch with their derivatives, for many points at once."""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np

from contiga.records import FloatArray, IndexArray, IntArray

ORDERS = ((0, 0), (1, 0), (0, 1), (2, 0), (0, 2), (1, 1))
"""Derivatives in u and v of `BasisAt.values`, in their order."""
VALUE, U, V, UU, VV, UV = range(6)


class Patch(Protocol):
    """The members of a patch that are read: `contiga.NurbsSurface` has them."""

    @property
    def degrees(self) -> tuple[int, int]:
        """Degrees (p, q)."""

    @property
    def knots(self) -> tuple[FloatArray, FloatArray]:
        """Knots (U, V), clamped."""

    @property
    def control_points(self) -> FloatArray:
        """Control points (n, m, 3)."""

    @property
    def weights(self) -> FloatArray | None:
        """Weights (n, m), or None for a B-spline."""


class BasisAt(NamedTuple):
    """Basis functions of a patch at k points, those that are not zero there."""

    control: IntArray
    """(k, c) control points: row i m + j of a net (n, m)."""
    values: FloatArray
    """(k, 6, c) N, N_u, N_v, N_uu, N_vv, N_uv."""

    def of(self, order: int, net: FloatArray) -> FloatArray:
        """Return (k, 3) a derivative of the surface of control points (r, 3): `VALUE` to `UV`."""
        return np.asarray((self.values[:, order, :, None] * net[self.control]).sum(axis=1))


class _Spans(NamedTuple):
    """Basis functions along one direction."""

    first: IndexArray
    """(k,) the first that is not zero."""
    values: FloatArray
    """(k, 3, p + 1) values, first and second derivatives."""


def basis_at(patch: Patch, uv: FloatArray) -> BasisAt:
    """Basis functions at parameters (k, 2); on a knot those of the element to its right."""
    (p, q), (U_knots, V_knots) = patch.degrees, patch.knots
    along, across = spans_at(U_knots, p, uv[:, 0]), spans_at(V_knots, q, uv[:, 1])
    count = len(V_knots) - q - 1
    rows = along.first[:, None] + np.arange(p + 1)
    columns = across.first[:, None] + np.arange(q + 1)
    control = (rows[:, :, None] * count + columns[:, None, :]).reshape(len(uv), -1)
    products = [along.values[:, i, :, None] * across.values[:, j, None, :] for i, j in ORDERS]
    values = np.stack([each.reshape(len(uv), -1) for each in products], axis=1)
    if patch.weights is not None:
        values = _rational(values * patch.weights.ravel()[control][:, None, :])
    return BasisAt(control.astype(np.int32), values)


def _rational(values: FloatArray) -> FloatArray:
    """Return rational basis functions and derivatives from weighted ones, by the quotient rule."""
    sums = values.sum(axis=2, keepdims=True)
    w, w_u, w_v, w_uu, w_vv, w_uv = (sums[:, k] for k in range(6))
    n = values[:, VALUE] / w
    n_u, n_v = (values[:, U] - n * w_u) / w, (values[:, V] - n * w_v) / w
    n_uu = (values[:, UU] - 2.0 * n_u * w_u - n * w_uu) / w
    n_vv = (values[:, VV] - 2.0 * n_v * w_v - n * w_vv) / w
    n_uv = (values[:, UV] - n_u * w_v - n_v * w_u - n * w_uv) / w
    return np.stack([n, n_u, n_v, n_uu, n_vv, n_uv], axis=1)


def spans_at(knots: FloatArray, degree: int, t: FloatArray) -> _Spans:
    """Basis functions at parameters (k,) that lie in the domain.

    Each derivative begins with the basis of a lower degree (The NURBS Book, Eq. 2.5 and 2.7).
    """
    last = len(knots) - degree - 2
    span = np.clip(np.searchsorted(knots, t, side="right") - 1, degree, last)
    values = np.zeros((len(t), 3, degree + 1))
    for order in range(min(degree, 2) + 1):
        values[:, order] = _derivative(knots, degree, span, t, order)
    return _Spans(span - degree, values)


def _derivative(
    knots: FloatArray, degree: int, span: IndexArray, t: FloatArray, order: int
) -> FloatArray:
    """Return derivatives (k, degree + 1): the basis is raised, then differenced `order` times."""
    values = np.ones((len(t), 1))
    for j in range(1, degree + 1):
        new = np.zeros((len(t), j + 1))
        for r in range(j):
            high, low = knots[span + r + 1], knots[span + r + 1 - j]
            share = values[:, r] / (high - low)
            if j <= degree - order:
                new[:, r] += share * (high - t)
                new[:, r + 1] += share * (t - low)
            else:
                new[:, r] -= j * share
                new[:, r + 1] += j * share
        values = new
    return values


def elements_of(knots: FloatArray) -> FloatArray:
    """Return (e, 2) the intervals between different knots."""
    breaks = np.unique(knots)
    return np.stack([breaks[:-1], breaks[1:]], axis=1)
