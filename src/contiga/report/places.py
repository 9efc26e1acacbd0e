"""Places of rigid parts over time, and of springs tied to points of them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from contiga.records import FloatArray

if TYPE_CHECKING:
    from contiga.report.fields import RecordedFields

_RIGID_TOL = 2e-7
"""Largest departure from a rigid motion, over size and distance of a part: single precision."""
_DISTANCE_TOL = 1e-6
"""Relative difference up to which distances count as equal, for single precision."""


class Tie(NamedTuple):
    """A spring between points of bodies, slaves or the ground, or a line of a joint on a body."""

    name: str
    between: tuple[str, str]
    """Names of the body, slave or ground that either end moves with."""
    at: FloatArray
    """(2, 3) the points at the start."""
    kind: str = "spring"
    """"spring" or "joint"."""


Ties = Sequence[Tie]


def ties_of(summary: dict[str, Any]) -> list[Tie]:
    """Return the springs and the lines of joints of a run, from its summary, in this order.

    A line of a joint moves with its second body.
    """
    springs, joints = summary.get("springs") or {}, summary.get("joints") or {}
    ties = [
        Tie(name, tuple(spring["between"]), np.asarray(spring["at"], np.float64))
        for name, spring in springs.items()
    ]
    for name, joint in joints.items():
        for line in np.asarray(joint.get("lines", ()), np.float64):
            ties.append(Tie(name, (joint["between"][1],) * 2, line, "joint"))
    return ties


def ties_at(series: RecordedFields, frame: int, ties: Ties) -> FloatArray:
    """Return the ends (k, 2, 3) of ties at a recorded step."""
    if not ties:
        return np.zeros((0, 2, 3))
    return tie_ends(series, series.points(0), series.points(frame), ties)


def tie_ends(
    series: RecordedFields, start: FloatArray, points: FloatArray, ties: Ties
) -> FloatArray:
    """Return the ends (k, 2, 3) of ties after all points moved from `start` to `points` (n, 3).

    An end on a rigid body moves with it. An end on a slave moves by the mean displacement of the
    nodes nearest to it at the start, within 1e-6: several are equally near in the middle of a belt.
    Ends on the ground stay, and those on a body that does not move rigidly (`place_of`).
    """
    body_rows = {part.name: series.rows(part.name) for part in series.parts if part.kind == "body"}
    poses = {
        name: place_of(start[body_rows[name]], points[body_rows[name]])
        for name in dict.fromkeys(name for tie in ties for name in tie.between)
        if name in body_rows
    }
    node_rows = {part.name: series.rows(part.name) for part in series.parts if part.kind == "slave"}
    ends = []
    for tie in ties:
        for name, at in zip(tie.between, tie.at, strict=True):
            end, pose = at, poses.get(name)
            if name in node_rows:
                nodes = start[node_rows[name]]
                dist = np.linalg.norm(nodes - at, axis=1)
                tol = _DISTANCE_TOL * np.ptp(nodes)
                is_nearest = dist <= (1.0 + _DISTANCE_TOL) * dist.min() + tol
                end = at + (points[node_rows[name]] - nodes)[is_nearest].mean(axis=0)
            elif pose is not None and pose.ndim == 1:
                end = pose[:9].reshape(3, 3) @ at + pose[9:]
            ends.append(end)
    return np.array(ends, np.float64).reshape(-1, 2, 3)


def place_of(base: FloatArray, points: FloatArray) -> FloatArray:
    """Return the rigid motion (12,) from `base` (n, 3) to `points` if it is one, else the points.

    A motion is the closest rotation by rows (Kabsch 1976), then a translation. It counts as rigid
    if no coordinate departs by more than `_RIGID_TOL` of the size and distance of the part. The
    points, also returned if any is not finite, are (n, 3) float32.
    """
    a, b = base.mean(axis=0), points.mean(axis=0)
    if np.isfinite(base).all() and np.isfinite(points).all():
        left, _, right = np.linalg.svd((base - a).T @ (points - b))
        turn = np.diag([1.0, 1.0, np.sign(np.linalg.det(left @ right))])
        R = (left @ turn @ right).T
        t = b - R @ a
        departure = np.abs(base @ R.T + t - points).max(initial=0.0)
        if departure <= _RIGID_TOL * (np.abs(points).max(initial=0.0) + np.ptp(points)):
            return np.concatenate([R.ravel(), t])
    return np.asarray(points, np.float32)
