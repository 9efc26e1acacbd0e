"""Friction of points in contact, one pass over them: the return to Coulomb's cone, and viscous.

The formulas are those of `contiga.laws.friction`, which says where they come from. Each point is
worked out by itself, so that the bits depend on no other point and on no number of threads. The
derivatives go along with directions: a change of the input gives that of the forces.
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
    """Return the part of `v` in the plane across the unit `normal`."""
    along = _dot(v, normal)
    return v[0] - along * normal[0], v[1] - along * normal[1], v[2] - along * normal[2]


@inner()
def _carried(v, before, now):
    """Turn `v` by the smallest rotation that takes the unit normal `before` to `now`.

    For vectors across the old normal that is the reflection in the plane across the sum of both,
    which keeps lengths to rounding. Where the normals are opposite there is no smallest rotation:
    the vectors lie in the new plane already.
    """
    both = before[0] + now[0], before[1] + now[1], before[2] + now[2]
    square = _dot(both, both)
    part = (2.0 / square if square > 0.0 else 0.0) * _dot(both, v)
    turned = v[0] - part * both[0], v[1] - part * both[1], v[2] - part * both[2]
    return _tangential(turned, now)  # rounding must not leave the plane step by step


@inner()
def _slid(path, before, now):
    """Return the tangential part of a step's path: the mean of those in the planes at its two ends.

    One plane alone would see a way back as another than the way there where the normal turns while
    the point goes deeper: sticking points would creep, and the work be of first order.
    """
    a, b = _carried(path, before, now), _tangential(path, now)
    return 0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1]), 0.5 * (a[2] + b[2])


@inner()
def _energy(traction, stiffness):
    """Return the spring energy t²/(2 k), zero without a spring."""
    return 0.5 * _dot(traction, traction) / stiffness if stiffness > 0.0 else 0.0


@kernel()
def coulomb(inp, law, out, start, stop):
    """Fill the rows start … stop of `out`, a `FrictionOutput`; `inp` is a `FrictionInput`, `law`
    are `CoulombNumbers`."""
    for k in range(start, stop):
        now, before = _row(inp.normal, k), _row(inp.normal_before, k)
        last, kept = _row(inp.memory, k), inp.memory[k, 6]
        given = max(inp.stiffness[k], 0.0)
        if law.stiffness > 0.0:
            given = law.stiffness * (inp.area[k] if law.per_area else 1.0)
        stiffness = max(kept, given)
        pulled = 0.5 * (kept + stiffness) if kept > 0.0 else stiffness
        carried, path = _carried(last, before, now), _slid(_row(inp.path, k), before, now)
        slid_before = inp.memory[k, 3], inp.memory[k, 4], inp.memory[k, 5]
        slid_before = _carried(slid_before, before, now)
        trial = (
            carried[0] - pulled * path[0],
            carried[1] - pulled * path[1],
            carried[2] - pulled * path[2],
        )
        coefficient = law.static
        if law.decay > 0.0:
            velocity = _tangential(_row(inp.velocity, k), now)
            fallen = math.exp(-law.decay * math.sqrt(_dot(velocity, velocity)))
            coefficient = law.dynamic + (law.static - law.dynamic) * fallen
        # Back to the cone, where the spring pulls more than that.
        limit, length = coefficient * inp.force[k], math.sqrt(_dot(trial, trial))
        factor = limit / length if length > limit else 1.0
        traction = trial[0] * factor, trial[1] * factor, trial[2] * factor
        work = 0.0
        for c in range(3):
            slid = path[c] - ((carried[c] - traction[c]) / pulled if pulled > 0.0 else 0.0)
            work += (carried[c] + traction[c]) * slid
            out.force[k, c] = out.memory[k, c] = traction[c]
            out.memory[k, 3 + c] = slid_before[c] + path[c]
        stored = _energy(traction, stiffness)
        lost = max(-0.5 * work, 0.0)
        lost += max(_energy(last, kept) - _energy(last, pulled), 0.0)
        lost += max(_energy(traction, pulled) - stored, 0.0)
        out.stiffness[k] = out.memory[k, 6] = stiffness
        out.stored[k], out.lost[k] = stored, lost


@kernel()
def viscous(inp, coefficient, speed, out, start, stop):
    """Fill the rows start … stop of `out`, a `FrictionOutput`, for −μ F tanh(|v|/v₀) v/|v|; `inp`
    is a `FrictionInput`, μ the `coefficient` and v₀ the `speed`."""
    for k in range(start, stop):
        now, before = _row(inp.normal, k), _row(inp.normal_before, k)
        velocity = _tangential(_row(inp.velocity, k), now)
        size = math.sqrt(_dot(velocity, velocity))
        force = coefficient * inp.force[k] * math.tanh(size / speed)
        last, path = (
            _carried(_row(inp.memory, k), before, now),
            _slid(_row(inp.path, k), before, now),
        )
        work = 0.0
        for c in range(3):
            traction = -force * (velocity[c] / size if size > 0.0 else 0.0)
            work += (last[c] + traction) * path[c]
            out.force[k, c] = out.memory[k, c] = traction
        out.stiffness[k] = out.stored[k] = 0.0
        out.lost[k] = max(-0.5 * work, 0.0)


@inner()
def _with(changes, k, j):
    """Return direction j of the changes (n, 3, m) of vectors at point k; zero without changes."""
    if changes.shape[0] == 0:
        return 0.0, 0.0, 0.0
    return changes[k, 0, j], changes[k, 1, j], changes[k, 2, j]


@inner()
def _tangential_with(v, dv, normal, turn):
    """Return the change of `_tangential` with v by `dv` and with the normal by `turn`."""
    along = _dot(v, normal)
    more = _dot(dv, normal) + _dot(v, turn)
    return (
        dv[0] - more * normal[0] - along * turn[0],
        dv[1] - more * normal[1] - along * turn[1],
        dv[2] - more * normal[2] - along * turn[2],
    )


@inner()
def _carried_with(v, dv, before, now, turn):
    """Return the change of `_carried` with v by `dv` and with the normal `now` by `turn`."""
    both = before[0] + now[0], before[1] + now[1], before[2] + now[2]
    square = _dot(both, both)
    scale = 2.0 / square if square > 0.0 else 0.0
    along = _dot(both, v)
    part = scale * along
    more = scale * (_dot(turn, v) + _dot(both, dv) - scale * _dot(both, turn) * along)
    turned = v[0] - part * both[0], v[1] - part * both[1], v[2] - part * both[2]
    change = (
        dv[0] - more * both[0] - part * turn[0],
        dv[1] - more * both[1] - part * turn[1],
        dv[2] - more * both[2] - part * turn[2],
    )
    return _tangential_with(turned, change, now, turn)


@inner()
def _slid_with(path, step, before, now, turn):
    """Return the change of `_slid` with the path by `step` and with the normal `now` by `turn`."""
    a = _carried_with(path, step, before, now, turn)
    b = _tangential_with(path, step, now, turn)
    return 0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1]), 0.5 * (a[2] + b[2])


@inner()
def _speed_with(v, dv, normal, turn):
    """Return the speed across a normal and its change, zero at rest, where it has no derivative."""
    across = _tangential(v, normal)
    speed = math.sqrt(_dot(across, across))
    if speed == 0.0:
        return 0.0, 0.0
    return speed, _dot(across, _tangential_with(v, dv, normal, turn)) / speed


@kernel()
def coulomb_changes(inp, law, change, out, start, stop):
    """Fill the rows start … stop of `out` (n, 3, m), the changes of the forces of `coulomb` with
    its input: `change` is a `FrictionChange` in m directions."""
    none, new = (0.0, 0.0, 0.0), scratch(3)
    for k in range(start, stop):
        now, before = _row(inp.normal, k), _row(inp.normal_before, k)
        last, kept, given = _row(inp.memory, k), inp.memory[k, 6], max(inp.stiffness[k], 0.0)
        if law.stiffness > 0.0:
            given = law.stiffness * (inp.area[k] if law.per_area else 1.0)
        grows = 0.0
        if given > kept and law.stiffness == 0.0:
            grows = 0.5 if kept > 0.0 else 1.0
        stiffness = max(kept, given)
        pulled = 0.5 * (kept + stiffness) if kept > 0.0 else stiffness
        way = _row(inp.path, k)
        carried, path = _carried(last, before, now), _slid(way, before, now)
        trial = (
            carried[0] - pulled * path[0],
            carried[1] - pulled * path[1],
            carried[2] - pulled * path[2],
        )
        velocity, fallen, coefficient = none, 0.0, law.static
        if law.decay > 0.0:
            velocity = _row(inp.velocity, k)
            speed = _speed_with(velocity, none, now, none)[0]
            fallen = (law.static - law.dynamic) * math.exp(-law.decay * speed)
            coefficient = law.dynamic + fallen
        limit, length = coefficient * inp.force[k], math.sqrt(_dot(trial, trial))
        slips = length > limit
        for j in range(out.shape[2]):
            turn = _with(change.normal, k, j)
            slid = _slid_with(way, _with(change.path, k, j), before, now, turn)
            moved = _carried_with(last, none, before, now, turn)
            more = grows * change.stiffness[k, j]
            along = 0.0
            for c in range(3):
                new[c] = moved[c] - pulled * slid[c] - more * path[c]
                along += new[c] * trial[c]
            if slips:
                grown = coefficient * change.force[k, j]
                if law.decay > 0.0:
                    dv = _with(change.velocity, k, j)
                    faster = _speed_with(velocity, dv, now, turn)[1]
                    grown -= law.decay * fallen * faster * inp.force[k]
                for c in range(3):
                    part = trial[c] / length
                    new[c] = (grown * part) + limit / length * (new[c] - along / length * part)
            for c in range(3):
                out[k, c, j] = new[c]


@kernel()
def viscous_changes(inp, coefficient, speed, change, out, start, stop):
    """Fill the rows start … stop of `out` (n, 3, m), the changes of the forces of `viscous` with
    its input: `change` is a `FrictionChange` in m directions."""
    for k in range(start, stop):
        now, v = _row(inp.normal, k), _row(inp.velocity, k)
        across = _tangential(v, now)
        size = math.sqrt(_dot(across, across))
        share = math.tanh(size / speed)
        # tanh(s/v₀)/s, and how it changes with s, over s.
        over = share / size if size > 0.0 else 1.0 / speed
        bend = 0.0
        if size > 0.0:
            bend = ((1.0 - share * share) / speed - over) / (size * size)
        force = coefficient * inp.force[k]
        for j in range(out.shape[2]):
            turn, dv = _with(change.normal, k, j), _with(change.velocity, k, j)
            new = _tangential_with(v, dv, now, turn)
            faster = _dot(across, new)
            grown = coefficient * change.force[k, j] * over + force * bend * faster
            for c in range(3):
                out[k, c, j] = -(grown * across[c] + force * over * new[c])
