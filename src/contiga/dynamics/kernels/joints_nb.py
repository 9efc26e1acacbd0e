"""Joints between rigid bodies: constraints of positions and velocities within a leapfrog (RATTLE).

A joint has a marker on each of two bodies: a point p and three axes, a on the first body and b on
the second. Its constraints are rows of three kinds, with d = p₂ − p₁:

    d · e_i = 0,    d · a_i = 0,    a_i · b_j = 0.

With G their derivative by the velocities of the bodies, a step kicks the momenta by Gᵀ(q₀) λ so
that the constraints hold where the drift ends, and once the forces there have kicked them by
Gᵀ(q₁) μ so that the velocities fulfil G v = 0 (H. C. Andersen, J. Comput. Phys. 52, 1983; for rigid
bodies Leimkuhler and Reich, Simulating Hamiltonian Dynamics, 2004, ch. 7 and 8). λ is found by
Newton's method with the symmetric matrix G M⁻¹ Gᵀ of the start of the step. The reported reactions,
with which the next step begins, make the accelerations fulfil the constraints; they take one more
solution with the matrix of the end.

All rows of all joints make one system. It is scaled to a diagonal of ones and factored by Cholesky
within the envelope of its rows. A row whose pivot vanishes depends on the rows before it, as in
closed loops: its column is left out, A = L Lᵀ with fewer columns, and the multipliers are the least
squares solution of least norm, A⁺ = L (Lᵀ L)⁻¹ (Lᵀ L)⁻¹ Lᵀ (P. Courrieu, Neural Inf. Process. 8,
2005).

`table` is a `JointTable` and `work` a `JointWork`; `rows` (b, 19) and `fixed` (b, 22) are the free
bodies, columns by `contiga.rigid.rigid_lanes`.
"""

from __future__ import annotations

import math

import contiga.jit  # noqa: F401 (before any kernel: how they are kept)
from contiga.arrays.kernels.vector_nb import dot
from contiga.dynamics.joint_records import (
    ANGLE,
    CONE,
    OFFSET_A,
    OFFSET_W,
    SECOND_ANGLE,
    TRAVEL,
)
from contiga.dynamics.joint_records import AXES as AXES_ROW
from contiga.dynamics.kernels.rigid_body_nb import (
    direction,
    drift_turn,
    inertia_tensor,
    place_frame,
    spin_of,
    turn_by,
    twist_of,
)
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

DEPENDENT = 1e-10
"""Pivot of the scaled matrix below which a row depends on the rows before it."""
MAX_ITERATIONS = 50
"""Newton iterations of a step; each reduces the misfit by about the angle of the step."""
MAX_FIT_ITERATIONS = 200
"""Newton iterations at the start, where bodies may be far from their joints."""
CLOSED = 1e-15
"""Misfit, over the size of the mechanism, below which joints are closed."""
ROUNDING = 1e-12
"""Misfit below which an iteration that does not reduce it is the last."""


@inner(error_model="numpy")
def _cross(a, b, out):
    """Write a × b into `out` (3,)."""
    out[0] = a[1] * b[2] - a[2] * b[1]
    out[1] = a[2] * b[0] - a[0] * b[2]
    out[2] = a[0] * b[1] - a[1] * b[0]


