"""Piecewise linear curves for kernels, and the results of kernels."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contiga.arrays.layout import locked
from contiga.pointer_records import pass_by_pointer
from contiga.records import FloatArray, IntArray


@pass_by_pointer
class Curves(NamedTuple):
    """n piecewise linear curves, with their knots one curve after the other."""

    first: IntArray
    """(n + 1,) first knot of each curve, and the number k of all knots."""
    x: FloatArray
    """(k,) abscissae, strictly increasing within a curve."""
    y: FloatArray
    """(k,) ordinates."""
    integral: FloatArray
    """(k,) ∫ y dx from zero to each knot; from the first knot above zero if zero is not a knot."""
    slope: FloatArray
    """(k + n,) slopes before, between and beyond the knots of each curve."""


class CurvePoint(NamedTuple):
    """A curve at one abscissa."""

    value: float
    slope: float
    """Slope to the right."""
    integral: float
    """Integral from zero, see `Curves.integral`."""


class Response(NamedTuple):
    """An elastic or hysteretic force after a step."""

    force: float
    """Force F at the end."""
    stiffness: float
    """dF/dx at the end: the slope of the curve that the force is on, or of hysteresis."""
    stored: float
    """Energy that an unloading returns."""
    lost: float
    """Work of the step that is not stored."""


def piecewise(x: FloatArray, y: FloatArray, before: float, beyond: float) -> Curves:
    """Return one curve through the knots, linear between and beyond them; arrays are read-only.

    Its integral counts from zero only if zero is a knot, see `Curves.integral`.

    Parameters
    ----------
    x, y : (k,) knots, x strictly increasing
    before, beyond : slopes before the first and beyond the last knot
    """
    areas = 0.5 * (y[1:] + y[:-1]) * np.diff(x)
    k = min(int(np.searchsorted(x, 0.0)), len(areas))
    integral = np.concatenate([-np.cumsum(areas[:k][::-1])[::-1], [0.0], np.cumsum(areas[k:])])
    slope = np.concatenate([[before], np.diff(y) / np.diff(x), [beyond]])
    return _locked(np.array([0, len(x)]), x, y, integral, slope)


def joined(*curves: Curves) -> Curves:
    """Return the curves of several records in one, in their order; none makes an empty record."""
    counts = np.concatenate([[0], *(np.diff(record.first) for record in curves)])
    columns = [np.zeros(0)] * 4
    if curves:
        columns = [
            np.concatenate([np.zeros(0), *parts])
            for parts in zip(*(record[1:] for record in curves), strict=True)
        ]
    return _locked(np.cumsum(counts), *columns)


def _locked(first: IntArray, *columns: FloatArray) -> Curves:
    """Return a record of read-only arrays, so that kernels see one type."""
    floats = (locked(np.ascontiguousarray(column, np.float64)) for column in columns)
    return Curves(locked(np.ascontiguousarray(first, np.int32)), *floats)


NO_CURVES = joined()
