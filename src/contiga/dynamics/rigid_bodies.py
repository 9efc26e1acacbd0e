"""Free rigid bodies as rows of one array: constants, start, and the stages of a step."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contiga.arrays.ordered import principal_axes, product
from contiga.dynamics.free import HOLDS, Free
from contiga.dynamics.kernels import rigid_body_nb
from contiga.errors import InputError
from contiga.jit import straight
from contiga.records import FloatArray, IndexArray, MassProperties
from contiga.rigid import rigid_lanes as lanes
from contiga.rigid.inertia import combined


class Placed(NamedTuple):
    """Free bodies at one time, b rows."""

    rows: FloatArray
    """(b, 19), columns by `contiga.rigid.rigid_lanes`."""
    poses: FloatArray
    """(b, 4, 4) X_WB of their frames."""
    twists: FloatArray
    """(b, 6) velocity of the frames' origins and spin, world axes."""


def with_attached(
    name: str, motion: Free, attached: list[MassProperties], glued: list[MassProperties]
) -> Free:
    """Return a free body with the masses of the bodies attached and the nodes glued to it.

    The velocity of the motion counts for the common centre of the bodies; that of the centre with
    the nodes follows from the spin, and is 0 along held directions. Without anything to add the
    result is `motion` itself.

    Raises
    ------
    InputError
        The body has no mass or one for each node, or no inertia though it may rotate.
    """
    if not (attached or glued):
        return motion
    may_turn = not {"rx", "ry", "rz"} <= set(motion.hold)
    if motion.mass is None or np.ndim(motion.mass) != 0 or (motion.inertia is None and may_turn):
        raise InputError(
            "a free body that carries other masses needs mass and inertia",
            where=f"bodies[{name!r}]: motion",
            allowed="Free(mass=…, inertia=…, centre=…), or Free(body.mass_properties(density))",
        )
    centre = np.zeros(3) if motion.centre is None else motion.centre
    inertia = np.zeros((3, 3)) if motion.inertia is None else motion.inertia
    bodies = combined([MassProperties(float(motion.mass), centre, inertia), *attached])
    total = combined([bodies, *glued])
    shift = total.centre - bodies.centre if glued else np.zeros(3)
    is_held = [axis in motion.hold for axis in HOLDS[:3]]
    return Free(
        mass=total.mass,
        centre=total.centre,
        inertia=None if motion.inertia is None else total.inertia,
        velocity=np.where(is_held, 0.0, motion.velocity + np.cross(motion.spin, shift)),
        spin=motion.spin,
        hold=motion.hold,
    )


def fixed_of(name: str, motion: Free) -> FloatArray:
    """Return the constants (22,) of a free body, columns by `contiga.rigid.rigid_lanes`.

    A body that cannot rotate and has no inertia gets moments of 1, which have no effect.

    Raises
    ------
    InputError
        No mass, masses or velocities of nodes, no inertia though the body may rotate.
    """
    where = f"bodies[{name!r}]: motion"
    if motion.mass is None or np.ndim(motion.mass) != 0 or motion.velocity.ndim != 1:
        raise InputError(
            "a free body needs one mass and one velocity",
            where=where,
            found=f"mass {motion.mass}" if motion.mass is None else "those of nodes",
            remedy="Give Free(mass=…), or Free(body.mass_properties(density))",
        )
    fixed = np.zeros(lanes.FIXED)
    fixed[lanes.MASS] = motion.mass
    fixed[lanes.FREE_DIRECTIONS : lanes.FREE_DIRECTIONS + 3] = [
        axis not in motion.hold for axis in HOLDS[:3]
    ]
    fixed[lanes.FREE_ROTATIONS : lanes.FREE_ROTATIONS + 3] = [
        axis not in motion.hold for axis in HOLDS[3:]
    ]
    if motion.centre is not None:
        fixed[lanes.CENTRE_B : lanes.CENTRE_B + 3] = motion.centre
    fixed[lanes.MOMENTS : lanes.MOMENTS + 3] = 1.0
    fixed[lanes.AXES : lanes.AXES + 9] = np.eye(3).ravel()
    if motion.inertia is not None:
        moments, axes = principal_axes(motion.inertia)
        fixed[lanes.MOMENTS : lanes.MOMENTS + 3] = moments[::-1]
        fixed[lanes.AXES : lanes.AXES + 9] = axes[::-1].T.ravel()
    elif fixed[lanes.FREE_ROTATIONS : lanes.FREE_ROTATIONS + 3].any():
        raise InputError(
            "a free body that may turn needs its inertia",
            where=where,
            remedy='Give inertia=(3, 3) about the centre, or hold=["rx", "ry", "rz"]',
        )
    return fixed


