"""Name the numbers in the row of a free rigid body, for kernels and for others."""

from __future__ import annotations

# Of a state, (b, STATE): world axes.
CENTRE = 0
"""Centre of mass."""
TURN = 3
"""Orientation of the body's frame, a unit quaternion."""
VELOCITY = 7
"""Of the centre of mass."""
MOMENTUM = 10
"""Angular, about the centre of mass; about held axes it means nothing."""
FORCE = 13
TORQUE = 16
"""About the centre of mass."""
STATE = 19

# Of what never changes, (b, FIXED): body axes.
MASS = 0
CENTRE_B = 1
AXES = 4
"""Principal axes, the columns of a matrix (3, 3)."""
MOMENTS = 13
"""Principal moments of inertia, rising."""
WAYS = 16
"""1 of the world's directions the centre may move in, 0 of those that are held."""
SPINS = 19
"""1 of the world's axes the body may turn about, 0 of those that are held."""
FIXED = 22