@inner(linked=False, error_model="numpy")
def _place_markers(table, work, rows, fixed, poses):
    """Write points, arms and axes of the markers into `work`; arms of bodies not free are zero.

    Free bodies are placed by their `rows`, driven ones by `poses` (n, 4, 4); the ground does not
    move.
    """
    for g in range(table.bodies.shape[0]):
        for side in range(2):
            row, body = table.rows[g, side], table.bodies[g, side]
            point, arm = work.points[g, side], work.arms[g, side]
            point_B = table.points_B[g, side]
            for k in range(3):
                arm[k] = 0.0
            if row >= 0:
                q, constants = rows[row, TURN : TURN + 4], fixed[row]
                d = direction(
                    q,
                    point_B[0] - constants[CENTRE_B],
                    point_B[1] - constants[CENTRE_B + 1],
                    point_B[2] - constants[CENTRE_B + 2],
                )
                for k in range(3):
                    arm[k] = d[k]
                    point[k] = rows[row, CENTRE + k] + d[k]
                for j in range(3):
                    axis = table.axes_B[g, side, j]
                    d = direction(q, axis[0], axis[1], axis[2])
                    for k in range(3):
                        work.axes[g, side, j, k] = d[k]
            elif body >= 0:
                pose = poses[body]
                for k in range(3):
                    point[k] = pose[k, 3] + dot(pose[k], point_B)
                for j in range(3):
                    for k in range(3):
                        work.axes[g, side, j, k] = dot(pose[k], table.axes_B[g, side, j])
            else:
                for k in range(3):
                    point[k] = point_B[k]
                for j in range(3):
                    for k in range(3):
                        work.axes[g, side, j, k] = table.axes_B[g, side, j, k]


@inner(linked=False, error_model="numpy")
def _misfits(table, work):
    """Write the residuals of all constraints into `work.right`, and return the largest misfit.

    Residuals are lengths, or a_i · b_j, the sine of an angle. The largest has lengths over the size
    of the mechanism, and is NaN if one of them is.
    """
    worst = 0.0
    for m in range(table.constraints.shape[0]):
        g, kind, i, j = table.constraints[m]
        if kind == AXES_ROW:
            value = dot(work.axes[g, 0, i], work.axes[g, 1, j])
            misfit = abs(value)
        else:
            value = 0.0
            for k in range(3):
                difference = work.points[g, 1, k] - work.points[g, 0, k]
                component = 1.0 * (k == i)
                if kind == OFFSET_A:
                    component = work.axes[g, 0, i, k]
                value += difference * component
            misfit = abs(value) / table.size[0]
        work.right[m] = value
        if not (misfit <= worst or math.isnan(worst)):
            worst = misfit
    return worst


@inner(linked=False, error_model="numpy")
def _derive(table, work, rows, fixed):
    """Write G, M⁻¹ Gᵀ and the inverse inertia tensors of the free bodies into `work`.

    They are `jacobian`, of all bodies, `weighted`, zero for bodies not free and along held
    directions, and `inverse`. The points, arms and axes of the markers are read from `work`.
    """
    tensor, unit = scratch(3, 3), scratch(3)
    for b in range(rows.shape[0]):
        q, constants, inverse = rows[b, TURN : TURN + 4], fixed[b], work.inverse[b]
        if (
            constants[FREE_ROTATIONS]
            + constants[FREE_ROTATIONS + 1]
            + constants[FREE_ROTATIONS + 2]
            == 3.0
        ):
            for i in range(3):
                for j in range(3):
                    inverse[i, j] = 0.0
            for k in range(3):
                a = direction(
                    q, constants[AXES + k], constants[AXES + 3 + k], constants[AXES + 6 + k]
                )
                for i in range(3):
                    for j in range(3):
                        inverse[i, j] += a[i] * a[j] / constants[MOMENTS + k]
            continue
        for k in range(3):
            for i in range(3):
                unit[i] = 1.0 * (i == k)
            d = spin_of(q, constants, unit, tensor)
            for i in range(3):
                inverse[i, k] = d[i]
    force, moment, difference, arm_moment = scratch(3), scratch(3), scratch(3), scratch(3)
    for m in range(table.constraints.shape[0]):
        g, kind, i, j = table.constraints[m]
        a, b = work.axes[g, 0, i], work.axes[g, 1, j]
        for side in range(2):
            sign = 2.0 * side - 1.0
            for k in range(3):
                force[k] = moment[k] = 0.0
            if kind == AXES_ROW:
                _cross(b, a, moment)
            elif kind == OFFSET_W:
                force[i] = 1.0
            else:
                for k in range(3):
                    force[k] = a[k]
                    difference[k] = work.points[g, 1, k] - work.points[g, 0, k]
                if side == 0:
                    _cross(difference, a, moment)
            _cross(work.arms[g, side], force, arm_moment)
            jacobian, weighted = work.jacobian[m, side], work.weighted[m, side]
            row = table.rows[g, side]
            for k in range(3):
                jacobian[k] = sign * force[k]
                jacobian[3 + k] = sign * (arm_moment[k] + moment[k])
                weighted[k] = weighted[3 + k] = 0.0
            if row >= 0:
                for k in range(3):
                    weighted[k] = jacobian[k] / fixed[row, MASS] * fixed[row, FREE_DIRECTIONS + k]
                    weighted[3 + k] = dot(work.inverse[row, k], jacobian[3:])


