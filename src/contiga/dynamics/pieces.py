"""Vectors over time as polynomials between rows of a table, with their exact integrals.

Between rows a table is linear, or a monotone cubic that never leaves the range of the rows beside
it (F. N. Fritsch, J. Butland, A method for constructing local monotone piecewise cubic
interpolants, SIAM J. Sci. Stat. Comput. 5, 1984; scipy's ``PchipInterpolator``).
"""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from contiga.arrays.layout import read_only
from contiga.dynamics.kinks import bends_of
from contiga.records import FloatArray

_N_SAMPLES = 8
"""Number of parts in which a curved piece is sampled."""


@dataclass(frozen=True)
class Pieces:
    """Piecewise polynomial of time, with one polynomial of t − tₖ between two times.

    Parameters
    ----------
    times : n of them, strictly increasing, n ≥ 2
    coefficients : (n − 1, d + 1, 3) of each piece, the constant first
    """

    times: tuple[float, ...]
    coefficients: FloatArray

    def value(self, t: float, order: int = 0) -> FloatArray:
        """Return the derivative (3,) of `order`, up to 2, at `t`; the outer pieces extrapolate.

        It is right-continuous at breakpoints, and left-continuous at the last one.
        """
        k = min(max(bisect_right(self.times, t), 1), len(self.times) - 1) - 1
        rows = self._derivatives[order][k].tolist()
        s = t - self.times[k]
        x, y, z = rows.pop()
        # Plain numbers take 2 µs, arrays of three 12 µs.
        while rows:
            a, b, c = rows.pop()
            x, y, z = a + s * x, b + s * y, c + s * z
        return np.array([x, y, z])

    @cached_property
    def _derivatives(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Coefficients of the function and its first two derivatives, one row or more each."""
        first = _derivative(self.coefficients)
        return self.coefficients, first, _derivative(first)

    def kinks(self, order: int = 0) -> FloatArray:
        """Return the times at which steps must end so that the derivative of `order` is resolved.

        They are bends of the table by `bends_of`; curved pieces are cut into `_N_SAMPLES` parts.
        """
        rows, times = self._derivatives[order], np.array(self.times)
        is_curved = rows.shape[1] > 2 and rows[:, 2:].any()
        shares = np.arange(_N_SAMPLES) / _N_SAMPLES if is_curved else np.zeros(1)
        s = np.diff(times)[:, None] * shares
        values = np.zeros((*s.shape, 3))
        for k in range(rows.shape[1] - 1, -1, -1):
            values = rows[:, k, None, :] + s[..., None] * values
        times = np.append((times[:-1, None] + s).ravel(), times[-1])
        return bends_of(times, np.vstack([values.reshape(-1, 3), self.value(times[-1], order)]))

    def integral(self, start: FloatArray) -> Pieces:
        """Return the integral from the first time on, with the value `start` (3,) there.

        A piece begins with the same bits with which the previous one ends.
        """
        count = self.coefficients.shape[1]
        primitive = self.coefficients / np.arange(1.0, count + 1.0)[:, None]
        spans = np.diff(self.times)[:, None]
        # Horner's scheme as in `value`, so that pieces join to the last bit.
        increments = primitive[:, -1]
        for k in range(count - 2, -1, -1):
            increments = primitive[:, k] + spans * increments
        increments = spans * increments
        starts = np.cumsum(np.concatenate([start[None], increments[:-1]]), axis=0)
        return Pieces(self.times, read_only(np.concatenate([starts[:, None], primitive], axis=1)))


def pieces_between(times: FloatArray, rows: FloatArray, *, smooth: bool) -> Pieces:
    """Return the function through `rows` (n, 3) at `times` (n,), n ≥ 2; `smooth` is cubic.

    The cubics are monotone between rows, see the head of the module.
    """
    instants = tuple(times.tolist())
    if smooth:
        from scipy.interpolate import PchipInterpolator

        descending = PchipInterpolator(times, rows, axis=0).c
        return Pieces(instants, read_only(descending[::-1].swapaxes(0, 1)))
    slopes = np.diff(rows, axis=0) / np.diff(times)[:, None]
    return Pieces(instants, read_only(np.stack([rows[:-1], slopes], axis=1)))


def _derivative(coefficients: FloatArray) -> FloatArray:
    """Return the coefficients of the derivative; of a constant, one row of zeros."""
    count = coefficients.shape[1]
    if count == 1:
        return np.zeros_like(coefficients)
    return coefficients[:, 1:] * np.arange(1.0, count)[:, None]
