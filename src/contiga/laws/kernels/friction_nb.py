"""Friction of points in contact, one pass over them: the return to Coulomb's cone, and viscous.

The formulas are those of `contiga.laws.friction`, which says where they come from. Each point is
worked out by itself, so that the bits depend on no other point and on no number of threads.
"""

from __future__ import annotations

import math

from contiga.jit import inner, kernel


@inner()
def _row(rows, k):
    return rows[k, 0], rows[k, 1], rows[k, 2]


@inner()
def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@inner()
def _tangential(v, normal):
    """The part of `v` in the plane across the unit `normal`."""
    along = _dot(v, normal)
    return v[0] - along * normal[0], v[1] - along * normal[1], v[2] - along * normal[2]


@inner()
def _carried(v, before, now):
    """`v` turned by the smallest rotation that takes the unit normal `before` to `now`.

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
    """The tangential part of a step's path: the mean of what the planes at its two ends see.

    One plane alone would see a way back as another than the way there where the normal turns while
    the point goes deeper: sticking points would creep, and the work be of first order.
    """
    a, b = _carried(path, before, now), _tangential(path, now)
    return 0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1]), 0.5 * (a[2] + b[2])


@inner()
def _energy(traction, stiffness):
    """t²/(2 k), zero without a spring."""
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
