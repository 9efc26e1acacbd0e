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
    """Axis c of a direction of the body in the world; adds nothing where the frame is."""
    return pose[c, 0] * x + pose[c, 1] * y + pose[c, 2] * z + 0.0 * pose[c, 3]


@inner()
def _add_wrench(points, k, force, frame, totals):
    """Add a force (world axes) at point k, and its moment."""
    pose, about = frame
    x, y, z = points[k, 0] - about[0], points[k, 1] - about[1], points[k, 2] - about[2]
    arm = (_turned(pose, x, y, z, 0), _turned(pose, x, y, z, 1), _turned(pose, x, y, z, 2))
    totals[0] += force[0]
    totals[1] += force[1]
    totals[2] += force[2]
    totals[3] += arm[1] * force[2] - arm[2] * force[1]
    totals[4] += arm[2] * force[0] - arm[0] * force[2]
    totals[5] += arm[0] * force[1] - arm[1] * force[0]


@inner(linked=False, error_model="numpy")
def _work_before(column, normals, tractions, path):
    """Work of the last step's forces on the way of this one, half of it.

    Each of the columns is (rows, values), rows ascending: sizes (k,) of forces along the normals
    (h, 3), and forces (t, 3) across them. Points without a size count for nothing.
    """
    rows, sizes = column
    work = np.empty(3 * rows.shape[0])
    n = a = b = 0
    for i in range(rows.shape[0]):
        if sizes[i] == 0.0:
            continue
        k = rows[i]
        a, b = at(normals[0], k, a), at(tractions[0], k, b)
        known = a < normals[0].shape[0] and normals[0][a] == k
        across = b < tractions[0].shape[0] and tractions[0][b] == k
        for c in range(3):
            force = sizes[i] * (normals[1][a, c] if known else 0.0)
            if across:
                force += tractions[1][b, c]
            work[n] = force * way_of(path, k, c)
            n += 1
    return -0.5 * sum_of(work, n)


@inner(error_model="numpy")
def _energies(work, damped, answer, last, path, totals):
    """Add what the step adds to the energies; `work` and `damped` are products of forces and ways.

    Of the work by the trapezoidal rule half is that of forces at each end of the step.
    """
    n = work.shape[0]
    _, stored, hysteresis, damping, _, held, lost = answer
    size, normals, tractions, taken, _ = last
    before = _work_before(size, normals, tractions, path)
    totals[WORK] += before + -0.5 * sum_of(work, n)
    totals[STORED] = sum_of(stored, stored.shape[0]) + sum_of(held, held.shape[0])
    totals[HYSTERESIS] += sum_of(hysteresis, hysteresis.shape[0])
    all_damped = 0.0
    if damping.shape[0] > 0:
        all_damped += -0.5 * sum_of(damped, n)
    # Also where it takes all of the normal force, of points that come out fast.
    across = (tractions[0][:0], tractions[1])
    totals[DAMPING] += all_damped + _work_before(taken, normals, across, path)
    totals[FRICTION] += sum_of(lost, lost.shape[0])


@kernel(error_model="numpy")
def forces(carrying, answer, last, path, frame, out):
    """World forces on the points that carry, their wrench, and where the work of the step went.

    `carrying` is (rows, normal, way, rate) of the k points, `answer` what law and friction say of
    them, (force, stored, hysteresis, damping, friction, stored by it, lost by it), each without
    rows where it is not told; `last` is what was at the last step, columns of some rows each,
    (normal force, normal, friction, damping), and its energies (5,). `path` is (now, before) of all
    points and `frame` (pose, about), the point (3,) that the moment is about, body axes. `out` is
    (force (k, 3), viscosity (k,), totals): the wrench on the body, and the last energies with what
    the step adds. Returns whether any damping is not zero.
    """
    rows, normal, way, rate = carrying
    size, damping, friction = answer[0], answer[3], answer[4]
    force, viscosity, totals = out
    pose = frame[0]
    n = rows.shape[0]
    work, damped, own = np.empty(3 * n), np.empty(3 * n), scratch(3)
    viscous = False
    totals[:WORK], totals[WORK:] = 0.0, last[4]
    for i in range(n):
        for c in range(3):
            own[c] = size[i] * normal[i, c]
            if friction.shape[0] > 0:
                own[c] += friction[i, c]
            work[3 * i + c] = own[c] * way[i, c]
        for c in range(3):
            force[i, c] = _turned(pose, own[0], own[1], own[2], c)
        _add_wrench(path[0], rows[i], force[i], frame, totals)
        if damping.shape[0] > 0:
            viscous = viscous or damping[i] != 0.0
            viscosity[i] = abs(damping[i] / rate[i]) if rate[i] != 0.0 else 0.0
            for c in range(3):
                damped[3 * i + c] = damping[i] * normal[i, c] * way[i, c]
    _energies(work, damped, answer, last, path, totals)
    for c in range(WORK):
        totals[c] = 0.0 - totals[c]
    return viscous