def row_of(motion: Free, fixed: FloatArray) -> FloatArray:
    """Return the row (19,) of a body with constants `fixed` (22,) at the start, without forces.

    It is not displaced or turned; its angular momentum is that of the motion's spin.
    """
    row = np.zeros(lanes.STATE)
    row[lanes.CENTRE : lanes.CENTRE + 3] = fixed[lanes.CENTRE_B : lanes.CENTRE_B + 3]
    row[lanes.TURN] = 1.0
    row[lanes.VELOCITY : lanes.VELOCITY + 3] = motion.velocity
    axes = fixed[lanes.AXES : lanes.AXES + 9].reshape(3, 3)
    momenta = fixed[lanes.MOMENTS : lanes.MOMENTS + 3] * product(axes.T, motion.spin)
    row[lanes.MOMENTUM : lanes.MOMENTUM + 3] = product(axes, momenta)
    return row


def bodies_at_start(rows: FloatArray, fixed: FloatArray) -> Placed:
    """Return the bodies at the start: a copy of `rows` (b, 19), with the poses and twists of them.

    Spins about held axes are zero, whatever the angular momenta in the rows.
    """
    b = len(rows)
    placed = Placed(rows.copy(), np.empty((b, 4, 4)), np.empty((b, 6)))
    straight(rigid_body_nb.start)(placed.rows, fixed, placed.poses, placed.twists)
    return placed


def drift_bodies(last: FloatArray, fixed: FloatArray, dt: float) -> Placed:
    """Return the bodies after the drift of a step, with velocities predicted by constant forces.

    The momenta in the rows are those at mid-step, until `kick_bodies`. `last` (b, 19) is not
    changed.
    """
    b = len(last)
    placed = Placed(last.copy(), np.empty((b, 4, 4)), np.empty((b, 6)))
    straight(rigid_body_nb.drift)(last, fixed, dt, placed.rows, placed.poses, placed.twists)
    return placed


def kick_bodies(placed: Placed, fixed: FloatArray, loads: FloatArray, dt: float) -> float:
    """End the step of `drift_bodies` in place, and return the kinetic energy.

    Parameters
    ----------
    placed : places and velocities from `drift_bodies`, changed in place
    fixed : (b, 22) constants of the bodies, rows of `fixed_of`
    loads : (b, 6) force and moment about the frames' origins, world axes
    dt : length of the step; 0 at the start
    """
    energy: float = straight(rigid_body_nb.kick)(
        placed.rows, fixed, loads, dt, placed.poses, placed.twists
    )
    return energy


def add_gravity(
    placed: Placed, fixed: FloatArray, gravity: FloatArray, free: IndexArray, loads: FloatArray
) -> None:
    """Add the weights of the bodies to the rows `free` (b,) of loads (n, 6), see `kick_bodies`."""
    straight(rigid_body_nb.weigh)(placed.rows, fixed, gravity, placed.poses, free, loads)


def work_of_gravity(
    last: FloatArray, rows: FloatArray, fixed: FloatArray, gravity: FloatArray
) -> float:
    """Return the work of gravity in a step of the bodies from `last` (b, 19) to `rows` (b, 19)."""
    work: float = straight(rigid_body_nb.lowered)(last, rows, fixed, gravity)
    return work
