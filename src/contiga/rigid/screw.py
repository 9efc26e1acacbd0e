"""Screws: the uniform motion from one pose to another, exact for rotation about a fixed axis.

Every rigid displacement is a rotation about an axis and a translation along it (Chasles). In the
frame of the first pose the motion is ``exp(s ξ)``, ξ the logarithm of the displacement (Lynch and
Park, Modern Robotics, 2017, 3.3.3), and every point follows a helix about the axis.
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

_IDENTITY = np.array([1.0, 0.0, 0.0, 0.0])


class Screw(NamedTuple):
    """The uniform motion of a frame over s = 0 … 1, in its axes at s = 0."""

    turn: FloatArray
    """(3,) axis times angle, at most half a turn."""
    velocity: FloatArray
    """(3,) velocity at the origin, by s."""

    def pose(self, s: float) -> FloatArray:
        """Return the frame (4, 4) at `s`, in the frame at s = 0."""
        turn = s * self.turn
        angle, K = length(turn), cross_matrix(turn)
        K2 = product(K, K)
        # 1 − cos θ is from the half angle; the cancellation in θ − sin θ is multiplied by θ² again.
        a = 0.5 * float(np.sinc(0.5 * angle / np.pi)) ** 2
        b = (angle - np.sin(angle)) / angle**3 if angle > 0.0 else 1.0 / 6.0
        X = identity()
        X[:3, :3] += float(np.sinc(angle / np.pi)) * K + a * K2
        X[:3, 3] = product(np.eye(3) + a * K + b * K2, s * self.velocity)
        return X

    def field(self, points: FloatArray) -> FloatArray:
        """Return velocities (n, 3) of points (n, 3) fixed to the frame, in its axes at s = 0."""
        return np.asarray(self.velocity + np.cross(self.turn, points))


def screw_between(X_WA: FloatArray, X_WB: FloatArray) -> Screw:
    """Return the uniform screw motion from pose A (s = 0) to pose B (s = 1), in the axes of A.

    It turns by the smaller angle: the logarithm of the relative pose, in closed form.
    """
    X_AB = relative(X_WA, X_WB)
    turn = quaternion.rotation_vector(_IDENTITY, quaternion.from_matrix(X_AB[:3, :3]))
    half, shift = 0.5 * length(turn), X_AB[:3, 3]
    c = (1.0 - half / math.tan(half)) / (4.0 * half * half) if half > 0.0 else 1.0 / 12.0
    normal = cross(turn, shift)
    return Screw(turn, shift - 0.5 * normal + c * cross(turn, normal))
