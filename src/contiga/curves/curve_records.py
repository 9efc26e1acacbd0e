"""Piecewise linear curves as kernels take them, and the answers of kernels."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contiga.arrays.layout import locked
from contiga.pointer_records import pass_by_pointer
from contiga.records import FloatArray, IntArray


@pass_by_pointer
class Curves(NamedTuple):
    """n piecewise linear curves; the knots of each curve follow those of the curve before it."""

    first: IntArray
    """(n + 1,) first knot of each curve, and the number k of all knots."""
    x: FloatArray
    """(k,) abscissae, strictly increasing within a curve."""
    y: FloatArray
    """(k,) ordinates."""
    integral: FloatArray
    """(k,) ∫ y dx from zero to each knot; from the first knot above zero if zero is no knot."""
    slope: FloatArray
    """(k + n,) slopes before, between and behind the knots of each curve."""


class CurvePoint(NamedTuple):
    """A curve at one abscissa."""

    value: float
    slope: float
    """Slope to the right."""
    integral: float
    """Integral from zero, as `Curves.integral` has it."""


class Response(NamedTuple):
    """An elastic or hysteretic force after a step."""

    force: float
    """Force F at the end."""
    stiffness: float
    """dF/dx at the end: the slope of the curve that the force is on, or of hysteresis."""
    stored: float
    """Energy that an unloading gives back."""
    lost: float
    """Work of the step that is not stored."""


def piecewise(x: FloatArray, y: FloatArray, before: float, behind: float) -> Curves:
    """Return one curve.

    Parameters
    ----------
    x, y : (k,) knots, x strictly increasing
    before, behind : slopes before the first and behind the last knot
    """
    parts = 0.5 * (y[1:] + y[:-1]) * np.diff(x)
    k = min(int(np.searchsorted(x, 0.0)), len(parts))
    integral = np.concatenate([-np.cumsum(parts[:k][::-1])[::-1], [0.0], np.cumsum(parts[k:])])
    slope = np.concatenate([[before], np.diff(y) / np.diff(x), [behind]])
    return _locked(np.array([0, len(x)]), x, y, integral, slope)


def joined(*curves: Curves) -> Curves:
    """Return the curves of several records in one."""
    counts = np.concatenate([[0], *(np.diff(one.first) for one in curves)])
    columns = zip(*(one[1:] for one in curves), strict=True)
    none = np.zeros(0)
    rest = [np.concatenate([none, *column]) for column in columns] if curves else [none] * 4
    return _locked(np.cumsum(counts), *rest)


def _locked(first: IntArray, *columns: FloatArray) -> Curves:
    """Return a record of read-only arrays, so that kernels see one type."""
    floats = (locked(np.ascontiguousarray(column, np.float64)) for column in columns)
    return Curves(locked(np.ascontiguousarray(first, np.int32)), *floats)


NO_CURVES = joined()
