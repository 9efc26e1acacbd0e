"""Nodes of masses, one step of a leapfrog: half a kick, a drift, half a kick.

In one pass over the nodes, and in stages over blocks of them, as numbers in a row: so they become
vector code, and make no arrays on the way.
"""

from __future__ import annotations

from contiga.arrays.kernels.sort_nb import count_below
from contiga.jit import inner, kernel
from contiga.jit.scratch import scratch, zero_scratch

BLOCK = 384
"""Numbers at a time, of 128 nodes, which energies are sums of."""


@inner(linked=False)
def _add(forces, first, out):
    """Add numbers of (n, 3) from `first` on, where there are any."""
    if forces.shape[0] > 0:
        some = forces.reshape(-1)[first : first + out.shape[0]]
        for k in range(out.shape[0]):
            out[k] += some[k]


@inner(linked=False)
def _add_listed(listed, j, first, out):
    """Add the forces listed from place j on to numbers from `first` on; returns the next place."""
    rows, forces = listed
    node, past = first // 3, (first + out.shape[0]) // 3
    while j < rows.shape[0] and rows[j] < past:
        k = 3 * (rows[j] - node)
        for i in range(3):
            out[k + i] += forces[j, i]
        j += 1
    return j


@inner(linked=False)
def _put(ways, first, values, out):
    """Put values into numbers from `first` on where `ways` (n, 3) says so, if there are any."""
    if ways.shape[0] > 0:
        some = ways.reshape(-1)[first : first + out.shape[0]]
        for k in range(out.shape[0]):
            if some[k]:
                out[k] = values[k]


@inner(linked=False)
def _per_mass(mass, gravity, out):
    """Accelerations of forces, in their place."""
    for k in range(out.shape[0]):
        out[k] = out[k] / mass[k] + gravity[k]


