"""Screws: the even motion from one pose to another, exact where a body turns about a fixed axis.

Every rigid motion is a turn about an axis and a way along it (Chasles). In the frame of the first
pose its parts are ``exp(s ξ)``, ξ the logarithm of the whole (Lynch and Park, Modern Robotics,
2017, 3.3.3), and every point goes along a helix about the axis.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from contiga.arrays.ordered import length, product
from contiga.records import FloatArray
from contiga.rigid import quaternion
from contiga.rigid.frames import cross
from contiga.rigid.pose import identity, relative
from contiga.rigid.transform import cross_matrix

_NO_TURN = np.array([1.0, 0.0, 0.0, 0.0])


class Screw(NamedTuple):
    """The even motion of a frame over s = 0 … 1, in the axes it has at s = 0."""

    turn: FloatArray
    """(3,) axis times angle, at most half a turn."""
    velocity: FloatArray
    """(3,) of what is at the origin, a unit of s."""

    def pose(self, s: float) -> FloatArray:
        """Return (4, 4) the frame after the part `s` of the motion, in the frame at s = 0."""
        turn = s * self.turn
        angle, K = length(turn), cross_matrix(turn)
        K2 = product(K, K)
        # 1 − cos from the half angle; what is lost in θ − sin θ is multiplied by θ² again.
        a = 0.5 * float(np.sinc(0.5 * angle / np.pi)) ** 2
        b = (angle - np.sin(angle)) / angle**3 if angle > 0.0 else 1.0 / 6.0
        X = identity()
        X[:3, :3] += float(np.sinc(angle / np.pi)) * K + a * K2
        X[:3, 3] = product(np.eye(3) + a * K + b * K2, s * self.velocity)
        return X

    def field(self, points: FloatArray) -> FloatArray:
        """Return velocities (n, 3) of points (n, 3) that go with the frame, in axes at s = 0."""
        return np.asarray(self.velocity + np.cross(self.turn, points))


def screw_between(X_WA: FloatArray, X_WB: FloatArray) -> Screw:
    """The even motion of a frame from pose A to pose B, the shorter way round, in the axes of A."""
    X_AB = relative(X_WA, X_WB)
    turn = quaternion.rotation_vector(_NO_TURN, quaternion.from_matrix(X_AB[:3, :3]))
    half, way = 0.5 * length(turn), X_AB[:3, 3]
    c = (1.0 - half / math.tan(half)) / (4.0 * half * half) if half > 0.0 else 1.0 / 12.0
    across = cross(turn, way)
    return Screw(turn, way - 0.5 * across + c * cross(turn, across))