@inner(linked=False, error_model="numpy")
def _factor(table, work):
    """Build G M⁻¹ Gᵀ from `work.jacobian` and `.weighted`, factor it, and return its rank.

    It is scaled to a diagonal of ones. A row whose pivot is at most `DEPENDENT` gets the pivot 0,
    and does not count in the rank; Lᵀ L is then factored, too. Writes `matrix`, `scale`, `gram`.
    """
    n, matrix, scale = table.constraints.shape[0], work.matrix, work.scale
    for i in range(n):
        for j in range(table.first[i], i + 1):
            matrix[i, j] = 0.0
    for p in range(table.couples.shape[0]):
        i0, i1, side, j0, j1, other = table.couples[p]
        for i in range(i0, i1):
            a = work.jacobian[i, side]
            for j in range(j0, min(j1, i + 1)):
                b = work.weighted[j, other]
                matrix[i, j] += dot(a, b) + dot(a[3:], b[3:])
    for i in range(n):
        scale[i] = 1.0 / math.sqrt(matrix[i, i]) if matrix[i, i] > 0.0 else 0.0
    rank = 0
    for i in range(n):
        first = table.first[i]
        for j in range(first, i + 1):
            matrix[i, j] *= scale[i] * scale[j]
        for j in range(first, i):
            total = matrix[i, j]
            for k in range(max(first, table.first[j]), j):
                total -= matrix[i, k] * matrix[j, k]
            matrix[i, j] = total / matrix[j, j] if matrix[j, j] > 0.0 else 0.0
        pivot = matrix[i, i]
        for k in range(first, i):
            pivot -= matrix[i, k] * matrix[i, k]
        if pivot > DEPENDENT:
            matrix[i, i] = math.sqrt(pivot)
            rank += 1
        else:
            matrix[i, i] = 0.0
    if rank < n:
        _factor_gram(table, work)
    return rank


@inner(linked=False, error_model="numpy")
def _factor_gram(table, work):
    """Write Lᵀ L into `work.gram` and factor it by Cholesky.

    Columns that are left out of L get a diagonal of one.
    """
    matrix, gram = work.matrix, work.gram
    n = matrix.shape[0]
    for i in range(n):
        for j in range(i + 1):
            total = 0.0
            for k in range(i, n):
                if table.first[k] <= j and matrix[i, i] > 0.0 and matrix[j, j] > 0.0:
                    total += matrix[k, i] * matrix[k, j]
            gram[i, j] = total
        if matrix[i, i] == 0.0:
            gram[i, i] = 1.0
    for i in range(n):
        for j in range(i + 1):
            total = gram[i, j]
            for k in range(j):
                total -= gram[i, k] * gram[j, k]
            gram[i, j] = math.sqrt(total) if i == j else total / gram[j, j]


@inner(error_model="numpy")
def _substitute(lower, first, x):
    """Solve L Lᵀ y = x in place of x (m,); `first` (m,) is the envelope of L."""
    n = x.shape[0]
    for i in range(n):
        total = x[i]
        for k in range(first[i], i):
            total -= lower[i, k] * x[k]
        x[i] = total / lower[i, i]
    for i in range(n - 1, -1, -1):
        x[i] /= lower[i, i]
        for k in range(first[i], i):
            x[k] -= lower[i, k] * x[i]


