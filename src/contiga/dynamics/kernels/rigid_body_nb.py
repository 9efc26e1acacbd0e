"""Free rigid bodies, one step of a leapfrog: half a kick, a drift, half a kick.

Kicks change momenta by forces, drifts move bodies by momenta. A drift turns a free body by

    H = L²/(2 I₂) + m₁² (1/I₁ − 1/I₂)/2 + m₃² (1/I₃ − 1/I₂)/2,

I₁ ≤ I₂ ≤ I₃ its principal moments, m = (m₁, m₂, m₃) its angular momentum in their axes and L the
same in world axes. Each of the three parts is solved exactly by an even turn: the first about L,
the others about principal axes. Strang's order of them is symplectic, reversible and second order
(McLachlan, Explicit Lie-Poisson integration and the Euler equations, Phys. Rev. Lett. 71, 1993),
keeps L as it is, since no part touches it, and is exact for bodies with two equal moments.

A body with held rotations keeps the momenta of those that are not held, and turns by the spin that
they give half way (implicit midpoint).
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
    MASS,
    MOMENTS,
    MOMENTUM,
    SPINS,
    TORQUE,
    TURN,
    VELOCITY,
    WAYS,
)

ROUNDS = 50
"""Of the midpoint's iteration, which gains digits by the angle of a step."""
SAME = 1e-16
"""Change of spin times step below which it has converged."""


@inner(error_model="numpy")
def _turned(q, w, x, y, z):
    """The turn (w, x, y, z) after the turn `q`: their product with `q` on the right."""
    q0, q1, q2, q3 = q[0], q[1], q[2], q[3]
    q[0] = w * q0 - x * q1 - y * q2 - z * q3
    q[1] = w * q1 + x * q0 + y * q3 - z * q2
    q[2] = w * q2 - x * q3 + y * q0 + z * q1
    q[3] = w * q3 + x * q2 - y * q1 + z * q0


@inner(error_model="numpy")
def _turn_about(q, x, y, z, angle):
    """Turn `q` about a unit axis of the world."""
    s = math.sin(0.5 * angle)
    _turned(q, math.cos(0.5 * angle), s * x, s * y, s * z)


@inner(error_model="numpy")
def turn_by(q, x, y, z):
    """Turn `q` by a rotation vector in world axes."""
    angle = math.sqrt(x * x + y * y + z * z)
    if angle > 0.0:
        _turn_about(q, x / angle, y / angle, z / angle, angle)


@inner(error_model="numpy")
def direction(q, x, y, z):
    """A direction of the body in world axes."""
    a = 2.0 * (q[2] * z - q[3] * y)
    b = 2.0 * (q[3] * x - q[1] * z)
    c = 2.0 * (q[1] * y - q[2] * x)
    return (
        x + q[0] * a + q[2] * c - q[3] * b,
        y + q[0] * b + q[3] * a - q[1] * c,
        z + q[0] * c + q[1] * b - q[2] * a,
    )


@inner(linked=False, error_model="numpy")
def inertia_tensor(q, one, tensor):
    """The inertia tensor in world axes."""
    tensor[:] = 0.0
    for k in range(3):
        a = direction(q, one[AXES + k], one[AXES + 3 + k], one[AXES + 6 + k])
        for i in range(3):
            for j in range(3):
                tensor[i, j] += one[MOMENTS + k] * a[i] * a[j]


@inner(error_model="numpy")
def spin_of(q, one, momentum, tensor):
    """Angular velocity in world axes of a body with these momenta; zero about held axes."""
    inertia_tensor(q, one, tensor)
    for k in range(3):
        if one[SPINS + k] == 0.0:
            for j in range(3):
                tensor[k, j] = tensor[j, k] = 0.0
            tensor[k, k] = 1.0
    x, y, z = momentum[0] * one[SPINS], momentum[1] * one[SPINS + 1], momentum[2] * one[SPINS + 2]
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
def _drift_about(q, one, momentum, k, h):
    """The part of a principal axis `k`, for a time `h`."""
    a = direction(q, one[AXES + k], one[AXES + 3 + k], one[AXES + 6 + k])
    m = a[0] * momentum[0] + a[1] * momentum[1] + a[2] * momentum[2]
    angle = h * m * (1.0 / one[MOMENTS + k] - 1.0 / one[MOMENTS + 1])
    _turn_about(q, a[0], a[1], a[2], angle)


@inner(error_model="numpy")
def _drift_free(q, one, momentum, h):
    """Turn a body that no rotation is held of."""
    _drift_about(q, one, momentum, 0, 0.5 * h)
    _drift_about(q, one, momentum, 2, h)
    _drift_about(q, one, momentum, 0, 0.5 * h)
    part = h / one[MOMENTS + 1]
    turn_by(q, part * momentum[0], part * momentum[1], part * momentum[2])


@inner(error_model="numpy")
def _drift_held(q, one, momentum, h, tensor):
    """Turn a body with held rotations."""
    middle = scratch(4)
    x, y, z = spin_of(q, one, momentum, tensor)
    for _ in range(ROUNDS):
        for k in range(4):
            middle[k] = q[k]
        turn_by(middle, 0.5 * h * x, 0.5 * h * y, 0.5 * h * z)
        a, b, c = spin_of(middle, one, momentum, tensor)
        change = h * max(abs(a - x), abs(b - y), abs(c - z))
        x, y, z = a, b, c
        if change <= SAME:
            break
    turn_by(q, h * x, h * y, h * z)


