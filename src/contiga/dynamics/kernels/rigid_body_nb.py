"""Free rigid bodies, one step of a leapfrog: half a kick, a drift, half a kick.

Kicks change momenta by forces, drifts move bodies by momenta. A drift turns a free body by

    H = L²/(2 I₂) + m₁² (1/I₁ − 1/I₂)/2 + m₃² (1/I₃ − 1/I₂)/2,

I₁ ≤ I₂ ≤ I₃ its principal moments, m = (m₁, m₂, m₃) its angular momentum in their axes and L the
same in world axes. Each of the three parts is solved exactly by a uniform rotation: the first about
L, the others about principal axes. Strang's order of them is symplectic, reversible and second
order (McLachlan, Explicit Lie-Poisson integration and the Euler equations, Phys. Rev. Lett. 71,
1993), conserves L, since no part changes it, and is exact for bodies with two equal moments.

A body with held rotations conserves the momenta about the other axes, and rotates by its spin at
mid-step (implicit midpoint).
"""

from __future__ import annotations

import math

import contiga.jit  # noqa: F401 (before any kernel: how they are kept)
from contiga.jit import inner, kernel
from contiga.jit.scratch import scratch
from contiga.rigid.rigid_lanes import (
    AXES,
    CENTRE,
    CENTRE_B,
    FORCE,
    FREE_DIRECTIONS,
    FREE_ROTATIONS,
    MASS,
    MOMENTS,
    MOMENTUM,
    TORQUE,
    TURN,
    VELOCITY,
)

MAX_ITERATIONS = 50
"""Iterations of the midpoint rule, whose convergence factor is the angle of a step."""
ANGLE_TOL = 1e-16
"""Change of spin times step below which the midpoint rule has converged."""


@inner(error_model="numpy")
def _turn_about(q, x, y, z, angle):
    """Rotate `q` in place about a unit axis of the world, by a product with `q` on the right."""
    s = math.sin(0.5 * angle)
    w, x, y, z = math.cos(0.5 * angle), s * x, s * y, s * z
    q0, q1, q2, q3 = q[0], q[1], q[2], q[3]
    q[0] = w * q0 - x * q1 - y * q2 - z * q3
    q[1] = w * q1 + x * q0 + y * q3 - z * q2
    q[2] = w * q2 - x * q3 + y * q0 + z * q1
    q[3] = w * q3 + x * q2 - y * q1 + z * q0


@inner(error_model="numpy")
def turn_by(q, x, y, z):
    """Rotate `q` in place by a rotation vector in world axes."""
    angle = math.sqrt(x * x + y * y + z * z)
    if angle > 0.0:
        _turn_about(q, x / angle, y / angle, z / angle, angle)


@inner(error_model="numpy")
def direction(q, x, y, z):
    """Return a vector (x, y, z) of the body in world axes, by its unit quaternion w, x, y, z."""
    a = 2.0 * (q[2] * z - q[3] * y)
    b = 2.0 * (q[3] * x - q[1] * z)
    c = 2.0 * (q[1] * y - q[2] * x)
    return (
        x + q[0] * a + q[2] * c - q[3] * b,
        y + q[0] * b + q[3] * a - q[1] * c,
        z + q[0] * c + q[1] * b - q[2] * a,
    )


@inner(linked=False, error_model="numpy")
def inertia_tensor(q, constants, tensor):
    """Write the inertia tensor of a body turned by `q` in world axes into `tensor` (3, 3)."""
    tensor[:] = 0.0
    for k in range(3):
        a = direction(q, constants[AXES + k], constants[AXES + 3 + k], constants[AXES + 6 + k])
        for i in range(3):
            for j in range(3):
                tensor[i, j] += constants[MOMENTS + k] * a[i] * a[j]


@inner(error_model="numpy")
def spin_of(q, constants, momentum, tensor):
    """Return the spin of a body with an angular momentum, world axes; zero about held axes.

    `tensor` (3, 3) is overwritten. Momenta about held axes do not count.
    """
    inertia_tensor(q, constants, tensor)
    for k in range(3):
        if constants[FREE_ROTATIONS + k] == 0.0:
            for j in range(3):
                tensor[k, j] = tensor[j, k] = 0.0
            tensor[k, k] = 1.0
    x, y, z = (
        momentum[0] * constants[FREE_ROTATIONS],
        momentum[1] * constants[FREE_ROTATIONS + 1],
        momentum[2] * constants[FREE_ROTATIONS + 2],
    )
    # Cholesky's factors of a positive definite tensor.
    a = math.sqrt(tensor[0, 0])
    b, c = tensor[1, 0] / a, tensor[2, 0] / a
    d = math.sqrt(tensor[1, 1] - b * b)
    e = (tensor[2, 1] - c * b) / d
    f = math.sqrt(tensor[2, 2] - c * c - e * e)
    x = x / a
    y = (y - b * x) / d
    z = (z - c * x - e * y) / f
    z = z / f
    y = (y - e * z) / d
    return (x - b * y - c * z) / a, y, z