@inner(linked=False, error_model="numpy")
def _solve(table, work, rank):
    """Solve G M⁻¹ Gᵀ λ = −right for `work.multipliers`; `work.right` is overwritten.

    Below full `rank` of `_factor` they are the least squares solution of least norm of the scaled
    system.
    """
    n, right, out = work.right.shape[0], work.right, work.multipliers
    for i in range(n):
        right[i] *= -work.scale[i]
    if rank == n:
        for i in range(n):
            out[i] = right[i]
        _substitute(work.matrix, table.first, out)
    else:
        lower = work.matrix
        for i in range(n):
            out[i] = 0.0
            if lower[i, i] > 0.0:
                for k in range(i, n):
                    if table.first[k] <= i:
                        out[i] += lower[k, i] * right[k]
        _substitute(work.gram, table.full, out)
        _substitute(work.gram, table.full, out)
        for i in range(n):
            right[i] = out[i]
        for i in range(n):
            out[i] = 0.0
            for k in range(table.first[i], i + 1):
                if lower[k, k] > 0.0:
                    out[i] += lower[i, k] * right[k]
    for i in range(n):
        out[i] *= work.scale[i]


@inner(error_model="numpy")
def _shift(table, work, columns):
    """Write Σ λ columns over the constraints into `work.shift`; `columns` (m, 2, 6) G or M⁻¹ Gᵀ.

    The sum (b, 6) has one row for each free body; λ is `work.multipliers`.
    """
    for b in range(work.shift.shape[0]):
        for k in range(6):
            work.shift[b, k] = 0.0
    for m in range(table.constraints.shape[0]):
        for side in range(2):
            row = table.rows[table.constraints[m, 0], side]
            if row >= 0:
                for k in range(6):
                    work.shift[row, k] += work.multipliers[m] * columns[m, side, k]


@inner(error_model="numpy")
def _kick(table, work, rows, fixed, part):
    """Kick the velocities and angular momenta in `rows` by Gᵀ λ times `part`.

    Held directions and rotations are not kicked; `work.shift` is overwritten.
    """
    _shift(table, work, work.jacobian)
    for b in range(rows.shape[0]):
        for k in range(3):
            change = work.shift[b, k] / fixed[b, MASS] * fixed[b, FREE_DIRECTIONS + k]
            rows[b, VELOCITY + k] += part * change
            rows[b, MOMENTUM + k] += part * work.shift[b, 3 + k] * fixed[b, FREE_ROTATIONS + k]


@kernel(error_model="numpy")
def fit(rows, poses, fixed, table, work):
    """Move free bodies so that all joints close: places and orientations in `rows` (b, 19).

    Each iteration is the least motion weighted by mass (Gauss); momenta are not turned with the
    bodies. Iterations end at a misfit of `CLOSED`, below `ROUNDING` where it falls no more, or
    after `MAX_FIT_ITERATIONS`. Returns the largest misfit, as `_misfits`, before the last motion if
    that limit is reached.
    """
    before, misfit = math.inf, math.inf
    for _ in range(MAX_FIT_ITERATIONS):
        _place_markers(table, work, rows, fixed, poses)
        misfit = _misfits(table, work)
        if misfit <= CLOSED or (misfit <= ROUNDING and misfit >= before):
            break
        before = misfit
        _derive(table, work, rows, fixed)
        _solve(table, work, _factor(table, work))
        _shift(table, work, work.weighted)
        for b in range(rows.shape[0]):
            for k in range(3):
                rows[b, CENTRE + k] += work.shift[b, k]
            q = rows[b, TURN : TURN + 4]
            turn_by(q, work.shift[b, 3], work.shift[b, 4], work.shift[b, 5])
            norm = math.sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
            for k in range(4):
                q[k] /= norm
    return misfit


