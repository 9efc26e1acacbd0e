"""Twists: the velocity of the origin of a rigid frame and its spin, in world axes.

The velocity of a point p of the body is ``velocity + spin × (p − o)`` with the frame's origin o,
its ``pose[:3, 3]``. Spins are in radians / time.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contiga.arrays.ordered import product
from contiga.records import FloatArray


class Twist(NamedTuple):
    """The velocity of a frame."""

    velocity: FloatArray
    """(3,) of the frame's origin, world axes."""
    spin: FloatArray
    """(3,) angular velocity, world axes, radians / time."""

    def at(self, origin: FloatArray, points: FloatArray) -> FloatArray:
        """Return velocities (n, 3) of points (n, 3) of the body, whose frame is at `origin`."""
        return np.asarray(self.velocity + np.cross(self.spin, points - origin))


def still() -> Twist:
    """Return a twist of zero."""
    return Twist(np.zeros(3), np.zeros(3))


def combined(outer: Twist, X_WA: FloatArray, inner: Twist, X_AB: FloatArray) -> Twist:
    """Return the twist of B in the world, for A that moves in the world and B that moves in A.

    Parameters
    ----------
    outer, X_WA : twist and pose of A in the world
    inner, X_AB : twist and pose of B in A, in the axes of A
    """
    R = X_WA[:3, :3]
    arm = product(R, X_AB[:3, 3])
    velocity = outer.velocity + np.cross(outer.spin, arm) + product(R, inner.velocity)
    return Twist(velocity, outer.spin + product(R, inner.spin))
