"""A strip of splines through rows of points: the patch of a belt."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contiga.geometry.knots import basis, greville, open_knots
from contiga.geometry.surface import NurbsSurface
from contiga.records import FloatArray

DEGREE = 2
"""Degree along a strip and across."""
N_CHORDS = 20
"""Number of chords per element that measure its length."""


class Strip(NamedTuple):
    """A patch of degree 2 with uniform elements along and across.

    >>> strip = Strip(4, 1)
    >>> len(strip.greville_u), strip.greville_v.tolist()
    (6, [0.0, 0.5, 1.0])
    """

    segments: int
    """Number of elements along it."""
    across: int
    """Number of elements across it."""

    @property
    def knots(self) -> tuple[FloatArray, FloatArray]:
        """Knots along it and across, from 0 to 1."""
        return (
            open_knots(DEGREE, self.segments + DEGREE),
            open_knots(DEGREE, self.across + DEGREE),
        )

    @property
    def greville_u(self) -> FloatArray:
        """Greville parameters (n,) of rows of control points."""
        return greville(self.knots[0], DEGREE)

    @property
    def greville_v(self) -> FloatArray:
        """Greville parameters (k,) across."""
        return greville(self.knots[1], DEGREE)

    def interpolated(self, values: FloatArray) -> FloatArray:
        """Return spline coefficients (n, …) along the strip that interpolate `values` (n, …).

        The values are at `greville_u`.
        """
        matrix = basis(self.knots[0], DEGREE, self.greville_u)[:, 0]
        flat = np.linalg.solve(matrix, values.reshape(len(values), -1))
        return np.asarray(flat.reshape(values.shape))

    def through(self, rows: FloatArray) -> NurbsSurface:
        """Return the patch whose curve across at greville_u[i] has control points rows[i] (k, 3).

        It is a straight line if these are on a line, at distances as `greville_v`.
        """
        return NurbsSurface((DEGREE, DEGREE), self.knots, self.interpolated(rows))

    def flat(self, rows: FloatArray, width: float, share: float) -> FloatArray:
        """Return control points (n k, 3) of a flat patch from x = 0 on, with y from −width/2.

        Its length at each Greville parameter is `share` times the mean length of the lines of
        control points along the patch through `rows`, by `N_CHORDS` chords an element.
        """
        patch = self.through(rows)
        u = np.linspace(0.0, 1.0, N_CHORDS * self.segments + 1)
        values = basis(self.knots[0], DEGREE, u)[:, 0]
        lines = np.einsum("un,nvx->uvx", values, patch.control_points)
        steps = np.linalg.norm(np.diff(lines, axis=0), axis=2).mean(axis=1)
        x = np.interp(self.greville_u, u, np.concatenate([[0.0], np.cumsum(steps)]))
        control = np.zeros(patch.control_points.shape)
        control[:, :, 0] = share * self.interpolated(x)[:, None]
        control[:, :, 1] = width * (self.greville_v - 0.5)
        return control.reshape(-1, 3)