@kernel(error_model="numpy")
def close(last, last_poses, free, poses, fixed, h, table, work):
    """Correct a drift over the time `h` so that all joints are closed at its end.

    `free` are the bodies (`Placed`) after `rigid_body_nb.drift` from the rows `last` (b, 19); rows,
    poses and predicted twists are changed. `last_poses` and `poses` (n, 4, 4) are those of driven
    bodies before and after the step. Iterations end as in `fit`, after `MAX_ITERATIONS`, or at a
    misfit that is not finite. Returns the largest misfit as `fit` does.
    """
    rows, tensor = free.rows, scratch(3, 3)
    momentum, velocity = scratch(3), scratch(3)
    _place_markers(table, work, last, fixed, last_poses)
    _derive(table, work, last, fixed)
    rank = _factor(table, work)
    before, misfit = math.inf, math.inf
    for _ in range(MAX_ITERATIONS):
        _place_markers(table, work, rows, fixed, poses)
        misfit = _misfits(table, work)
        if misfit <= CLOSED or (misfit <= ROUNDING and misfit >= before) or not misfit < math.inf:
            break
        before = misfit
        _solve(table, work, rank)
        _kick(table, work, rows, fixed, 1.0 / h)
        for b in range(rows.shape[0]):
            row = rows[b]
            for k in range(3):
                row[CENTRE + k] = last[b, CENTRE + k] + h * row[VELOCITY + k]
            for k in range(4):
                row[TURN + k] = last[b, TURN + k]
            drift_turn(row, fixed[b], h, tensor)
    for b in range(rows.shape[0]):
        row, constants = rows[b], fixed[b]
        for k in range(3):
            kick = 0.5 * h * last[b, FORCE + k] / constants[MASS] * constants[FREE_DIRECTIONS + k]
            velocity[k] = row[VELOCITY + k] + kick
            momentum[k] = (
                row[MOMENTUM + k] + 0.5 * h * last[b, TORQUE + k] * constants[FREE_ROTATIONS + k]
            )
        place_frame(row, constants, free.poses[b])
        twist_of(row, constants, free.poses[b], momentum, velocity, free.twists[b], tensor)
    return misfit


@inner(linked=False, error_model="numpy")
def _marker_rates(table, work, rows, fixed, poses, twists):
    """Write velocities and spins of the markers into `work.rates`; zeros on the ground.

    `poses` (n, 4, 4) and `twists` (n, 6) are those of driven bodies.
    """
    arm, turn = scratch(3), scratch(3)
    for g in range(table.bodies.shape[0]):
        for side in range(2):
            row, body, rate = table.rows[g, side], table.bodies[g, side], work.rates[g, side]
            for k in range(6):
                rate[k] = 0.0
            if row >= 0:
                for k in range(3):
                    rate[k] = rows[row, VELOCITY + k]
                    rate[3 + k] = dot(work.inverse[row, k], rows[row, MOMENTUM : MOMENTUM + 3])
                    arm[k] = work.arms[g, side, k]
            elif body >= 0:
                for k in range(6):
                    rate[k] = twists[body, k]
                for k in range(3):
                    arm[k] = work.points[g, side, k] - poses[body, k, 3]
            else:
                continue
            _cross(rate[3:], arm, turn)
            for k in range(3):
                rate[k] += turn[k]


@inner(linked=False, error_model="numpy")
def _row_rates(table, work):
    """Write the rates of all constraints into `work.right`, from the markers' rates in `work`."""
    a_rate, b_rate, difference = scratch(3), scratch(3), scratch(3)
    for m in range(table.constraints.shape[0]):
        g, kind, i, j = table.constraints[m]
        first, second = work.rates[g, 0], work.rates[g, 1]
        a, b = work.axes[g, 0, i], work.axes[g, 1, j]
        _cross(first[3:], a, a_rate)
        if kind == AXES_ROW:
            _cross(second[3:], b, b_rate)
            work.right[m] = dot(a_rate, b) + dot(a, b_rate)
        elif kind == OFFSET_W:
            work.right[m] = second[i] - first[i]
        else:
            value = 0.0
            for k in range(3):
                difference[k] = work.points[g, 1, k] - work.points[g, 0, k]
                value += (second[k] - first[k]) * a[k]
            work.right[m] = value + dot(difference, a_rate)


