"""Rigorous bounds on the first derivatives of a surface.

A first derivative of a rational element is ``N / w²`` with a polynomial N. The Bernstein
coefficients of N come from exact products, so their largest length is a true bound, and the
cancellation in N counts, which a bound term by term would lose.
"""

from __future__ import annotations

import math

import numpy as np

from contiga.geometry.bezier import extract
from contiga.geometry.surface import NurbsSurface
from contiga.records import FloatArray


def first_derivative_bounds(
    surface: NurbsSurface, parts: int
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return upper bounds of |S_u| and |S_v| over elements cut in `parts` in each direction.

    Returns
    -------
    bounds : (2, nu, nv), for parameters that run from 0 to 1 in each part
    u_breaks, v_breaks : (nu + 1,) and (nv + 1,) borders of the parts
    """
    centred = surface.translated(-surface.bounds().mean(axis=0))
    shares = np.arange(1, parts) / parts
    cuts = []
    for knots in centred.knots:
        borders = np.unique(knots)
        cuts.append((borders[:-1, None] + np.diff(borders)[:, None] * shares).ravel())
    coefs, u_breaks, v_breaks = extract(centred, cuts[0], cuts[1])
    A, w = coefs[..., :3], coefs[..., 3:]
    if not surface.is_rational:
        return np.array([_largest(_slope(A, 2)), _largest(_slope(A, 3))]), u_breaks, v_breaks
    smallest = w.min(axis=(2, 3, 4)) ** 2
    bounds = np.array([_largest(numerator(A, w, axis)) / smallest for axis in (2, 3)])
    return bounds, u_breaks, v_breaks


def _slope(coefs: FloatArray, axis: int) -> FloatArray:
    """Return Bernstein coefficients of the derivative along `axis`; a zero at degree 0."""
    degree = coefs.shape[axis] - 1
    if degree == 0:
        return np.zeros_like(coefs)
    return np.asarray(degree * np.diff(coefs, axis=axis))


def _product(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return Bernstein coefficients of a product: (..., p+1, q+1, d) by (..., r+1, s+1, 1)."""
    p, q, r, s = a.shape[-3] - 1, a.shape[-2] - 1, b.shape[-3] - 1, b.shape[-2] - 1
    scaled_a = a * _binomials(p, q)[..., None]
    scaled_b = b * _binomials(r, s)[..., None]
    out = np.zeros((*a.shape[:-3], p + r + 1, q + s + 1, a.shape[-1]))
    for i in range(r + 1):
        for j in range(s + 1):
            out[..., i : i + p + 1, j : j + q + 1, :] += (
                scaled_a * scaled_b[..., i : i + 1, j : j + 1, :]
            )
    return np.asarray(out / _binomials(p + r, q + s)[..., None])


def _binomials(p: int, q: int) -> FloatArray:
    """Return (p + 1, q + 1) products of binomial coefficients, C(p, i) C(q, j)."""
    in_u, in_v = ([float(math.comb(n, k)) for k in range(n + 1)] for n in (p, q))
    return np.outer(in_u, in_v)


def _largest(coefs: FloatArray) -> FloatArray:
    """Return the largest length of the coefficients of each element."""
    return np.asarray(np.linalg.norm(coefs, axis=-1).max(axis=(-2, -1)))


def numerator(A: FloatArray, w: FloatArray, axis: int) -> FloatArray:
    """Return Bernstein coefficients of A_a w − A w_a, the numerator of a first derivative.

    `axis` is that of the parameter a in `A` (nu, nv, p + 1, q + 1, d) and `w` (…, 1).
    """
    slope = _product(_raised(_slope(A, axis), A), w)
    return slope - _product(A, _raised(_slope(w, axis), w))


def _raised(coefs: FloatArray, like: FloatArray) -> FloatArray:
    """Return `coefs` elevated to the degrees of `like`: a derivative is one degree lower."""
    p, q = like.shape[-3] - coefs.shape[-3], like.shape[-2] - coefs.shape[-2]
    return _product(coefs, np.ones((p + 1, q + 1, 1))) if p or q else coefs
