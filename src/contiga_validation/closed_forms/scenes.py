"""Bodies, runs and measurements that several cases share."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

import numpy as np
from scipy.optimize import brentq

import contiga as cg
from contiga_validation.engine.arrays import FloatArray

History = Mapping[str, FloatArray]
ROTATIONS = ("rx", "ry", "rz")
"""Degrees of freedom to lock for a body that only translates."""


@cache
def ball(radius: float = 1.0, centre: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> cg.Body:
    """Return a ball of one patch; equal arguments give the same body, with its search tables."""
    return cg.Body([cg.shapes.sphere(radius=radius, centre=centre)])


def solid_ball(mass: float, radius: float, **motion: Any) -> cg.motion.Free:
    """Return the motion of a free homogeneous ball."""
    inertia = 0.4 * mass * radius**2 * np.eye(3)
    return cg.motion.Free(mass, inertia=inertia, **motion)


@cache
def floor(size: float = 40.0, height: float = 0.0) -> cg.Body:
    """Return a large plane face whose free side is above."""
    return cg.Body([cg.shapes.plane(width=size, length=size, centre=(0.0, 0.0, height))])


def run_of(
    *,
    bodies: Mapping[str, Any] | None = None,
    slaves: Mapping[str, Any] | None = None,
    contacts: Sequence[cg.Contact] = (),
    keep: int | None = None,
    **options: Any,
) -> cg.Result:
    """Run a simulation of the given parts; `options` are those of `cg.Simulation`.

    `keep` is that of `Simulation.run`.
    """
    simulation = cg.Simulation(
        bodies=bodies or {}, slaves=slaves or {}, contacts=contacts, **options
    )
    return simulation.run(keep=keep)


def free_body(motion: cg.motion.Free, **options: Any) -> cg.Simulation:
    """Return a simulation of one free body, "body", centred at the origin, without contacts."""
    return cg.Simulation(bodies={"body": (ball(), motion)}, slaves={}, contacts=[], **options)


def positions(history: History, body: str = "body") -> FloatArray:
    """Return positions (n, 3) of the centre of mass, world frame."""
    return np.column_stack([history[f"{body}.{axis}"] for axis in "xyz"])


def velocities(history: History, body: str = "body") -> FloatArray:
    """Return velocities (n, 3) of the centre of mass, world frame."""
    return np.column_stack([history[f"{body}.v{axis}"] for axis in "xyz"])


def spins(history: History, body: str = "body") -> FloatArray:
    """Return (n, 3) angular velocities, world axes."""
    return np.column_stack([history[f"{body}.w{axis}"] for axis in "xyz"])


def rotations(history: History, body: str = "body") -> FloatArray:
    """Return (n, 3, 3) rotation matrices from a body's axes to the world's."""
    w, x, y, z = (history[f"{body}.q{part}"] for part in "wxyz")
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), 2, 0)


def crossing_time(
    times: FloatArray, values: FloatArray, rates: FloatArray, *, after: int = 0
) -> float:
    """Return the time of the first sign change of `values` from row `after` on, by Hermite's cubic.

    A change to zero counts; without a change the time is NaN. `rates` are derivatives in time. The
    cubic's error is of fourth order in the step, so that interpolation between two steps adds
    nothing to the error of a run.
    """
    sign = np.sign(values[after:])
    changed = np.flatnonzero((sign[:-1] * sign[1:] < 0.0) | (sign[1:] == 0.0))
    if len(changed) == 0:
        return float("nan")
    i = after + int(changed[0])
    h = float(times[i + 1] - times[i])

    def at(s: float) -> float:
        return _hermite(values[i : i + 2], rates[i : i + 2], h, s)

    return float(times[i]) + h * float(brentq(at, 0.0, 1.0, xtol=1e-14))


def value_at(times: FloatArray, values: FloatArray, rates: FloatArray, t: float) -> float:
    """Return the value at the time `t` by Hermite's cubic; `rates` are derivatives in time.

    Beyond the ends the first or last cubic is extrapolated.
    """
    i = min(max(int(np.searchsorted(times, t)) - 1, 0), len(times) - 2)
    h = times[i + 1] - times[i]
    return _hermite(values[i : i + 2], rates[i : i + 2], h, (t - times[i]) / h)


def _hermite(values: FloatArray, rates: FloatArray, h: float, s: float) -> float:
    """Return Hermite's cubic at a share `s` of the step `h` between two rows."""
    return float(
        (1 + 2 * s) * (1 - s) ** 2 * values[0]
        + s * (1 - s) ** 2 * h * rates[0]
        + s * s * (3 - 2 * s) * values[1]
        - s * s * (1 - s) * h * rates[1]
    )
