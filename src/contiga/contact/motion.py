"""How fast points move against the body, where it is known exactly."""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from contiga.arrays.layout import as_points, locked, real
from contiga.arrays.threads import run_ranges
from contiga.contact.kernels import relative_nb
from contiga.errors import InputError
from contiga.records import FloatArray, IndexArray
from contiga.rigid.frames import POINTS
from contiga.slaves.sampling import Sampling

Velocities: TypeAlias = tuple[ArrayLike, ArrayLike]
"""(v, w): velocity of a frame's origin and its spin, world axes."""


class RelativeVelocity(NamedTuple):
    """Velocities of points against a body, which are worked out of those that are asked for."""

    sampling: Sampling
    nodes: FloatArray
    """(n, 3) velocities of the slave's nodes, world axes."""
    points: FloatArray
    """(m, 3) places of all points, world axes."""
    pose: FloatArray
    twist: FloatArray
    """(2, 3) velocity of the body's origin and its spin, world axes."""

    def at(self, rows: IndexArray) -> FloatArray:
        """(k, 3) of points `rows`, ascending, body axes."""
        v_W, p_W = self.sampling.points_at(rows, self.nodes), self.points.take(rows, axis=0)
        v_B = np.empty(v_W.shape)
        given = v_W, p_W, self.pose, self.twist, v_B
        run_ranges(relative_nb.relative, len(rows), POINTS, *given)
        return v_B


def relative_velocity(
    sampling: Sampling,
    p_W: FloatArray,
    poses: tuple[FloatArray, FloatArray],
    velocity: ArrayLike | None,
    twist: Velocities | None,
) -> RelativeVelocity | None:
    """How the points p_W (m, 3) go against the body; None where no velocity is given.

    `poses` are those of the body before and now.
    """
    if velocity is None:
        if twist is not None:
            raise InputError(
                "the twist of the master is given and the velocity of the slave is not",
                where="velocity",
                allowed="both or neither",
                remedy="Give velocity=(n, 3), zeros of a slave that stands still",
            )
        return None
    if twist is None and not np.array_equal(*poses):
        raise InputError(
            "the velocity of the slave is given and the twist of the master, which moves, is not",
            where="twist",
            allowed="both or neither",
            remedy="Give twist=(v, w): velocity of the master's origin and its spin",
        )
    v_W = as_points(velocity, "velocity")
    if len(v_W) != sampling.n_nodes:
        raise InputError(
            "velocity must have one row a slave point",
            where="velocity",
            found=len(v_W),
            allowed=str(sampling.n_nodes),
        )
    first = relative_nb.first_unknown(locked(v_W), locked(p_W))
    if first >= 0:
        raise InputError(
            "a point that has a place has no velocity",
            where=f"velocity[{first}]",
            found=v_W[first].tolist(),
            allowed="three finite numbers a point",
        )
    body = np.zeros((2, 3)) if twist is None else _checked(twist)
    return RelativeVelocity(sampling, v_W, p_W, poses[1], body)


def _checked(twist: Velocities) -> FloatArray:
    real(twist, "twist")
    try:
        both = np.array(twist, np.float64)
    except (TypeError, ValueError):
        both = np.zeros(0)
    if both.shape != (2, 3) or not np.isfinite(both).all():
        raise InputError(
            "a twist is a velocity and a spin",
            where="twist",
            found=twist,
            allowed="(v, w) of three finite numbers each",
        )
    return both