@inner(error_model="numpy")
def _drift_about(q, constants, momentum, k, h):
    """Rotate `q` in place by the part of H of principal axis `k` over a time `h`."""
    a = direction(q, constants[AXES + k], constants[AXES + 3 + k], constants[AXES + 6 + k])
    m = a[0] * momentum[0] + a[1] * momentum[1] + a[2] * momentum[2]
    angle = h * m * (1.0 / constants[MOMENTS + k] - 1.0 / constants[MOMENTS + 1])
    _turn_about(q, a[0], a[1], a[2], angle)


@inner(error_model="numpy")
def _drift_midpoint(q, constants, momentum, h, tensor):
    """Rotate `q` of a body with held rotations in place by the implicit midpoint rule.

    Fixed-point iterations end at a change of `ANGLE_TOL`, or after `MAX_ITERATIONS`.
    """
    middle = scratch(4)
    x, y, z = spin_of(q, constants, momentum, tensor)
    for _ in range(MAX_ITERATIONS):
        for k in range(4):
            middle[k] = q[k]
        turn_by(middle, 0.5 * h * x, 0.5 * h * y, 0.5 * h * z)
        a, b, c = spin_of(middle, constants, momentum, tensor)
        change = h * max(abs(a - x), abs(b - y), abs(c - z))
        x, y, z = a, b, c
        if change <= ANGLE_TOL:
            break
    turn_by(q, h * x, h * y, h * z)


@inner(linked=False, error_model="numpy")
def drift_turn(row, constants, h, tensor):
    """Rotate a body's `row` in place by its angular momentum over a time `h`.

    Its quaternion is normalised; a body with three held rotations does not turn.
    """
    q, momentum = row[TURN : TURN + 4], row[MOMENTUM : MOMENTUM + 3]
    n_held = (
        3.0
        - constants[FREE_ROTATIONS]
        - constants[FREE_ROTATIONS + 1]
        - constants[FREE_ROTATIONS + 2]
    )
    if n_held == 0.0:
        _drift_about(q, constants, momentum, 0, 0.5 * h)
        _drift_about(q, constants, momentum, 2, h)
        _drift_about(q, constants, momentum, 0, 0.5 * h)
        factor = h / constants[MOMENTS + 1]
        turn_by(q, factor * momentum[0], factor * momentum[1], factor * momentum[2])
    elif n_held < 3.0:
        _drift_midpoint(q, constants, momentum, h, tensor)
    length = math.sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
    for k in range(4):
        q[k] /= length


@inner(error_model="numpy")
def place_frame(row, constants, pose):
    """Write the `pose` (4, 4) of a body's frame, by the centre of mass and turn in its `row`."""
    q = row[TURN : TURN + 4]
    for k in range(3):
        d = direction(q, 1.0 * (k == 0), 1.0 * (k == 1), 1.0 * (k == 2))
        for i in range(3):
            pose[i, k] = d[i]
        pose[3, k] = 0.0
    for i in range(3):
        arm = 0.0
        for k in range(3):
            arm += pose[i, k] * constants[CENTRE_B + k]
        pose[i, 3] = row[CENTRE + i] - arm
    pose[3, 3] = 1.0


@inner(error_model="numpy")
def twist_of(row, constants, pose, momentum, velocity, twist, tensor):
    """Write the velocity of the origin of a body's frame, and its spin, into `twist` (6,).

    `momentum` and `velocity` of the centre are those to use in place of the row's.
    """
    x, y, z = spin_of(row[TURN : TURN + 4], constants, momentum, tensor)
    a = pose[0, 3] - row[CENTRE]
    b = pose[1, 3] - row[CENTRE + 1]
    c = pose[2, 3] - row[CENTRE + 2]
    twist[0] = velocity[0] + y * c - z * b
    twist[1] = velocity[1] + z * a - x * c
    twist[2] = velocity[2] + x * b - y * a
    twist[3], twist[4], twist[5] = x, y, z