@inner(linked=False, error_model="numpy")
def drift_turn(row, one, h, tensor):
    """Turn a body by its momentum, for a time `h`."""
    q, own = row[TURN : TURN + 4], row[MOMENTUM : MOMENTUM + 3]
    held = 3.0 - one[SPINS] - one[SPINS + 1] - one[SPINS + 2]
    if held == 0.0:
        _drift_free(q, one, own, h)
    elif held < 3.0:
        _drift_held(q, one, own, h, tensor)
    size = math.sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
    for k in range(4):
        q[k] /= size


@inner(error_model="numpy")
def place_frame(row, one, pose):
    """The pose of a body's frame."""
    q = row[TURN : TURN + 4]
    for k in range(3):
        d = direction(q, 1.0 * (k == 0), 1.0 * (k == 1), 1.0 * (k == 2))
        for i in range(3):
            pose[i, k] = d[i]
        pose[3, k] = 0.0
    for i in range(3):
        arm = 0.0
        for k in range(3):
            arm += pose[i, k] * one[CENTRE_B + k]
        pose[i, 3] = row[CENTRE + i] - arm
    pose[3, 3] = 1.0


@inner(error_model="numpy")
def twist_of(row, one, pose, momentum, velocity, twist, tensor):
    """Velocity of the origin of a body's frame, and its spin."""
    x, y, z = spin_of(row[TURN : TURN + 4], one, momentum, tensor)
    a = pose[0, 3] - row[CENTRE]
    b = pose[1, 3] - row[CENTRE + 1]
    c = pose[2, 3] - row[CENTRE + 2]
    twist[0] = velocity[0] + y * c - z * b
    twist[1] = velocity[1] + z * a - x * c
    twist[2] = velocity[2] + x * b - y * a
    twist[3], twist[4], twist[5] = x, y, z


@kernel(error_model="numpy")
def start(rows, fixed, poses, twists):
    """Poses and twists of bodies as they stand, from their `rows` (b, 19)."""
    tensor = scratch(3, 3)
    for i in range(rows.shape[0]):
        row, one = rows[i], fixed[i]
        place_frame(row, one, poses[i])
        twist_of(
            row,
            one,
            poses[i],
            row[MOMENTUM : MOMENTUM + 3],
            row[VELOCITY : VELOCITY + 3],
            twists[i],
            tensor,
        )


@kernel(error_model="numpy")
def drift(last, fixed, h, rows, poses, twists):
    """Half a kick by the forces of `last` (b, 19), and a drift over `h` into `rows` (b, 19).

    The twists are those that the same forces would give at the end: second order, what damping and
    friction ask for.
    """
    tensor, momentum, velocity = scratch(3, 3), scratch(3), scratch(3)
    for i in range(last.shape[0]):
        row, one = rows[i], fixed[i]
        for k in range(last.shape[1]):
            row[k] = last[i, k]
        for k in range(3):
            kick = 0.5 * h * last[i, FORCE + k] / one[MASS] * one[WAYS + k]
            row[VELOCITY + k] += kick
            velocity[k] = row[VELOCITY + k] + kick
            row[CENTRE + k] += h * row[VELOCITY + k]
            kick = 0.5 * h * last[i, TORQUE + k] * one[SPINS + k]
            row[MOMENTUM + k] += kick
            momentum[k] = row[MOMENTUM + k] + kick
        drift_turn(row, one, h, tensor)
        place_frame(row, one, poses[i])
        twist_of(row, one, poses[i], momentum, velocity, twists[i], tensor)


@kernel(error_model="numpy")
def kick(rows, fixed, loads, h, poses, twists):
    """The other half of the kick, by `loads` (b, 6): force and moment about the frame's origin.

    `rows` and `twists` are changed to the end of the step. Answers the kinetic energy.
    """
    tensor, energy = scratch(3, 3), 0.0
    for i in range(rows.shape[0]):
        row, one, load = rows[i], fixed[i], loads[i]
        a = poses[i, 0, 3] - row[CENTRE]
        b = poses[i, 1, 3] - row[CENTRE + 1]
        c = poses[i, 2, 3] - row[CENTRE + 2]
        row[TORQUE] = load[3] + b * load[2] - c * load[1]
        row[TORQUE + 1] = load[4] + c * load[0] - a * load[2]
        row[TORQUE + 2] = load[5] + a * load[1] - b * load[0]
        for k in range(3):
            row[FORCE + k] = load[k]
            row[VELOCITY + k] += 0.5 * h * load[k] / one[MASS] * one[WAYS + k]
            row[MOMENTUM + k] += 0.5 * h * row[TORQUE + k] * one[SPINS + k]
        momentum, velocity = row[MOMENTUM : MOMENTUM + 3], row[VELOCITY : VELOCITY + 3]
        twist_of(row, one, poses[i], momentum, velocity, twists[i], tensor)
        for k in range(3):
            energy += 0.5 * one[MASS] * velocity[k] * velocity[k]
            energy += 0.5 * momentum[k] * twists[i, 3 + k]
    return energy


@kernel(error_model="numpy")
def weigh(rows, fixed, gravity, poses, free, loads):
    """Add the weight of bodies to rows `free` (b,) of loads (n, 6): force and moment about the
    frames' origins."""
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
    """Work of gravity on bodies that went from `last` (b, 19) to `rows` (b, 19)."""
    work = 0.0
    for i in range(rows.shape[0]):
        for k in range(3):
            way = rows[i, CENTRE + k] - last[i, CENTRE + k]
            work += fixed[i, MASS] * gravity[k] * way
    return work
