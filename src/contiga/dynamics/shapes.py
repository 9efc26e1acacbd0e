"""Bodies whose control points follow a table over time, or a slave that deforms."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from contiga.arrays.layout import read_only, real
from contiga.curves.tables import as_times
from contiga.dynamics.free import Dependent
from contiga.errors import InputError
from contiga.records import FloatArray
from contiga.rigid import pose, twist
from contiga.rigid.twist import Twist


@dataclass(frozen=True, init=False, eq=False)
class ControlPoints:
    """A body whose control points follow a table over time, by cubic splines between its rows.

    The splines begin and end at rest, so that positions and velocities are continuous also at the
    first and the last time, outside which the shape is constant. Contacts push points by the
    nearest wall of the body (`foot`, `through`).

    Parameters
    ----------
    times : (k,) strictly increasing
    points : (k, m, 3) control points in the order of `body.net.points`, axes of the body

    Raises
    ------
    InputError
        Times that do not increase, points of another shape or not finite.

    >>> import contiga as cg
    >>> rest = cg.Body([cg.shapes.sphere(radius=1.0)]).net.points
    >>> breath = ControlPoints([0.0, 1.0], [rest, 1.5 * rest])
    >>> round(float(breath.control_points(0.5)[0, 2] / rest[0, 2]), 12)
    1.25
    """

    known_ahead = True
    times: FloatArray
    points: FloatArray

    def __init__(self, times: ArrayLike, points: ArrayLike) -> None:
        try:
            rows = np.asarray(real(points, "points"), dtype=np.float64)
        except ValueError as error:
            raise InputError(
                "must be as many control points at each time", where="points", allowed="(k, m, 3)"
            ) from error
        if rows.ndim != 3 or rows.shape[2] != 3:
            raise InputError(
                "must be control points at each time",
                where="points",
                found=rows.shape,
                allowed="(k, m, 3), m as body.net.points has rows",
            )
        finite = np.isfinite(rows).all(axis=(1, 2))
        if not finite.all():
            raise InputError("must be finite", where=f"points[{int(np.argmin(finite))}]")
        object.__setattr__(self, "times", read_only(as_times(times, len(rows))))
        object.__setattr__(self, "points", read_only(rows))

    @property
    def rows(self) -> FloatArray:
        """Times of its rows."""
        return self.times

    def pose(self, t: float) -> FloatArray:
        """Return the identity."""
        return pose.identity()

    def twist(self, t: float) -> Twist:
        """Return a twist of zero."""
        return twist.still()

    @cached_property
    def _spline(self) -> Any:
        from scipy.interpolate import CubicSpline  # slow to import

        return CubicSpline(self.times, self.points, bc_type="clamped")

    def control_points(self, t: float) -> FloatArray:
        """Return the control points (m, 3) at time `t`, as a new array; constant outside."""
        if t <= self.times[0] or len(self.times) == 1:
            return np.array(self.points[0])
        if t >= self.times[-1]:
            return np.array(self.points[-1])
        return np.ascontiguousarray(self._spline(t))

    def control_velocity(self, t: float) -> FloatArray:
        """Return the velocities (m, 3) at time `t`; zero while the shape is constant."""
        if not self.times[0] < t < self.times[-1]:
            return np.zeros(self.points.shape[1:])
        return np.ascontiguousarray(self._spline(t, 1))


@dataclass(frozen=True)
class ControlPointsOf(Dependent):
    """A body whose control points are those of a slave that deforms as a shell of splines.

    It makes the shell a master of other slaves. The body has the patches of the shell; forces on
    its control points act on the shell.
    """

    slave: str
    """Name of the slave."""
