"""Arrays of intervals; ranges of polynomials and quotients over boxes by Bernstein coefficients.

Ends are rounded to nearest, not outwards: a claim needs a margin wider than that.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from contiga.records import FloatArray

ORDERS = ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2))
"""Orders of the derivatives of a range in the two variables."""


@dataclass(frozen=True)
class Span:
    """Numbers known to lie between `low` and `high`, arrays of one shape."""

    low: FloatArray
    high: FloatArray

    def __add__(self, other: Span) -> Span:
        return Span(self.low + other.low, self.high + other.high)

    def __sub__(self, other: Span) -> Span:
        return Span(self.low - other.high, self.high - other.low)

    def __mul__(self, other: Span) -> Span:
        a, b = self.low * other.low, self.low * other.high
        c, d = self.high * other.low, self.high * other.high
        return Span(
            np.minimum(np.minimum(a, b), np.minimum(c, d)),
            np.maximum(np.maximum(a, b), np.maximum(c, d)),
        )

    def __truediv__(self, other: Span) -> Span:
        """Divide by a span of positive numbers."""
        return Span(
            np.minimum(self.low / other.low, self.low / other.high),
            np.maximum(self.high / other.low, self.high / other.high),
        )

    def times(self, factor: float) -> Span:
        """Return the product with a factor that is not negative."""
        return Span(factor * self.low, factor * self.high)

    @property
    def size(self) -> FloatArray:
        """Largest absolute values."""
        return np.maximum(-self.low, self.high)


def restriction(degree: int, low: FloatArray, high: FloatArray) -> FloatArray:
    """Return maps (m, degree + 1, degree + 1) of Bernstein coefficients to [low, high].

    Row i is the blossom at (low^(degree − i), high^i).
    """
    m = len(low)
    out = np.zeros((m, degree + 1, degree + 1))
    for i in range(degree + 1):
        out[:, i, 0] = 1.0
        for k in range(degree):
            x = (high if k < i else low)[:, None]
            row = out[:, i].copy()
            out[:, i] = (1.0 - x) * row
            out[:, i, 1:] += x * row[:, :-1]
    return out


def elevated(net: FloatArray, degree: int) -> FloatArray:
    """Return Bernstein coefficients along the last axis, elevated to a degree unless higher."""
    while (n := net.shape[-1]) <= degree:
        share = np.arange(n + 1) / n
        first = np.concatenate([net, np.zeros_like(net[..., :1])], axis=-1)
        last = np.concatenate([np.zeros_like(net[..., :1]), net], axis=-1)
        net = (1.0 - share) * first + share * last
    return net


def less_a_factor(net: FloatArray) -> FloatArray:
    """Return the coefficients along the last axis of a polynomial divided by its variable.

    The first coefficients are zero.
    """
    degree = net.shape[-1] - 1
    return net[..., 1:] * (degree / np.arange(1.0, degree + 1.0))


def basis(degree: int, x: FloatArray) -> FloatArray:
    """Return (len(x), degree + 1) Bernstein polynomials at places x in [0, 1]."""
    k = np.arange(degree + 1)
    count = np.array([float(math.comb(degree, int(i))) for i in k])
    return count * x[:, None] ** k * (1.0 - x[:, None]) ** (degree - k)


def spans_of(net: FloatArray, widths: tuple[FloatArray, FloatArray]) -> list[Span]:
    """Return ranges of polynomials and their derivatives, one span for each of `ORDERS`.

    The polynomials are nets (p + 1, q + 1, …) over boxes with the widths `widths` in their two
    variables. The boxes come last: the least of few coefficients of many is computed ten times as
    fast so.
    """
    result = []
    for order in ORDERS:
        derivative = net
        for axis in range(2):
            for _ in range(order[axis]):
                degree = derivative.shape[axis] - 1
                if degree == 0:
                    derivative = np.zeros_like(derivative)
                else:
                    derivative = degree * np.diff(derivative, axis=axis) / widths[axis]
        result.append(Span(derivative.min(axis=(0, 1)), derivative.max(axis=(0, 1))))
    return result


def quotient(n: list[Span], w: list[Span]) -> list[Span]:
    """Return ranges of a quotient and its derivatives from those of numerator and denominator.

    All are in the order of `ORDERS`; the denominator is positive.
    """
    v = n[0] / w[0]
    x = (n[1] - v * w[1]) / w[0]
    y = (n[2] - v * w[2]) / w[0]
    xx = (n[3] - (x * w[1]).times(2.0) - v * w[3]) / w[0]
    xy = (n[4] - x * w[2] - y * w[1] - v * w[4]) / w[0]
    yy = (n[5] - (y * w[2]).times(2.0) - v * w[5]) / w[0]
    return [v, x, y, xx, xy, yy]
