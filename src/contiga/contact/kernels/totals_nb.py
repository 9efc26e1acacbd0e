"""Sums over the points that carry forces: the wrench, and where the work went."""

from __future__ import annotations

import numpy as np

from contiga.contact.kernels.carrying_nb import at, way_of
from contiga.contact.kernels.sums_nb import sum_of
from contiga.jit import inner, kernel
from contiga.jit.scratch import scratch

WORK, STORED, HYSTERESIS, DAMPING, FRICTION = 6, 7, 8, 9, 10
TOTALS = 11
"""Where the totals stand, and how many numbers they are: energies as `ContactEnergy` has them."""


@inner()
def _turned(pose, x, y, z, c):
    """Return axis c of a direction of the body in the world; adds nothing where the frame is."""
    return pose[c, 0] * x + pose[c, 1] * y + pose[c, 2] * z + 0.0 * pose[c, 3]


@inner()
def _add_wrench(points, k, force, frame, totals):
    """Add a force (world axes) at point k, and its moment."""
    pose, about = frame.pose, frame.reference_point
    x, y, z = points[k, 0] - about[0], points[k, 1] - about[1], points[k, 2] - about[2]
    arm = (_turned(pose, x, y, z, 0), _turned(pose, x, y, z, 1), _turned(pose, x, y, z, 2))
    totals[0] += force[0]
    totals[1] += force[1]
    totals[2] += force[2]
    totals[3] += arm[1] * force[2] - arm[2] * force[1]
    totals[4] += arm[2] * force[0] - arm[0] * force[2]
    totals[5] += arm[0] * force[1] - arm[1] * force[0]


@inner(linked=False, error_model="numpy")
def _work_before(sizes, normals, tractions, now, before):
    """Return half the work of the last step's forces on the way of this one.

    Each of the `Column`s has its rows ascending: sizes (k,) of forces along the normals (h, 3), and
    forces (t, 3) across them. Points without a size count for nothing.
    """
    rows = sizes.rows
    work = np.empty(3 * rows.shape[0])
    n = a = b = 0
    for i in range(rows.shape[0]):
        size = sizes.values[i]
        if size == 0.0:
            continue
        k = rows[i]
        a, b = at(normals.rows, k, a), at(tractions.rows, k, b)
        known = a < normals.rows.shape[0] and normals.rows[a] == k
        across = b < tractions.rows.shape[0] and tractions.rows[b] == k
        for c in range(3):
            force = size * (normals.values[a, c] if known else 0.0)
            if across:
                force += tractions.values[b, c]
            work[n] = force * way_of(now, before, k, c)
            n += 1
    return -0.5 * sum_of(work, n)


@inner(error_model="numpy")
def _energies(work, damped, answer, last, now, totals):
    """Add what the step adds to the energies; `work` and `damped` are products of forces and ways.

    Of the work by the trapezoidal rule half is that of forces at each end of the step.
    """
    n, there = work.shape[0], last.points
    normals = last.normal
    totals[WORK] += _work_before(last.force, normals, last.traction, now, there) + -0.5 * sum_of(
        work, n
    )
    stored = sum_of(answer.stored, answer.stored.shape[0])
    totals[STORED] = stored + sum_of(answer.held, answer.held.shape[0])
    totals[HYSTERESIS] += sum_of(answer.hysteresis, answer.hysteresis.shape[0])
    all_damped = 0.0
    if answer.damping.shape[0] > 0:
        all_damped += -0.5 * sum_of(damped, n)
    # Also where it takes all of the normal force, of points that come out fast.
    totals[DAMPING] += all_damped + _work_before(last.damping, normals, last.none, now, there)
    totals[FRICTION] += sum_of(answer.lost, answer.lost.shape[0])


@kernel(error_model="numpy")
def forces(carrying, answer, last, now, frame, out):
    """Compute the forces on the points that carry, world axes, their wrench, and the energies.

    `carrying` are `ContactRows`, `answer` is an `Answer`, `last` are `LastForces`, `now` (n, 3) all
    points, `frame` is a `Frame`. `out` is a `Felt`, to be filled. Returns whether any damping is
    not zero.
    """
    rows, normal, way, rate = carrying.rows, carrying.normal, carrying.path, carrying.rate
    damping, friction, totals, pose = answer.damping, answer.friction, out.totals, frame.pose
    n = rows.shape[0]
    work, damped, force = np.empty(3 * n), np.empty(3 * n), scratch(3)
    viscous = False
    for k in range(WORK):
        totals[k] = 0.0
    for k in range(last.energies.shape[0]):
        totals[WORK + k] = last.energies[k]
    for i in range(n):
        for c in range(3):
            force[c] = answer.force[i] * normal[i, c]
            if friction.shape[0] > 0:
                force[c] += friction[i, c]
            work[3 * i + c] = force[c] * way[i, c]
        for c in range(3):
            out.force[i, c] = _turned(pose, force[0], force[1], force[2], c)
        _add_wrench(now, rows[i], out.force[i], frame, totals)
        if damping.shape[0] > 0:
            viscous = viscous or damping[i] != 0.0
            out.viscosity[i] = abs(damping[i] / rate[i]) if rate[i] != 0.0 else 0.0
            for c in range(3):
                damped[3 * i + c] = damping[i] * normal[i, c] * way[i, c]
    _energies(work, damped, answer, last, now, totals)
    for c in range(WORK):
        totals[c] = 0.0 - totals[c]
    return viscous
