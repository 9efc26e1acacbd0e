"""Columns of the rows of free rigid bodies."""

from __future__ import annotations

# Columns of states (b, STATE), world axes.
CENTRE = 0
"""Centre of mass."""
TURN = 3
"""Orientation of the body's frame, a unit quaternion."""
VELOCITY = 7
"""Velocity of the centre of mass."""
MOMENTUM = 10
"""Angular momentum about the centre of mass; not used about held axes."""
FORCE = 13
TORQUE = 16
"""Torque about the centre of mass."""
STATE = 19

# Columns of constants (b, FIXED), body axes.
MASS = 0
CENTRE_B = 1
AXES = 4
"""Principal axes, the columns of a matrix (3, 3)."""
MOMENTS = 13
"""Principal moments of inertia, rising."""
FREE_DIRECTIONS = 16
"""1 for each world direction in which the centre may move, 0 for held ones."""
FREE_ROTATIONS = 19
"""1 for each world axis about which the body may rotate, 0 for held ones."""
FIXED = 22