@inner(linked=False)
def _three_of_each(mass, out):
    """Masses of nodes, for each of their numbers."""
    for k in range(out.shape[0] // 3):
        out[3 * k] = out[3 * k + 1] = out[3 * k + 2] = mass[k]


@inner()
def _accelerations(masses, acting, place, rows, out):
    """Write the accelerations from number `first` on, place = (first, its row in the list), and
    return the next row.

    `rows` are gravity, again and again, zeros, and what masses are written into.
    """
    first, j = place
    out[:] = 0.0
    _add(acting.elements, first, out)
    j = _add_listed((acting.rows, acting.contacts), j, first, out)
    _add(acting.everywhere, first, out)
    _add(acting.loads, first, out)
    _add(acting.drag, first, out)
    gravity, zeros, mass = rows
    _three_of_each(masses.mass[first // 3 :], mass[: out.shape[0]])
    _per_mass(mass, gravity, out)
    _put(masses.held, first, zeros, out)
    return j


@inner()
def _in_a_row(gravity, out):
    """Three numbers again and again."""
    for k in range(out.shape[0]):
        out[k] = gravity[k % 3]


@inner(linked=False)
def _moved(last, kick, dt, half, points):
    """Velocities of the middle of a step, and points at its end."""
    before, speed = last
    for k in range(kick.shape[0]):
        half[k] = speed[k] + 0.5 * dt * kick[k]
    for k in range(kick.shape[0]):
        points[k] = before[k] + dt * half[k]


@inner(linked=False)
def _foreseen(before, kick, dt, velocities):
    """Velocities that half a kick more gives."""
    for k in range(kick.shape[0]):
        velocities[k] = before[k] + dt * kick[k]


@inner(linked=False)
def _kicked(half, dt, kept, kick):
    """Velocities at the end of a step, in place of accelerations."""
    for k in range(kick.shape[0]):
        kick[k] = (half[k] + 0.5 * dt * kick[k]) * kept


@inner(linked=False)
def _products(half, velocities, mass, square):
    """m v₋·v₊, number by number: v₊ is as far beyond the velocity at the end as v₋ before it."""
    for k in range(square.shape[0]):
        square[k] = mass[k] * half[k] * (2.0 * velocities[k] - half[k])


@inner(linked=False)
def _total(values):
    """The sum of a block, which is used up: halves are added until there are three numbers."""
    width = BLOCK // 2
    while width >= 3:
        for k in range(width):
            values[k] += values[width + k]
        width //= 2
    return values[0] + values[1] + values[2]


@inner()
def _energy(led, first, speeds, rows, square):
    """½ Σ m v₋·v₊ of what forces move, of numbers from `first` on; `square` (BLOCK,) is used up."""
    half, velocities = speeds
    n = half.shape[0]
    _products(half, velocities, rows[2], square[:n])
    _put(led, first, rows[1], square[:n])
    square[n:] = 0.0
    return 0.5 * _total(square)


@kernel()
def accelerate(masses, acting, out, start, stop):
    """Write the accelerations (n, 3) of nodes start … stop."""
    rows, flat = (scratch(BLOCK), zero_scratch(BLOCK), scratch(BLOCK)), out.reshape(-1)
    _in_a_row(acting.gravity, rows[0])
    j = count_below(acting.rows, start)
    for first in range(3 * start, 3 * stop, BLOCK):
        some = flat[first : min(first + BLOCK, 3 * stop)]
        j = _accelerations(masses, acting, (first, j), rows, some)


@kernel()
def drift(masses, acting, last, dt, out, start, stop):
    """Nodes start … stop a step on, the velocities of its middle and those foreseen at its end."""
    rows, kicks = (scratch(BLOCK), zero_scratch(BLOCK), scratch(BLOCK)), scratch(BLOCK)
    _in_a_row(acting.gravity, rows[0])
    j = count_below(acting.rows, start)
    points, velocities = out.points.reshape(-1), out.velocities.reshape(-1)
    before, speed = last.points.reshape(-1), last.velocities.reshape(-1)
    halves = out.half.reshape(-1)
    for first in range(3 * start, 3 * stop, BLOCK):
        past = min(first + BLOCK, 3 * stop)
        kick = kicks[: past - first]
        j = _accelerations(masses, acting, (first, j), rows, kick)
        some = before[first:past], speed[first:past]
        _moved(some, kick, dt, halves[first:past], points[first:past])
        _foreseen(speed[first:past], kick, dt, velocities[first:past])


@kernel()
def kick(masses, acting, given, out, start, stop):
    """Velocities of nodes start … stop at the end of a step, and kinetic energies of blocks.

    Damping acts by the velocity that it leaves, so that it is of second order and stable.
    """
    rows, squares = (scratch(BLOCK), zero_scratch(BLOCK), scratch(BLOCK)), scratch(BLOCK)
    _in_a_row(acting.gravity, rows[0])
    j = count_below(acting.rows, start)
    kept = 1.0 / (1.0 + 0.5 * given.dt * given.damping)
    halves, foreseen = given.half.reshape(-1), given.foreseen.reshape(-1)
    velocities = out.velocities.reshape(-1)
    for first in range(3 * start, 3 * stop, BLOCK):
        past = min(first + BLOCK, 3 * stop)
        speed, half = velocities[first:past], halves[first:past]
        j = _accelerations(masses, acting, (first, j), rows, speed)
        _kicked(half, given.dt, kept, speed)
        _put(masses.led, first, foreseen[first:past], speed)
        out.energy[first // BLOCK] = _energy(masses.led, first, (half, speed), rows, squares)


@kernel()
def kinetic(masses, velocities, out, start, stop):
    """½ Σ m v² of blocks of nodes start … stop, of what forces move."""
    squares, mass, flat = scratch(BLOCK), scratch(BLOCK), velocities.reshape(-1)
    rows = mass, zero_scratch(BLOCK), mass
    for first in range(3 * start, 3 * stop, BLOCK):
        past = min(first + BLOCK, 3 * stop)
        speed = flat[first:past]
        _three_of_each(masses.mass[first // 3 :], mass[: past - first])
        out[first // BLOCK] = _energy(masses.led, first, (speed, speed), rows, squares)
