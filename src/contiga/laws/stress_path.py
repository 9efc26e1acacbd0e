"""Exact split of a penetration between two piecewise-linear characteristics in series.

As the common stress σ rises from zero, the pair of strains (x_s, x_m) with
σ_s(x_s) = σ_m(x_m) = σ follows a polyline that starts at (0, 0) and is monotone. The penetration
t_s x_s + t_m x_m grows along it, so that each point in contact only needs a search for its place on
the polyline, whatever its thickness: no iteration, and plateaus are segments like any other.
"""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.curves.characteristic import Characteristic
from contiga.errors import InputError, RunError
from contiga.records import FloatArray

_ROUNDING = 1e-12
"""Penetration beyond a path, relative to the whole, that counts as rounding."""


class _Side(NamedTuple):
    """A characteristic on x ≥ 0, not negative."""

    x: FloatArray
    y: FloatArray
    slope: float
    """Slope beyond the last point; zero on an endless plateau, NaN if the table ends there."""


class StressPath(NamedTuple):
    """Nodes of the polyline of equal stress, and its direction beyond the last one."""

    slave: FloatArray
    """(k,) strains x_s."""
    master: FloatArray
    """(k,) strains x_m."""
    stress: FloatArray
    """(k,) σ."""
    ray: tuple[float, float, float] | None
    """Direction (x_s, x_m, σ) beyond the last node; None if a table ends the path."""

    def solve(
        self, depth: FloatArray, t_s: FloatArray, t_m: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return λ_s, λ_m and σ, each (n,), for penetrations and thicknesses `t_s`, `t_m` (n,).

        A penetration beyond a path without a ray raises a `RunError`, unless by rounding.
        """

        def reach(node: NDArray[np.intp]) -> FloatArray:
            return t_s * self.slave[node] + t_m * self.master[node]

        low = np.zeros(depth.shape, dtype=np.intp)
        high = np.full(depth.shape, len(self.stress), dtype=np.intp)
        for _ in range(len(self.stress).bit_length()):
            middle = (low + high) // 2
            deeper = depth >= reach(np.minimum(middle, len(self.stress) - 1))
            is_open = middle > low
            low = np.where(is_open & deeper, middle, low)
            high = np.where(is_open & ~deeper, middle, high)
        nodes = np.column_stack([self.slave, self.master, self.stress])
        ray = (0.0, 0.0, 0.0) if self.ray is None else self.ray
        segments = np.vstack([np.diff(nodes, axis=0), ray])[low]
        excess: FloatArray = depth - reach(low)
        length = t_s * segments[:, 0] + t_m * segments[:, 1]
        is_beyond = (low == len(self.stress) - 1) & (excess > _ROUNDING * depth)
        if self.ray is None and is_beyond.any():
            raise RunError(
                f"combined contact: a penetration of {depth[is_beyond][0]:.6g} goes beyond the "
                "tables of both sides. Extend them, or let them extrapolate with extrapolation = "
                '"linear" or "constant"'
            )
        share = np.divide(excess, length, out=np.zeros(depth.shape), where=length > 0.0)
        x_s = self.slave[low] + share * segments[:, 0]
        x_m = self.master[low] + share * segments[:, 1]
        return t_s * x_s, t_m * x_m, self.stress[low] + share * segments[:, 2]


def stress_path(slave: Characteristic, master: Characteristic) -> StressPath:
    """Return the polyline of equal stress of two tables, up to the highest stress of the weaker.

    Raises
    ------
    InputError
        A characteristic decreases somewhere at x ≥ 0, or its table does not include x = 0 with
        ``extrapolation="error"``.
    """
    sides = (_side(slave, "law"), _side(master, "master_law"))
    # A side whose stress does not rise beyond its last point limits the stress of the other.
    ceiling = min((side.y[-1] for side in sides if not side.slope > 0.0), default=np.inf)
    levels = np.union1d(sides[0].y, sides[1].y)
    levels = levels[levels <= ceiling]
    nodes = np.empty((2 * len(levels), 3))
    for column, side in enumerate(sides):
        nodes[0::2, column] = _inverse(side, levels, "left")
        nodes[1::2, column] = _inverse(side, levels, "right")
    nodes[:, 2] = np.repeat(levels, 2)
    is_new = np.append(True, (np.diff(nodes[:, :2], axis=0) > 0.0).any(axis=1))
    nodes = nodes[is_new]
    has_plateau = [side.slope == 0.0 and side.y[-1] == ceiling for side in sides]
    ray: tuple[float, float, float] | None = None
    if np.isinf(ceiling):
        ray = 1.0 / sides[0].slope, 1.0 / sides[1].slope, 1.0
    elif any(has_plateau):
        ray = float(has_plateau[0]), float(has_plateau[1]), 0.0
    return StressPath(nodes[:, 0], nodes[:, 1], nodes[:, 2], ray)


def _side(curve: Characteristic, where: str) -> _Side:
    """Return a curve on x ≥ 0, with its negative part set to zero, and a knot where that ends.

    An `InputError` is raised for a table that falls there, or starts above 0 without extrapolation.
    """
    if curve.extrapolation == "error" and curve.x[0] > 0.0:
        raise InputError(
            "combined contact needs a table that starts at zero or below",
            where=f"{where}.{curve.name}",
            found=float(curve.x[0]),
            remedy='Add its first point, or set extrapolation = "linear" or "constant"',
        )
    is_positive = curve.x > 0.0
    x = np.append(0.0, curve.x[is_positive])
    y = np.append(curve(0.0), curve.y[is_positive])
    slope = {"linear": curve.end_slopes[1], "constant": 0.0, "error": np.nan}[curve.extrapolation]
    if (np.diff(y) < 0.0).any() or slope < 0.0:
        raise InputError(
            "combined contact needs a characteristic that does not decrease",
            where=f"{where}.{curve.name}",
            found=curve.y.tolist(),
        )
    n_negative = int((y < 0.0).sum())
    if n_negative == 0:
        return _Side(x, y, slope)
    last = n_negative - 1
    rise = slope
    if n_negative < len(x):
        rise = (y[n_negative] - y[last]) / (x[n_negative] - x[last])
    zeros, positive = x[:n_negative], x[n_negative:]
    if rise > 0.0:
        zeros = np.append(zeros, x[last] - y[last] / rise)
    y = np.concatenate([np.zeros(len(zeros)), y[n_negative:]])
    return _Side(np.concatenate([zeros, positive]), y, slope)


def _inverse(side: _Side, stress: FloatArray, end: Literal["left", "right"]) -> FloatArray:
    """Return the first (`end` "left") or last ("right") strain at which a side carries `stress`.

    `stress` (k,) is within its range: below it the strain is 0, above it the last, or beyond that
    on a rising slope.
    """
    place = np.searchsorted(side.y, stress, side=end)
    upper = np.clip(place, 1, max(len(side.x) - 1, 1))
    lower = upper - 1
    if len(side.x) > 1:
        rise = side.y[upper] - side.y[lower]
        share = np.divide(stress - side.y[lower], rise, out=np.zeros(len(stress)), where=rise > 0.0)
        strain = side.x[lower] + share * (side.x[upper] - side.x[lower])
    else:
        strain = np.zeros(len(stress))
    beyond = np.full(len(stress), side.x[-1])
    if side.slope > 0.0:
        beyond = beyond + (stress - side.y[-1]) / side.slope
    strain = np.where(place == len(side.x), beyond, strain)
    return np.where(place == 0, 0.0, strain)
