"""Sum forces and energies over the points that carry forces."""

from __future__ import annotations

import numpy as np

from contiga.contact.kernels.carrying_nb import displacement, row_position
from contiga.contact.kernels.sums_nb import sum_of
from contiga.jit import inner, kernel
from contiga.jit.scratch import scratch

WORK, STORED, HYSTERESIS, DAMPING, FRICTION = 6, 7, 8, 9, 10
TOTALS = 11
"""Positions in the totals, and their number; energies in the order of `ContactEnergy`."""


@inner()
def _rotated(pose, x, y, z, c):
    """Return axis c of a body vector in world axes; the zero term keeps NaN of the position."""
    return pose[c, 0] * x + pose[c, 1] * y + pose[c, 2] * z + 0.0 * pose[c, 3]


@inner()
def _add_wrench(points, k, force, frame, totals):
    """Add a force, in world axes, at point k to `totals`, and its moment about the reference point.

    `points` and the reference point are in body axes; the pose of `frame` turns the arm.
    """
    pose, about = frame.pose, frame.reference_point
    x, y, z = points[k, 0] - about[0], points[k, 1] - about[1], points[k, 2] - about[2]
    arm = (_rotated(pose, x, y, z, 0), _rotated(pose, x, y, z, 1), _rotated(pose, x, y, z, 2))
    totals[0] += force[0]
    totals[1] += force[1]
    totals[2] += force[2]
    totals[3] += arm[1] * force[2] - arm[2] * force[1]
    totals[4] += arm[2] * force[0] - arm[0] * force[2]
    totals[5] += arm[0] * force[1] - arm[1] * force[0]


@inner(linked=False, error_model="numpy")
def _work_of_last_forces(sizes, normals, tractions, now, before):
    """Return minus half the work of the last step's forces along the paths of this step.

    It is work done on the contact, by the trapezoidal rule. Rows of each `Column` are ascending:
    `sizes` (k,) of forces along the `normals` (h, 3), and `tractions` (t, 3) across them. Points of
    size zero do not count.
    """
    rows = sizes.rows
    work = np.empty(3 * rows.shape[0])
    n = a = b = 0
    for i in range(rows.shape[0]):
        size = sizes.values[i]
        if size == 0.0:
            continue
        k = rows[i]
        a, b = row_position(normals.rows, k, a), row_position(tractions.rows, k, b)
        has_normal = a < normals.rows.shape[0] and normals.rows[a] == k
        has_traction = b < tractions.rows.shape[0] and tractions.rows[b] == k
        for c in range(3):
            force = size * (normals.values[a, c] if has_normal else 0.0)
            if has_traction:
                force += tractions.values[b, c]
            work[n] = force * displacement(now, before, k, c)
            n += 1
    return -0.5 * sum_of(work, n)


@inner(error_model="numpy")
def _add_energies(work, damping_work, answer, last, now, totals):
    """Add the energies of the step to `totals`; the stored energy replaces the one before.

    `work` and `damping_work` are products of forces and paths. By the trapezoidal rule half of the
    work is that of the forces at each end of the step.
    """
    n, before = work.shape[0], last.points
    normals = last.normal
    totals[WORK] += _work_of_last_forces(
        last.force, normals, last.traction, now, before
    ) + -0.5 * sum_of(work, n)
    stored = sum_of(answer.stored, answer.stored.shape[0])
    totals[STORED] = stored + sum_of(answer.spring_energy, answer.spring_energy.shape[0])
    totals[HYSTERESIS] += sum_of(answer.hysteresis, answer.hysteresis.shape[0])
    total_damping = 0.0
    if answer.damping.shape[0] > 0:
        total_damping += -0.5 * sum_of(damping_work, n)
    # Damping counts even if it cancels the normal force, for points that come out fast.
    totals[DAMPING] += total_damping + _work_of_last_forces(
        last.damping, normals, last.none, now, before
    )
    totals[FRICTION] += sum_of(answer.lost, answer.lost.shape[0])


@kernel(error_model="numpy")
def forces(points, answer, last, now, frame, out):
    """Compute the forces on the points that carry, world axes, their wrench, and the energies.

    `points` are `ContactRows`, `answer` are `LawForces`, `last` are `LastForces`, `now` (n, 3) all
    points, `frame` is a `Frame`. `out` are `PointForces` to be filled; viscosities only with
    damping, and zero where the rate is. Returns whether any damping is not zero.
    """
    rows, normal, path, rate = points.rows, points.normal, points.path, points.rate
    damping, friction, totals, pose = answer.damping, answer.friction, out.totals, frame.pose
    n = rows.shape[0]
    work, damping_work, force = np.empty(3 * n), np.empty(3 * n), scratch(3)
    is_damped = False
    for k in range(WORK):
        totals[k] = 0.0
    for k in range(last.energies.shape[0]):
        totals[WORK + k] = last.energies[k]
    for i in range(n):
        for c in range(3):
            force[c] = answer.force[i] * normal[i, c]
            if friction.shape[0] > 0:
                force[c] += friction[i, c]
            work[3 * i + c] = force[c] * path[i, c]
        for c in range(3):
            out.force[i, c] = _rotated(pose, force[0], force[1], force[2], c)
        _add_wrench(now, rows[i], out.force[i], frame, totals)
        if damping.shape[0] > 0:
            is_damped = is_damped or damping[i] != 0.0
            out.viscosity[i] = abs(damping[i] / rate[i]) if rate[i] != 0.0 else 0.0
            for c in range(3):
                damping_work[3 * i + c] = damping[i] * normal[i, c] * path[i, c]
    _add_energies(work, damping_work, answer, last, now, totals)
    for c in range(WORK):
        totals[c] = 0.0 - totals[c]
    return is_damped
