"""Friction of points in contact, in one pass: the return mapping to Coulomb's cone, and viscous.

The formulas are those of `contiga.laws.friction`, with their sources. Each point is independent, so
that its bits depend on no other point and not on the number of threads. Derivatives are
directional: a change of the input gives the change of the forces.
"""

from __future__ import annotations

import math

from contiga.jit import inner, kernel
from contiga.jit.scratch import scratch


@inner()
def _row(rows, k):
    return rows[k, 0], rows[k, 1], rows[k, 2]


@inner()
def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@inner()
def _tangential(v, normal):
    """Return the projection of `v` to the plane with a unit `normal`."""
    normal_part = _dot(v, normal)
    return (
        v[0] - normal_part * normal[0],
        v[1] - normal_part * normal[1],
        v[2] - normal_part * normal[2],
    )


@inner()
def _transported(v, before, now):
    """Return `v` rotated by the smallest rotation from the unit normal `before` to `now`.

    For vectors tangential to the old plane this is the reflection at the plane normal to the sum of
    both normals, which preserves lengths to rounding. Between opposite normals there is no smallest
    rotation: the vectors are in the new plane already.
    """
    total = before[0] + now[0], before[1] + now[1], before[2] + now[2]
    square = _dot(total, total)
    factor = (2.0 / square if square > 0.0 else 0.0) * _dot(total, v)
    rotated = v[0] - factor * total[0], v[1] - factor * total[1], v[2] - factor * total[2]
    return _tangential(rotated, now)  # so that rounding does not accumulate out of the plane


@inner()
def _tangential_path(path, before, now):
    """Return the tangential part of a step's path, the mean of those in the planes at its ends.

    With one plane alone a path and its reverse would differ if the normal rotates while the point
    goes deeper: sticking points would creep, and the work would be of first order.
    """
    a, b = _transported(path, before, now), _tangential(path, now)
    return 0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1]), 0.5 * (a[2] + b[2])


@inner()
def _coulomb_spring(inp, law, k):
    """Return the stiffness of a point's spring before and now, their mean, and its factor.

    The factor is that of a change of the normal law's stiffness in the mean: 0 for a spring of its
    own stiffness or one that does not grow. A new point, 0 before, has its stiffness now as mean.
    """
    old, new = inp.memory[k, 6], max(inp.stiffness[k], 0.0)
    if law.stiffness > 0.0:
        new = law.stiffness * (inp.area[k] if law.per_area else 1.0)
    factor = 0.0
    if new > old and law.stiffness == 0.0:
        factor = 0.5 if old > 0.0 else 1.0
    stiffness = max(old, new)
    mean = 0.5 * (old + stiffness) if old > 0.0 else stiffness
    return old, stiffness, mean, factor


@inner()
def _energy(traction, stiffness):
    """Return the spring energy t²/(2 k), zero without a spring."""
    return 0.5 * _dot(traction, traction) / stiffness if stiffness > 0.0 else 0.0


@kernel()
def coulomb(inp, law, out, start, stop):
    """Write rows start … stop of `out`, a `FrictionOutput`, by the return mapping to the cone.

    `inp` is a `FrictionInput`, `law` are `CoulombNumbers`.
    """
    for k in range(start, stop):
        now, before = _row(inp.normal, k), _row(inp.normal_before, k)
        old_stiffness, stiffness, mean_stiffness, _ = _coulomb_spring(inp, law, k)
        last, path = _row(inp.memory, k), _tangential_path(_row(inp.path, k), before, now)
        start_traction = _transported(last, before, now)
        slid_before = inp.memory[k, 3], inp.memory[k, 4], inp.memory[k, 5]
        slid_before = _transported(slid_before, before, now)
        trial = (
            start_traction[0] - mean_stiffness * path[0],
            start_traction[1] - mean_stiffness * path[1],
            start_traction[2] - mean_stiffness * path[2],
        )
        coefficient = law.static
        if law.decay > 0.0:
            velocity = _tangential(_row(inp.velocity, k), now)
            decay = math.exp(-law.decay * math.sqrt(_dot(velocity, velocity)))
            coefficient = law.dynamic + (law.static - law.dynamic) * decay
        # Return mapping to the cone.
        limit, length = coefficient * inp.force[k], math.sqrt(_dot(trial, trial))
        factor = limit / length if length > limit else 1.0
        traction = trial[0] * factor, trial[1] * factor, trial[2] * factor
        work = 0.0
        for c in range(3):
            elastic = 0.0
            if mean_stiffness > 0.0:
                elastic = (start_traction[c] - traction[c]) / mean_stiffness
            work += (start_traction[c] + traction[c]) * (path[c] - elastic)
            out.force[k, c] = out.memory[k, c] = traction[c]
            out.memory[k, 3 + c] = slid_before[c] + path[c]
        stored = _energy(traction, stiffness)
        lost = max(-0.5 * work, 0.0)
        lost += max(_energy(last, old_stiffness) - _energy(last, mean_stiffness), 0.0)
        lost += max(_energy(traction, mean_stiffness) - stored, 0.0)
        out.stiffness[k] = out.memory[k, 6] = stiffness
        out.stored[k], out.lost[k] = stored, lost


