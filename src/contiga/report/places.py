"""Places of rigid parts over time, and of springs tied to points of them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from contiga.records import FloatArray

if TYPE_CHECKING:
    from contiga.report.fields import RecordedFields

_RIGID = 2e-7
"""Largest departure from a rigid motion, over size and distance of a part: single precision."""
AS_NEAR = 1e-6
"""Relative difference up to which distances count as equal, for single precision."""


class Tie(NamedTuple):
    """A spring between points of bodies, slaves or the ground, or a line of a joint on a body."""

    name: str
    between: tuple[str, str]
    at: FloatArray
    """(2, 3) the points at the start."""
    kind: str = "spring"
    """"spring" or "joint"."""


Ties = Sequence[Tie]


def ties_of(summary: dict[str, Any]) -> list[Tie]:
    """Return the springs and joints of a run, from its summary."""
    springs, joints = summary.get("springs") or {}, summary.get("joints") or {}
    ties = [
        Tie(name, tuple(one["between"]), np.asarray(one["at"], np.float64))
        for name, one in springs.items()
    ]
    for name, one in joints.items():
        for line in np.asarray(one.get("lines", ()), np.float64):
            ties.append(Tie(name, (one["between"][1],) * 2, line, "joint"))
    return ties


def ties_at(series: RecordedFields, frame: int, ties: Ties) -> FloatArray:
    """Return the ends (k, 2, 3) of ties at a recorded step."""
    if not ties:
        return np.zeros((0, 2, 3))
    return tie_ends(series, series.points(0), series.points(frame), ties)


def tie_ends(
    series: RecordedFields, start: FloatArray, points: FloatArray, ties: Ties
) -> FloatArray:
    """Return the ends (k, 2, 3) of ties after all points moved from `start` to `points` (n, 3)."""
    bodies = {part.name: series.rows(part.name) for part in series.parts if part.kind == "body"}
    moved = {
        name: place_of(start[bodies[name]], points[bodies[name]])
        for name in dict.fromkeys(name for tie in ties for name in tie.between)
        if name in bodies
    }
    nodes = {part.name: series.rows(part.name) for part in series.parts if part.kind == "slave"}
    ends = []
    for tie in ties:
        for name, at in zip(tie.between, tie.at, strict=True):
            if name in nodes:
                ends.append(_with_nodes(start[nodes[name]], points[nodes[name]], at))
            else:
                ends.append(_carried_point(moved.get(name), at))
    return np.array(ends, np.float64).reshape(-1, 2, 3)


def _with_nodes(start: FloatArray, points: FloatArray, at: FloatArray) -> FloatArray:
    """Return a point moved by the mean displacement of the nodes (n, 3) nearest to it at the start.

    Several nodes are equally near in the middle of a belt, between two of them.
    """
    off = np.linalg.norm(start - at, axis=1)
    near = off <= (1.0 + AS_NEAR) * off.min() + AS_NEAR * np.ptp(start)
    return np.asarray(at + (points - start)[near].mean(axis=0))


def _carried_point(place: FloatArray | None, at: FloatArray) -> FloatArray:
    """Return a point moved with its body; it stays if there is no body, or no rigid one."""
    if place is None or place.ndim == 2:
        return at
    return np.asarray(place[:9].reshape(3, 3) @ at + place[9:])


def place_of(base: FloatArray, points: FloatArray) -> FloatArray:
    """Return the rigid motion (12,) from `base` (n, 3) to `points` if it is one, else the points.

    The closest rotation by Kabsch (1976).
    """
    a, b = base.mean(axis=0), points.mean(axis=0)
    if np.isfinite(base).all() and np.isfinite(points).all():
        left, _, right = np.linalg.svd((base - a).T @ (points - b))
        turn = np.diag([1.0, 1.0, np.sign(np.linalg.det(left @ right))])
        R = (left @ turn @ right).T
        t = b - R @ a
        off = np.abs(base @ R.T + t - points).max(initial=0.0)
        if off <= _RIGID * (np.abs(points).max(initial=0.0) + np.ptp(points)):
            return np.concatenate([R.ravel(), t])
    return np.asarray(points, np.float32)
