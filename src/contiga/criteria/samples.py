"""Sampled signals: their checks, and the line through their samples."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from contiga.arrays.layout import real
from contiga.errors import InputError
from contiga.records import FloatArray


class Line(NamedTuple):
    """A piecewise linear signal through n + 1 samples."""

    t: FloatArray
    """(n + 1,) times, rising."""
    a: FloatArray
    """(n + 1,) values."""
    area: FloatArray
    """(n + 1,) integral from the first sample."""
    slope: FloatArray
    """(n,) between samples."""

    def area_at(self, times: FloatArray) -> FloatArray:
        """Return the integral up to `times`; outside the signal its end pieces go on."""
        k = np.clip(np.searchsorted(self.t, times, side="right") - 1, 0, len(self.slope) - 1)
        dt = times - self.t[k]
        area: FloatArray = self.area[k] + dt * (self.a[k] + 0.5 * self.slope[k] * dt)
        return area

    def reversed(self) -> Line:
        """Return the same line backwards in time, with the last sample of this one at time 0."""
        return line_through(self.a[::-1], self.t[-1] - self.t[::-1])


def line_through(a: FloatArray, t: FloatArray) -> Line:
    """Return the line through samples (n,), two or more, with its exact integrals and slopes."""
    steps = np.diff(t)
    pieces = 0.5 * (a[1:] + a[:-1]) * steps
    return Line(t, a, np.concatenate([[0.0], np.cumsum(pieces)]), np.diff(a) / steps)


def checked_signal(
    a: ArrayLike,
    t_s: ArrayLike,
    where: str,
    names: tuple[str, str] = ("a", "t_s"),
    *,
    what: str = "a signal",
    remedy: str | None = None,
) -> tuple[FloatArray, FloatArray]:
    """Return copies of values and times (n,) of a signal of at least two samples, checked.

    Parameters
    ----------
    a, t_s : (n,) values and times, s
    where : place of the arguments, for messages
    names : names of the two arguments, for messages
    what, remedy : name of the signal in messages, and the remedy for another shape

    Raises
    ------
    InputError
        Not numbers, lengths that differ, fewer than two samples, a value that is not finite, times
        that do not rise.
    """
    values, t = numbers(a, f"{where}, {names[0]}"), numbers(t_s, f"{where}, {names[1]}")
    if values.ndim != 1 or t.ndim != 1 or len(values) != len(t):
        raise InputError(
            f"{what} and its times must have the same length",
            where=where,
            found=(values.shape, t.shape),
            allowed="shapes (n,) and (n,)",
            remedy=remedy,
        )
    if len(values) < 2:
        raise InputError("two samples at least are needed", where=where, found=len(values))
    finite_rows(values, f"{where}, {names[0]}")
    finite_rows(t, f"{where}, {names[1]}")
    is_falling = np.diff(t) <= 0.0
    if is_falling.any():
        k = int(np.argmax(is_falling))
        raise InputError(
            f"times must rise, from sample {k} to {k + 1} too",
            where=f"{where}, {names[1]}",
            found=(float(t[k]), float(t[k + 1])),
        )
    return values, t


def checked_resultant(a_g: ArrayLike, t_s: ArrayLike, where: str) -> tuple[FloatArray, FloatArray]:
    """Return copies of values and times (n,) of a resultant, checked.

    Raises
    ------
    InputError
        The errors of `checked_signal`, or a value below zero.
    """
    a, t = checked_signal(
        a_g,
        t_s,
        where,
        ("a_g", "t_s"),
        what="a resultant",
        remedy="The resultant of components (n, 3) is np.linalg.norm(components, axis=1)",
    )
    if a.min() < 0.0:
        k = int(np.argmax(a < 0.0))
        raise InputError(
            f"a resultant is never negative, at sample {k} it is",
            where=f"{where}, a_g",
            found=float(a[k]),
            allowed=">= 0",
            remedy="Filter the components first and take the resultant of them",
        )
    return a, t


def numbers(values: ArrayLike, where: str) -> FloatArray:
    """Return a float64 copy of `values` of any shape; NaN and infinity are allowed.

    Raises
    ------
    InputError
        They are not numbers.
    """
    real(values, where)
    try:
        return np.array(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError("must be an array of numbers", where=where) from error


def finite_rows(values: FloatArray, where: str) -> None:
    """Refuse NaN and infinite entries; the error names the first row with one.

    Raises
    ------
    InputError
        An entry is not finite.
    """
    is_bad = ~np.isfinite(values.reshape(len(values), -1)).all(axis=1)
    if is_bad.any():
        k = int(np.argmax(is_bad))
        raise InputError(f"sample {k} is not finite", where=where, found=values[k].tolist())