@kernel()
def viscous(inp, coefficient, speed, out, start, stop):
    """Write rows start … stop of `out`, a `FrictionOutput`, for −μ F tanh(|v|/v₀) v/|v|.

    `inp` is a `FrictionInput`, μ the `coefficient` and v₀ the `speed`.
    """
    for k in range(start, stop):
        now, before = _row(inp.normal, k), _row(inp.normal_before, k)
        velocity = _tangential(_row(inp.velocity, k), now)
        size = math.sqrt(_dot(velocity, velocity))
        force = coefficient * inp.force[k] * math.tanh(size / speed)
        last = _transported(_row(inp.memory, k), before, now)
        path = _tangential_path(_row(inp.path, k), before, now)
        work = 0.0
        for c in range(3):
            traction = -force * (velocity[c] / size if size > 0.0 else 0.0)
            work += (last[c] + traction) * path[c]
            out.force[k, c] = out.memory[k, c] = traction
        out.stiffness[k] = out.stored[k] = 0.0
        out.lost[k] = max(-0.5 * work, 0.0)


@inner()
def _change_of(changes, k, j):
    """Return direction j of the changes (n, 3, m) of vectors at point k; zero without changes."""
    if changes.shape[0] == 0:
        return 0.0, 0.0, 0.0
    return changes[k, 0, j], changes[k, 1, j], changes[k, 2, j]


@inner()
def _tangential_change(v, dv, normal, dn):
    """Return the change of `_tangential` for changes `dv` of v and `dn` of the normal."""
    normal_part = _dot(v, normal)
    change = _dot(dv, normal) + _dot(v, dn)
    return (
        dv[0] - change * normal[0] - normal_part * dn[0],
        dv[1] - change * normal[1] - normal_part * dn[1],
        dv[2] - change * normal[2] - normal_part * dn[2],
    )


@inner()
def _transported_change(v, dv, before, now, dn):
    """Return the change of `_transported` for changes `dv` of v and `dn` of the normal `now`."""
    total = before[0] + now[0], before[1] + now[1], before[2] + now[2]
    square = _dot(total, total)
    scale = 2.0 / square if square > 0.0 else 0.0
    product = _dot(total, v)
    factor = scale * product
    change = scale * (_dot(dn, v) + _dot(total, dv) - scale * _dot(total, dn) * product)
    rotated = v[0] - factor * total[0], v[1] - factor * total[1], v[2] - factor * total[2]
    d_rotated = (
        dv[0] - change * total[0] - factor * dn[0],
        dv[1] - change * total[1] - factor * dn[1],
        dv[2] - change * total[2] - factor * dn[2],
    )
    return _tangential_change(rotated, d_rotated, now, dn)


@inner()
def _tangential_path_change(path, d_path, before, now, dn):
    """Return the change of `_tangential_path` for changes of the path and of the normal `now`."""
    a = _transported_change(path, d_path, before, now, dn)
    b = _tangential_change(path, d_path, now, dn)
    return 0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1]), 0.5 * (a[2] + b[2])