@kernel(error_model="numpy")
def start(rows, fixed, poses, twists):
    """Write the `poses` (b, 4, 4) and `twists` (b, 6) of bodies from their `rows` (b, 19)."""
    tensor = scratch(3, 3)
    for i in range(rows.shape[0]):
        row, constants = rows[i], fixed[i]
        place_frame(row, constants, poses[i])
        twist_of(
            row,
            constants,
            poses[i],
            row[MOMENTUM : MOMENTUM + 3],
            row[VELOCITY : VELOCITY + 3],
            twists[i],
            tensor,
        )


@kernel(error_model="numpy")
def drift(last, fixed, h, rows, poses, twists):
    """Write `rows` (b, 19) after half a kick by the forces of `last` (b, 19) and a drift over `h`.

    `poses` (b, 4, 4) and `twists` (b, 6) are written, too. The twists are predictions for the end
    of the step with the same forces, of second order, for damping and friction.
    """
    tensor, momentum, velocity = scratch(3, 3), scratch(3), scratch(3)
    for i in range(last.shape[0]):
        row, constants = rows[i], fixed[i]
        for k in range(last.shape[1]):
            row[k] = last[i, k]
        for k in range(3):
            kick = 0.5 * h * last[i, FORCE + k] / constants[MASS] * constants[FREE_DIRECTIONS + k]
            row[VELOCITY + k] += kick
            velocity[k] = row[VELOCITY + k] + kick
            row[CENTRE + k] += h * row[VELOCITY + k]
            kick = 0.5 * h * last[i, TORQUE + k] * constants[FREE_ROTATIONS + k]
            row[MOMENTUM + k] += kick
            momentum[k] = row[MOMENTUM + k] + kick
        drift_turn(row, constants, h, tensor)
        place_frame(row, constants, poses[i])
        twist_of(row, constants, poses[i], momentum, velocity, twists[i], tensor)


@kernel(error_model="numpy")
def kick(rows, fixed, loads, h, poses, twists):
    """Add the second half of the kick by `loads` (b, 6), and return the kinetic energy.

    Loads are forces and moments about the frames' origins. `rows`, with the forces in them, and
    `twists` are changed to the end of the step. Held directions and rotations are not kicked.
    """
    tensor, energy = scratch(3, 3), 0.0
    for i in range(rows.shape[0]):
        row, constants, load = rows[i], fixed[i], loads[i]
        a = poses[i, 0, 3] - row[CENTRE]
        b = poses[i, 1, 3] - row[CENTRE + 1]
        c = poses[i, 2, 3] - row[CENTRE + 2]
        row[TORQUE] = load[3] + b * load[2] - c * load[1]
        row[TORQUE + 1] = load[4] + c * load[0] - a * load[2]
        row[TORQUE + 2] = load[5] + a * load[1] - b * load[0]
        for k in range(3):
            row[FORCE + k] = load[k]
            row[VELOCITY + k] += (
                0.5 * h * load[k] / constants[MASS] * constants[FREE_DIRECTIONS + k]
            )
            row[MOMENTUM + k] += 0.5 * h * row[TORQUE + k] * constants[FREE_ROTATIONS + k]
        momentum, velocity = row[MOMENTUM : MOMENTUM + 3], row[VELOCITY : VELOCITY + 3]
        twist_of(row, constants, poses[i], momentum, velocity, twists[i], tensor)
        for k in range(3):
            energy += 0.5 * constants[MASS] * velocity[k] * velocity[k]
            energy += 0.5 * momentum[k] * twists[i, 3 + k]
    return energy


@kernel(error_model="numpy")
def weigh(rows, fixed, gravity, poses, free, loads):
    """Add the weights of bodies to rows `free` (b,) of `loads` (n, 6).

    Loads are forces and moments about the frames' origins.
    """
    for i in range(rows.shape[0]):
        mass, load = fixed[i, MASS], loads[free[i]]
        x, y, z = mass * gravity[0], mass * gravity[1], mass * gravity[2]
        a = rows[i, CENTRE] - poses[i, 0, 3]
        b = rows[i, CENTRE + 1] - poses[i, 1, 3]
        c = rows[i, CENTRE + 2] - poses[i, 2, 3]
        load[0] += x
        load[1] += y
        load[2] += z
        load[3] += b * z - c * y
        load[4] += c * x - a * z
        load[5] += a * y - b * x


@kernel(error_model="numpy")
def lowered(last, rows, fixed, gravity):
    """Return the work of gravity on bodies from `last` (b, 19) to `rows` (b, 19)."""
    work = 0.0
    for i in range(rows.shape[0]):
        for k in range(3):
            displacement = rows[i, CENTRE + k] - last[i, CENTRE + k]
            work += fixed[i, MASS] * gravity[k] * displacement
    return work