@inner(linked=False, error_model="numpy")
def _marker_accelerations(table, work, rows, fixed, poses, accelerations):
    """Write accelerations of the markers into `work.accelerations`; zeros on the ground.

    Free bodies have those by the forces in `rows`, driven ones `accelerations` (n, 6). Rates of the
    markers are in `work.rates`.
    """
    arm, turn, centripetal = scratch(3), scratch(3), scratch(3)
    tensor, momentum, torque = scratch(3, 3), scratch(3), scratch(3)
    for g in range(table.bodies.shape[0]):
        for side in range(2):
            row, body = table.rows[g, side], table.bodies[g, side]
            acceleration, spin = work.accelerations[g, side], work.rates[g, side, 3:]
            for k in range(6):
                acceleration[k] = 0.0
            if row >= 0:
                constants = fixed[row]
                inertia_tensor(rows[row, TURN : TURN + 4], constants, tensor)
                for k in range(3):
                    momentum[k] = dot(tensor[k], spin)
                _cross(spin, momentum, turn)
                for k in range(3):
                    acceleration[k] = (
                        rows[row, FORCE + k] / constants[MASS] * constants[FREE_DIRECTIONS + k]
                    )
                    torque[k] = rows[row, TORQUE + k] - turn[k]
                    arm[k] = work.arms[g, side, k]
                for k in range(3):
                    acceleration[3 + k] = dot(work.inverse[row, k], torque)
            elif body >= 0:
                for k in range(6):
                    acceleration[k] = accelerations[body, k]
                for k in range(3):
                    arm[k] = work.points[g, side, k] - poses[body, k, 3]
            else:
                continue
            _cross(spin, arm, turn)
            _cross(spin, turn, centripetal)
            _cross(acceleration[3:], arm, turn)
            for k in range(3):
                acceleration[k] += turn[k] + centripetal[k]


@inner(linked=False, error_model="numpy")
def _row_accelerations(table, work):
    """Write the second time derivatives of all constraints into `work.right`.

    They follow from the markers, their rates and their accelerations in `work`.
    """
    a_rate, a_second, difference = scratch(3), scratch(3), scratch(3)
    b_rate, b_second, change = scratch(3), scratch(3), scratch(3)
    for m in range(table.constraints.shape[0]):
        g, kind, i, j = table.constraints[m]
        first, second = work.accelerations[g, 0], work.accelerations[g, 1]
        a, b = work.axes[g, 0, i], work.axes[g, 1, j]
        if kind == OFFSET_W:
            work.right[m] = second[i] - first[i]
            continue
        spin = work.rates[g, 0, 3:]
        _cross(spin, a, a_rate)
        _cross(spin, a_rate, a_second)
        _cross(first[3:], a, change)
        for k in range(3):
            a_second[k] += change[k]
        if kind == AXES_ROW:
            value = dot(a_second, b)
            spin = work.rates[g, 1, 3:]
            _cross(spin, b, b_rate)
            value += 2.0 * dot(a_rate, b_rate)
            _cross(spin, b_rate, b_second)
            _cross(second[3:], b, change)
            work.right[m] = value + dot(a, b_second) + dot(a, change)
        else:
            value = 0.0
            for k in range(3):
                difference[k] = work.points[g, 1, k] - work.points[g, 0, k]
                value += (second[k] - first[k]) * a[k]
                value += 2.0 * (work.rates[g, 1, k] - work.rates[g, 0, k]) * a_rate[k]
            work.right[m] = value + dot(difference, a_second)


