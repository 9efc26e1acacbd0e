"""Bodies, runs and readings that several cases share."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

import numpy as np
from scipy.optimize import brentq

import contiga as cg
from contiga_validation.engine.arrays import FloatArray

History = Mapping[str, FloatArray]
STILL = ("rx", "ry", "rz")
"""What holds a body that only translates."""


@cache
def ball(radius: float = 1.0, centre: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> cg.Body:
    """A ball of one patch; the same one for the same numbers, since what a search builds of a body
    stays with it.
    """
    return cg.Body([cg.shapes.sphere(radius=radius, centre=centre)])


def solid_ball(mass: float, radius: float, **motion: Any) -> cg.motion.Free:
    """A free homogeneous ball."""
    inertia = 0.4 * mass * radius**2 * np.eye(3)
    return cg.motion.Free(mass, inertia=inertia, **motion)


@cache
def floor(size: float = 40.0, height: float = 0.0) -> cg.Body:
    """A large plane face, free above."""
    return cg.Body([cg.shapes.plane(width=size, length=size, centre=(0.0, 0.0, height))])


def run_of(
    *,
    bodies: Mapping[str, Any] | None = None,
    slaves: Mapping[str, Any] | None = None,
    contacts: Sequence[cg.Contact] = (),
    keep: int | None = None,
    **options: Any,
) -> cg.Result:
    """A run of what there is."""
    simulation = cg.Simulation(
        bodies=bodies or {}, slaves=slaves or {}, contacts=contacts, **options
    )
    return simulation.run(keep=keep)


def alone(motion: cg.motion.Free, **options: Any) -> cg.Simulation:
    """One free body, named "body", without contacts; the origin is its centre."""
    return cg.Simulation(bodies={"body": (ball(), motion)}, slaves={}, contacts=[], **options)


def positions(history: History, body: str = "body") -> FloatArray:
    """(n, 3) of the centre of mass."""
    return np.column_stack([history[f"{body}.{axis}"] for axis in "xyz"])


def velocities(history: History, body: str = "body") -> FloatArray:
    """(n, 3) of the centre of mass."""
    return np.column_stack([history[f"{body}.v{axis}"] for axis in "xyz"])


def spins(history: History, body: str = "body") -> FloatArray:
    """(n, 3) world axes."""
    return np.column_stack([history[f"{body}.w{axis}"] for axis in "xyz"])


def turns(history: History, body: str = "body") -> FloatArray:
    """(n, 3, 3) matrices that turn a body's axes to the world's."""
    w, x, y, z = (history[f"{body}.q{part}"] for part in "wxyz")
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), 2, 0)


def when(times: FloatArray, values: FloatArray, rates: FloatArray, *, after: int = 0) -> float:
    """The time at which `values` next change sign after a row: on Hermite's cubic there.

    Cubics keep what a run knows to the fourth power of the step, so that reading a time between
    two steps adds nothing to its error.
    """
    sign = np.sign(values[after:])
    changed = np.flatnonzero((sign[:-1] * sign[1:] < 0.0) | (sign[1:] == 0.0))
    if len(changed) == 0:
        return float("nan")
    i = after + int(changed[0])
    h = float(times[i + 1] - times[i])

    def at(s: float) -> float:
        return _cubic(values[i : i + 2], rates[i : i + 2], h, s)

    return float(times[i]) + h * float(brentq(at, 0.0, 1.0, xtol=1e-14))


def value_at(times: FloatArray, values: FloatArray, rates: FloatArray, t: float) -> float:
    """What Hermite's cubic has at the time `t`."""
    i = min(max(int(np.searchsorted(times, t)) - 1, 0), len(times) - 2)
    h = times[i + 1] - times[i]
    return _cubic(values[i : i + 2], rates[i : i + 2], h, (t - times[i]) / h)


def _cubic(values: FloatArray, rates: FloatArray, h: float, s: float) -> float:
    """Hermite's, at a share of the way between two rows that are `h` apart."""
    return float(
        (1 + 2 * s) * (1 - s) ** 2 * values[0]
        + s * (1 - s) ** 2 * h * rates[0]
        + s * s * (3 - 2 * s) * values[1]
        - s * s * (1 - s) * h * rates[1]
    )
