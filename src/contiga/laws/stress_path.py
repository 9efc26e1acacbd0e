"""Exact split of a penetration between two piecewise-linear characteristics in series.

As the common stress σ rises from zero, the pair of strains (x_s, x_m) with
σ_s(x_s) = σ_m(x_m) = σ runs along a polyline that starts at (0, 0) and never goes back. The
penetration t_s x_s + t_m x_m grows along it, so that each point in contact only has to find its
place on the polyline, whatever its thickness: no iteration, and plateaus are plain segments.
"""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.curves.characteristic import Characteristic
from contiga.errors import InputError, RunError
from contiga.records import FloatArray

_ROUNDING = 1e-12


class _Side(NamedTuple):
    """A characteristic on x ≥ 0, not negative."""

    x: FloatArray
    y: FloatArray
    slope: float
    """Beyond the last point; zero on a plateau without end, NaN where the table ends."""


class StressPath(NamedTuple):
    """Nodes of the polyline of equal stress, and its direction behind the last one."""

    slave: FloatArray
    """(k,) strains x_s."""
    master: FloatArray
    """(k,) strains x_m."""
    stress: FloatArray
    """(k,) σ."""
    ray: tuple[float, float, float] | None
    """Direction (x_s, x_m, σ) behind the last node; None where a table ends the path."""

    def solve(
        self, depth: FloatArray, t_s: FloatArray, t_m: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return λ_s, λ_m and σ, each (n,), for penetrations and thicknesses `t_s`, `t_m` (n,)."""

        def reach(node: NDArray[np.intp]) -> FloatArray:
            return t_s * self.slave[node] + t_m * self.master[node]

        low = np.zeros(depth.shape, dtype=np.intp)
        high = np.full(depth.shape, len(self.stress), dtype=np.intp)
        for _ in range(len(self.stress).bit_length()):
            middle = (low + high) // 2
            deeper = depth >= reach(np.minimum(middle, len(self.stress) - 1))
            inside = middle > low
            low = np.where(inside & deeper, middle, low)
            high = np.where(inside & ~deeper, middle, high)
        step = self._steps()
        left: FloatArray = depth - reach(low)
        way = t_s * step[low, 0] + t_m * step[low, 1]
        beyond = (low == len(self.stress) - 1) & (left > _ROUNDING * depth)
        if self.ray is None and beyond.any():
            raise RunError(
                f"combined contact: a penetration of {depth[beyond][0]:.6g} goes beyond the tables "
                'of both sides. Extend them, or let them extrapolate with extrapolation = "linear" '
                'or "constant"'
            )
        along = np.divide(left, way, out=np.zeros(depth.shape), where=way > 0.0)
        x_s = self.slave[low] + along * step[low, 0]
        x_m = self.master[low] + along * step[low, 1]
        return t_s * x_s, t_m * x_m, self.stress[low] + along * step[low, 2]

    def _steps(self) -> FloatArray:
        nodes = np.column_stack([self.slave, self.master, self.stress])
        ray = (0.0, 0.0, 0.0) if self.ray is None else self.ray
        return np.vstack([np.diff(nodes, axis=0), ray])


def stress_path(slave: Characteristic, master: Characteristic) -> StressPath:
    """Return the polyline of equal stress of two tables.

    Raises
    ------
    InputError
        A characteristic decreases somewhere at x ≥ 0, or its table leaves x = 0 out with
        ``extrapolation="error"``.
    """
    sides = (_side(slave, "law"), _side(master, "master_law"))
    # A side that cannot go beyond its last stress sets the ceiling of the other.
    ceiling = min((s.y[-1] for s in sides if not s.slope > 0.0), default=np.inf)
    levels = np.union1d(sides[0].y, sides[1].y)
    levels = levels[levels <= ceiling]
    nodes = np.empty((2 * len(levels), 3))
    for column, side in enumerate(sides):
        nodes[0::2, column] = _inverse(side, levels, "left")
        nodes[1::2, column] = _inverse(side, levels, "right")
    nodes[:, 2] = np.repeat(levels, 2)
    keep = np.append(True, (np.diff(nodes[:, :2], axis=0) > 0.0).any(axis=1))
    nodes = nodes[keep]
    return StressPath(nodes[:, 0], nodes[:, 1], nodes[:, 2], _ray(sides, ceiling))


def _side(curve: Characteristic, where: str) -> _Side:
    if curve.extrapolation == "error" and curve.x[0] > 0.0:
        raise InputError(
            "combined contact needs a table that starts at zero or below",
            where=f"{where}.{curve.name}",
            found=float(curve.x[0]),
            remedy='Add its first point, or set extrapolation = "linear" or "constant"',
        )
    inside = curve.x > 0.0
    x = np.append(0.0, curve.x[inside])
    y = np.append(curve(0.0), curve.y[inside])
    slope = {"linear": curve.end_slopes[1], "constant": 0.0, "error": np.nan}[curve.extrapolation]
    if (np.diff(y) < 0.0).any() or slope < 0.0:
        raise InputError(
            "combined contact needs a characteristic that does not decrease",
            where=f"{where}.{curve.name}",
            found=curve.y.tolist(),
        )
    return _not_below_zero(x, y, slope)


def _not_below_zero(x: FloatArray, y: FloatArray, slope: float) -> _Side:
    """Return the rising polyline with its negative part set to zero."""
    negative = int((y < 0.0).sum())
    if negative == 0:
        return _Side(x, y, slope)
    if negative < len(x):
        rise = (y[negative] - y[negative - 1]) / (x[negative] - x[negative - 1])
    else:
        rise = slope
    start, end = x[:negative], x[negative:]
    if rise > 0.0:
        crossing = x[negative - 1] - y[negative - 1] / rise
        start = np.append(start, crossing)
    return _Side(
        np.concatenate([start, end]), np.concatenate([np.zeros(len(start)), y[negative:]]), slope
    )


def _inverse(side: _Side, stress: FloatArray, end: Literal["left", "right"]) -> FloatArray:
    """Return the first (`end` "left") or last ("right") strain at which a side carries `stress`."""
    upper = np.searchsorted(side.y, stress, side=end)
    within = np.clip(upper, 1, max(len(side.x) - 1, 1))
    lower = within - 1
    if len(side.x) > 1:
        rise = side.y[within] - side.y[lower]
        part = np.divide(stress - side.y[lower], rise, out=np.zeros(len(stress)), where=rise > 0.0)
        strain = side.x[lower] + part * (side.x[within] - side.x[lower])
    else:
        strain = np.zeros(len(stress))
    above = np.full(len(stress), side.x[-1])
    if side.slope > 0.0:
        above = above + (stress - side.y[-1]) / side.slope
    strain = np.where(upper == len(side.x), above, strain)
    return np.where(upper == 0, 0.0, strain)


def _ray(sides: tuple[_Side, _Side], ceiling: float) -> tuple[float, float, float] | None:
    """Return the direction of the path behind its last node."""
    if np.isinf(ceiling):
        return 1.0 / sides[0].slope, 1.0 / sides[1].slope, 1.0
    endless = [s.slope == 0.0 and s.y[-1] == ceiling for s in sides]
    if not any(endless):
        return None
    return float(endless[0]), float(endless[1]), 0.0