@kernel(error_model="numpy")
def react(free, poses, twists, accelerations, fixed, table, work, reactions):
    """End the kick of a step: project the velocities onto the constraints, and find the reactions.

    `free` are the bodies (`Placed`) after `rigid_body_nb.kick`; their velocities, twists and forces
    are changed. `poses` (n, 4, 4), `twists` (n, 6) and `accelerations` (n, 6) are those of driven
    bodies. The `reactions` (g, 6), force on the second body and moment about its marker, world
    axes, are written and added to the forces. Returns the kinetic energy.
    """
    rows, tensor = free.rows, scratch(3, 3)
    moment, unit = scratch(3), scratch(3)
    _place_markers(table, work, rows, fixed, poses)
    _derive(table, work, rows, fixed)
    rank = _factor(table, work)
    for _ in range(2):  # the second removes the rounding errors of the first
        _marker_rates(table, work, rows, fixed, poses, twists)
        _row_rates(table, work)
        _solve(table, work, rank)
        _kick(table, work, rows, fixed, 1.0)
    _marker_rates(table, work, rows, fixed, poses, twists)
    _marker_accelerations(table, work, rows, fixed, poses, accelerations)
    _row_accelerations(table, work)
    _solve(table, work, rank)
    _shift(table, work, work.jacobian)
    energy = 0.0
    for b in range(rows.shape[0]):
        row, constants = rows[b], fixed[b]
        for k in range(3):
            row[FORCE + k] += work.shift[b, k]
            row[TORQUE + k] += work.shift[b, 3 + k]
        momentum, velocity = row[MOMENTUM : MOMENTUM + 3], row[VELOCITY : VELOCITY + 3]
        twist_of(row, constants, free.poses[b], momentum, velocity, free.twists[b], tensor)
        for k in range(3):
            energy += 0.5 * constants[MASS] * velocity[k] * velocity[k]
            energy += 0.5 * momentum[k] * free.twists[b, 3 + k]
    for g in range(reactions.shape[0]):
        for k in range(6):
            reactions[g, k] = 0.0
    for m in range(table.constraints.shape[0]):
        g, kind, i, j = table.constraints[m]
        if kind == AXES_ROW:
            _cross(work.axes[g, 1, j], work.axes[g, 0, i], moment)
            for k in range(3):
                reactions[g, 3 + k] += work.multipliers[m] * moment[k]
        else:
            for k in range(3):
                unit[k] = 1.0 * (k == i)
                if kind == OFFSET_A:
                    unit[k] = work.axes[g, 0, i, k]
                reactions[g, k] += work.multipliers[m] * unit[k]
    return energy


@inner(error_model="numpy")
def _angle(kind, a, b, moment):
    """Return an angle between axes `a` and `b` (3, 3), radians, and write its `moment` (3,).

    That is the moment on the second body per unit of the coordinate's; zero for a CONE of parallel
    axes, which have no direction. Angles are within ±π, without full turns; a CONE's is 0 to π.
    """
    if kind == ANGLE:
        for k in range(3):
            moment[k] = a[2, k]
        return math.atan2(dot(b[0], a[1]), dot(b[0], a[0]))
    if kind == SECOND_ANGLE:
        for k in range(3):
            moment[k] = b[0, k]
        return math.atan2(dot(a[2], b[1]), dot(a[2], b[2]))
    if kind == CONE:
        _cross(a[2], b[2], moment)
        sine = math.sqrt(dot(moment, moment))
        for k in range(3):
            moment[k] = moment[k] / sine if sine > 0.0 else 0.0
        return math.atan2(sine, dot(a[2], b[2]))
    for k in range(3):
        moment[k] = (a[2, k] + b[2, k]) / (1.0 + dot(a[2], b[2]))
    return math.atan2(dot(a[1], b[0]) - dot(a[0], b[1]), dot(a[0], b[0]) + dot(a[1], b[1]))