@inner()
def _speed_change(v, dv, normal, dn):
    """Return the tangential speed and its change, zero at rest, where it has no derivative."""
    tangential = _tangential(v, normal)
    speed = math.sqrt(_dot(tangential, tangential))
    if speed == 0.0:
        return 0.0, 0.0
    return speed, _dot(tangential, _tangential_change(v, dv, normal, dn)) / speed


@kernel()
def coulomb_changes(inp, law, change, out, start, stop):
    """Write rows start … stop of `out` (n, 3, m), the changes of the forces of `coulomb`.

    `change` is a `FrictionChange` of its input in m directions.
    """
    zero, new = (0.0, 0.0, 0.0), scratch(3)
    for k in range(start, stop):
        now, before = _row(inp.normal, k), _row(inp.normal_before, k)
        _, _, mean_stiffness, stiffness_factor = _coulomb_spring(inp, law, k)
        last, full_path = _row(inp.memory, k), _row(inp.path, k)
        start_traction = _transported(last, before, now)
        path = _tangential_path(full_path, before, now)
        trial = (
            start_traction[0] - mean_stiffness * path[0],
            start_traction[1] - mean_stiffness * path[1],
            start_traction[2] - mean_stiffness * path[2],
        )
        velocity, decay_part, coefficient = zero, 0.0, law.static
        if law.decay > 0.0:
            velocity = _row(inp.velocity, k)
            speed = _speed_change(velocity, zero, now, zero)[0]
            decay_part = (law.static - law.dynamic) * math.exp(-law.decay * speed)
            coefficient = law.dynamic + decay_part
        limit, length = coefficient * inp.force[k], math.sqrt(_dot(trial, trial))
        slips = length > limit
        for j in range(out.shape[2]):
            dn, d_full_path = _change_of(change.normal, k, j), _change_of(change.path, k, j)
            d_path = _tangential_path_change(full_path, d_full_path, before, now, dn)
            d_start = _transported_change(last, zero, before, now, dn)
            d_stiffness = stiffness_factor * change.stiffness[k, j]
            product = 0.0
            for c in range(3):
                new[c] = d_start[c] - mean_stiffness * d_path[c] - d_stiffness * path[c]
                product += new[c] * trial[c]
            if slips:
                d_limit = coefficient * change.force[k, j]
                if law.decay > 0.0:
                    dv = _change_of(change.velocity, k, j)
                    d_speed = _speed_change(velocity, dv, now, dn)[1]
                    d_limit -= law.decay * decay_part * d_speed * inp.force[k]
                for c in range(3):
                    unit = trial[c] / length
                    new[c] = (d_limit * unit) + limit / length * (new[c] - product / length * unit)
            for c in range(3):
                out[k, c, j] = new[c]


@kernel()
def viscous_changes(inp, coefficient, speed, change, out, start, stop):
    """Write rows start … stop of `out` (n, 3, m), the changes of the forces of `viscous`.

    `change` is a `FrictionChange` of its input in m directions.
    """
    for k in range(start, stop):
        now, v = _row(inp.normal, k), _row(inp.velocity, k)
        tangential = _tangential(v, now)
        size = math.sqrt(_dot(tangential, tangential))
        tanh = math.tanh(size / speed)
        # tanh(s/v₀)/s, and its derivative by s, over s.
        ratio = tanh / size if size > 0.0 else 1.0 / speed
        ratio_slope = 0.0
        if size > 0.0:
            ratio_slope = ((1.0 - tanh * tanh) / speed - ratio) / (size * size)
        force = coefficient * inp.force[k]
        for j in range(out.shape[2]):
            dn, dv = _change_of(change.normal, k, j), _change_of(change.velocity, k, j)
            d_tangential = _tangential_change(v, dv, now, dn)
            product = _dot(tangential, d_tangential)
            d_factor = coefficient * change.force[k, j] * ratio + force * ratio_slope * product
            for c in range(3):
                out[k, c, j] = -(d_factor * tangential[c] + force * ratio * d_tangential[c])
