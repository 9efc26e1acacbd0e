"""How fast a surface runs and bends: rigorous bounds on its first and second derivatives.

The derivatives of a rational element are ``N / w²`` and ``N / w³`` with polynomials N. Their
Bernstein coefficients are found by exact products, so the largest length is a true bound, with
none of the cancellation lost that a bound term by term would lose.
"""

from __future__ import annotations

import numpy as np
from scipy.special import binom

from contiga.geometry.bezier import extract
from contiga.geometry.surface import NurbsSurface
from contiga.records import FloatArray

# Elements are cut in so many parts each way before they are bounded, which tightens the bound.
_PARTS = 2


def second_derivative_bounds(
    surface: NurbsSurface,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Bounds on |S_uu|, |S_uv| and |S_vv| over each element.

    Returns
    -------
    bounds : (3, nu, nv), for parameters that run from 0 to 1 in each element
    u_breaks, v_breaks : (nu + 1,) and (nv + 1,) borders of the elements
    """
    coefs, u_breaks, v_breaks = _elements(surface, _PARTS)
    bounds = _second_rational(coefs) if surface.is_rational else _second(coefs[..., :3])
    nu, nv = bounds.shape[1] // _PARTS, bounds.shape[2] // _PARTS
    of_parts = bounds.reshape(3, nu, _PARTS, nv, _PARTS).max(axis=(2, 4))
    return of_parts * _PARTS**2, u_breaks[::_PARTS], v_breaks[::_PARTS]


def first_derivative_bounds(
    surface: NurbsSurface, parts: int
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Bounds (2, nu, nv) on |S_u| and |S_v| over elements cut in `parts` each way, and borders.

    As `second_derivative_bounds`; the borders returned are those of the parts.
    """
    coefs, u_breaks, v_breaks = _elements(surface, parts)
    A, w = coefs[..., :3], coefs[..., 3:]
    if not surface.is_rational:
        return np.array([_largest(_slope(A, 2)), _largest(_slope(A, 3))]), u_breaks, v_breaks
    smallest = w.min(axis=(2, 3, 4)) ** 2
    bounds = np.array([_largest(_numerator(A, w, axis)) / smallest for axis in (2, 3)])
    return bounds, u_breaks, v_breaks


def _elements(surface: NurbsSurface, parts: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Bernstein coefficients of all elements cut in `parts` each way, about a near origin."""
    whole = surface.translated(-surface.bounds().mean(axis=0))
    cuts = []
    for knots in whole.knots:
        borders = np.unique(knots)
        shares = np.arange(1, parts) / parts
        cuts.append((borders[:-1, None] + np.diff(borders)[:, None] * shares).ravel())
    return extract(whole, cuts[0], cuts[1])


def _slope(coefs: FloatArray, axis: int) -> FloatArray:
    """Bernstein coefficients of the derivative along `axis`."""
    degree = coefs.shape[axis] - 1
    if degree == 0:
        return np.zeros_like(coefs)
    return np.asarray(degree * np.diff(coefs, axis=axis))


def _product(a: FloatArray, b: FloatArray) -> FloatArray:
    """Bernstein coefficients of a product: (..., p+1, q+1, d) times (..., r+1, s+1, 1)."""
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
    return np.outer(binom(p, np.arange(p + 1)), binom(q, np.arange(q + 1)))


def _largest(coefs: FloatArray) -> FloatArray:
    """Largest length of the coefficients of each element."""
    return np.asarray(np.linalg.norm(coefs, axis=-1).max(axis=(-2, -1)))


def _second(coefs: FloatArray) -> FloatArray:
    u, v = _slope(coefs, 2), _slope(coefs, 3)
    return np.array([_largest(_slope(u, 2)), _largest(_slope(u, 3)), _largest(_slope(v, 3))])


def _second_rational(coefs: FloatArray) -> FloatArray:
    """With S = A / w: S_u = F / w², F = A_u w − A w_u, and S_ua = (F_a w − 2 F w_a) / w³."""
    A, w = coefs[..., :3], coefs[..., 3:]
    smallest = w.min(axis=(2, 3, 4)) ** 3
    w_u, w_v = _raised(_slope(w, 2), w), _raised(_slope(w, 3), w)
    F, G = _numerator(A, w, 2), _numerator(A, w, 3)
    second = (
        _product(_raised(_slope(F, 2), F), w) - 2.0 * _product(F, w_u),
        _product(_raised(_slope(F, 3), F), w) - 2.0 * _product(F, w_v),
        _product(_raised(_slope(G, 3), G), w) - 2.0 * _product(G, w_v),
    )
    return np.array([_largest(N) / smallest for N in second])


def _numerator(A: FloatArray, w: FloatArray, axis: int) -> FloatArray:
    """Coefficients of A_a w − A w_a, the numerator of a first derivative."""
    slope = _product(_raised(_slope(A, axis), A), w)
    return slope - _product(A, _raised(_slope(w, axis), w))


def _raised(coefs: FloatArray, like: FloatArray) -> FloatArray:
    """`coefs` written in the degrees of `like`: a derivative is one degree short."""
    p, q = like.shape[-3] - coefs.shape[-3], like.shape[-2] - coefs.shape[-2]
    return _product(coefs, np.ones((p + 1, q + 1, 1))) if p or q else coefs