@kernel(error_model="numpy")
def measure(poses, twists, table, points, values, rates, ways):
    """Measure the coordinates of joints from poses (n, 4, 4) and twists (n, 6) of all bodies.

    Writes `points` (g, 3), markers of the second bodies, world coordinates; `values` (c,), which
    hold the last values on entry, so that full turns are counted (not of a CONE); their `rates`
    (c,); and `ways` (c, 6), force on the second body at its marker and moment per unit of each
    coordinate's force, with the opposite on the first body there.
    """
    at, axes = scratch(2, 3), scratch(2, 3, 3)
    rate, turn, arm = scratch(2, 6), scratch(3), scratch(3)
    for g in range(table.bodies.shape[0]):
        body = table.bodies[g, 1]
        for k in range(3):
            points[g, k] = table.points_B[g, 1, k]
            if body >= 0:
                points[g, k] = poses[body, k, 3] + dot(poses[body, k], table.points_B[g, 1])
    for c in range(table.coordinates.shape[0]):
        g, kind = table.coordinates[c]
        for side in range(2):
            body = table.bodies[g, side]
            for k in range(6):
                rate[side, k] = 0.0
            for k in range(3):
                at[side, k] = table.points_B[g, side, k]
                for j in range(3):
                    axes[side, j, k] = table.axes_B[g, side, j, k]
            if body < 0:
                continue
            pose = poses[body]
            for k in range(3):
                arm[k] = dot(pose[k], table.points_B[g, side])
                at[side, k] = pose[k, 3] + arm[k]
                for j in range(3):
                    axes[side, j, k] = dot(pose[k], table.axes_B[g, side, j])
            _cross(twists[body, 3:], arm, turn)
            for k in range(3):
                rate[side, k] = twists[body, k] + turn[k]
                rate[side, 3 + k] = twists[body, 3 + k]
        a, b, force = axes[0], axes[1], ways[c]
        for k in range(6):
            force[k] = 0.0
        rates[c] = 0.0
        if kind == TRAVEL:
            for k in range(3):
                arm[k] = at[1, k] - at[0, k]
                force[k] = a[2, k]
            values[c] = dot(arm, a[2])
            # The first body carries the second's marker with it.
            _cross(rate[0, 3:], arm, turn)
            for k in range(3):
                rates[c] += force[k] * (rate[1, k] - rate[0, k] - turn[k])
            continue
        value = _angle(kind, a, b, force[3:])
        if kind != CONE:
            value += 2.0 * math.pi * math.floor((values[c] - value) / (2.0 * math.pi) + 0.5)
        values[c] = value
        for k in range(3):
            rates[c] += force[3 + k] * (rate[1, 3 + k] - rate[0, 3 + k])


@kernel(error_model="numpy")
def add_wrenches(table, points, wrenches, poses, total):
    """Add `wrenches` (g, 6) on second bodies about `points` (g, 3), and the opposite on first ones.

    They are added to `total` (n, 6), the wrenches about the origins of bodies at `poses`
    (n, 4, 4). The ground gets none.
    """
    arm, turn = scratch(3), scratch(3)
    for g in range(table.bodies.shape[0]):
        for side in range(2):
            body, sign = table.bodies[g, side], 2.0 * side - 1.0
            if body < 0:
                continue
            for k in range(3):
                arm[k] = points[g, k] - poses[body, k, 3]
            _cross(arm, wrenches[g, :3], turn)
            for k in range(3):
                total[body, k] += sign * wrenches[g, k]
                total[body, 3 + k] += sign * (wrenches[g, 3 + k] + turn[k])


@kernel(error_model="numpy")
def misfits(rows, poses, fixed, table, work):
    """Place the markers in `work` and write the residuals of all constraints into `work.right`.

    Returns the largest misfit, over the size of the mechanism.
    """
    _place_markers(table, work, rows, fixed, poses)
    return _misfits(table, work)


@kernel(error_model="numpy")
def derive(rows, fixed, table, work):
    """Write G, M⁻¹ Gᵀ and inverse inertias into `work`, by the markers that `misfits` placed."""
    _derive(table, work, rows, fixed)
