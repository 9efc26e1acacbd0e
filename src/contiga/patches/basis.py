"""B-spline and NURBS basis functions of a patch with their derivatives, for many points at once."""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np

from contiga.records import FloatArray, IndexArray, IntArray

ORDERS = ((0, 0), (1, 0), (0, 1), (2, 0), (0, 2), (1, 1))
"""Orders of the derivatives in u and in v, in the sequence of `BasisAt.values`."""
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
    """The nonzero basis functions of a patch at k points."""

    control: IntArray
    """(k, c) control points: row i m + j of a net (n, m)."""
    values: FloatArray
    """(k, 6, c) N, N_u, N_v, N_uu, N_vv, N_uv."""

    def of(self, order: int, net: FloatArray) -> FloatArray:
        """Return (k, 3) derivative `order` (`VALUE` to `UV`) of the surface with `net` (r, 3)."""
        return np.asarray((self.values[:, order, :, None] * net[self.control]).sum(axis=1))


class _Spans(NamedTuple):
    """Basis functions along one direction."""

    first: IndexArray
    """(k,) number of the first nonzero function."""
    values: FloatArray
    """(k, 3, p + 1) values, first and second derivatives."""


def basis_at(patch: Patch, uv: FloatArray) -> BasisAt:
    """Return the basis functions, first and second derivatives at parameters (k, 2) in the domain.

    They are right-continuous at inner knots and left-continuous at the last ones.
    """
    (p, q), (U_knots, V_knots) = patch.degrees, patch.knots
    in_u, in_v = spans_at(U_knots, p, uv[:, 0]), spans_at(V_knots, q, uv[:, 1])
    n_columns = len(V_knots) - q - 1
    rows = in_u.first[:, None] + np.arange(p + 1)
    columns = in_v.first[:, None] + np.arange(q + 1)
    control = (rows[:, :, None] * n_columns + columns[:, None, :]).reshape(len(uv), -1)
    products = [in_u.values[:, i, :, None] * in_v.values[:, j, None, :] for i, j in ORDERS]
    values = np.stack([product.reshape(len(uv), -1) for product in products], axis=1)
    if patch.weights is not None:
        # Rational functions by the quotient rule: each derivative needs the lower ones.
        values = values * patch.weights.ravel()[control][:, None, :]
        sums = values.sum(axis=2, keepdims=True)
        w, w_u, w_v, w_uu, w_vv, w_uv = (sums[:, k] for k in range(6))
        n = values[:, VALUE] / w
        n_u, n_v = (values[:, U] - n * w_u) / w, (values[:, V] - n * w_v) / w
        n_uu = (values[:, UU] - 2.0 * n_u * w_u - n * w_uu) / w
        n_vv = (values[:, VV] - 2.0 * n_v * w_v - n * w_vv) / w
        n_uv = (values[:, UV] - n_u * w_v - n_v * w_u - n * w_uv) / w
        values = np.stack([n, n_u, n_v, n_uu, n_vv, n_uv], axis=1)
    return BasisAt(control.astype(np.int32), values)


def spans_at(knots: FloatArray, degree: int, t: FloatArray) -> _Spans:
    """Return the B-spline basis functions of one direction, with two derivatives, at `t` (k,).

    Parameters are in the domain. Each derivative starts from the basis of a lower degree (The NURBS
    Book, Eq. 2.5 and 2.7); those above the degree are zero. Knots are right-continuous, the last
    one left-continuous.
    """
    last = len(knots) - degree - 2
    span = np.clip(np.searchsorted(knots, t, side="right") - 1, degree, last)
    result = np.zeros((len(t), 3, degree + 1))
    for order in range(min(degree, 2) + 1):
        # The degree is raised from 0 up; the last `order` steps are differences.
        values = np.ones((len(t), 1))
        for j in range(1, degree + 1):
            raised = np.zeros((len(t), j + 1))
            for r in range(j):
                high, low = knots[span + r + 1], knots[span + r + 1 - j]
                share = values[:, r] / (high - low)
                if j <= degree - order:
                    raised[:, r] += share * (high - t)
                    raised[:, r + 1] += share * (t - low)
                else:
                    raised[:, r] -= j * share
                    raised[:, r + 1] += j * share
            values = raised
        result[:, order] = values
    return _Spans(span - degree, result)


def elements_of(knots: FloatArray) -> FloatArray:
    """Return (e, 2) the lower and upper end of each nonempty knot span, ascending."""
    breaks = np.unique(knots)
    return np.stack([breaks[:-1], breaks[1:]], axis=1)
