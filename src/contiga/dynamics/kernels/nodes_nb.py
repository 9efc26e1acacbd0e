"""Nodes with masses, one step of a leapfrog: half a kick, a drift, half a kick.

One pass over the nodes goes through all stages block by block, with the coordinates of a block as
numbers in a row. So the stages become vector code, and no intermediate arrays are made.
"""

from __future__ import annotations

from contiga.arrays.kernels.sort_nb import count_below
from contiga.jit import inner, kernel
from contiga.jit.scratch import scratch, zero_scratch

BLOCK = 384
"""Numbers in a block, of 128 nodes; each block has one sum of energies."""


@inner(linked=False)
def _add(forces, first, out):
    """Add a block of forces (n, 3) that begins at number `first`; (0, 3) stands for zeros."""
    if forces.shape[0] > 0:
        block = forces.reshape(-1)[first : first + out.shape[0]]
        for k in range(out.shape[0]):
            out[k] += block[k]


@inner(linked=False)
def _add_listed(listed, j, first, out):
    """Add listed forces to a block that begins at number `first`, and return the next place.

    `listed` are nodes (k,), ascending, and forces (k, 3); place j is the first of them to be added,
    and the place returned is that of the first node beyond the block.
    """
    rows, forces = listed
    node, end = first // 3, (first + out.shape[0]) // 3
    while j < rows.shape[0] and rows[j] < end:
        k = 3 * (rows[j] - node)
        for i in range(3):
            out[k + i] += forces[j, i]
        j += 1
    return j


@inner(linked=False)
def _overwrite(mask, first, values, out):
    """Overwrite a block, which begins at number `first`, by values where `mask` (n, 3) is true.

    A mask (0, 3) is false everywhere.
    """
    if mask.shape[0] > 0:
        block = mask.reshape(-1)[first : first + out.shape[0]]
        for k in range(out.shape[0]):
            if block[k]:
                out[k] = values[k]


@inner(linked=False)
def _divide_by_mass(mass, gravity, out):
    """Turn forces into accelerations, in place."""
    for k in range(out.shape[0]):
        out[k] = out[k] / mass[k] + gravity[k]


@inner(linked=False)
def _repeat_masses(mass, out):
    """Write the mass of each node three times, once for each of its coordinates."""
    for k in range(out.shape[0] // 3):
        out[3 * k] = out[3 * k + 1] = out[3 * k + 2] = mass[k]


@inner()
def _repeat_vector(vector, out):
    """Write the three numbers of a vector again and again."""
    for k in range(out.shape[0]):
        out[k] = vector[k % 3]


@inner()
def _accelerations(masses, acting, place, rows, out):
    """Write the accelerations of a block, and return the next place in the list of contact forces.

    `place` is the first number of the block and the place in the list; `rows` (BLOCK,) each are
    repeated gravity, zeros, and an array into which the masses are written. Held numbers get 0.
    """
    first, j = place
    out[:] = 0.0
    _add(acting.elements, first, out)
    j = _add_listed((acting.rows, acting.contacts), j, first, out)
    _add(acting.everywhere, first, out)
    _add(acting.loads, first, out)
    _add(acting.drag, first, out)
    gravity, zeros, mass = rows
    _repeat_masses(masses.mass[first // 3 :], mass[: out.shape[0]])
    _divide_by_mass(mass, gravity, out)
    _overwrite(masses.held, first, zeros, out)
    return j


@inner(linked=False)
def _drift_points(last, accelerations, dt, half, points):
    """Write the mid-step velocities, and the points at the end of the step."""
    points_before, velocities_before = last
    for k in range(accelerations.shape[0]):
        half[k] = velocities_before[k] + 0.5 * dt * accelerations[k]
    for k in range(accelerations.shape[0]):
        points[k] = points_before[k] + dt * half[k]


@inner(linked=False)
def _predict_velocities(velocities_before, accelerations, dt, velocities):
    """Write the velocities at the end of a step by the accelerations at its start."""
    for k in range(accelerations.shape[0]):
        velocities[k] = velocities_before[k] + dt * accelerations[k]


@inner(linked=False)
def _kick_velocities(half, dt, damping_factor, out):
    """Write the velocities at the end of a step in place of the accelerations there."""
    for k in range(out.shape[0]):
        out[k] = (half[k] + 0.5 * dt * out[k]) * damping_factor


@inner(linked=False)
def _energy_terms(half, velocities, mass, out):
    """Write m v₋·v₊ for each number, with v₋ `half` and v₊ its extrapolation by `velocities`."""
    for k in range(out.shape[0]):
        out[k] = mass[k] * half[k] * (2.0 * velocities[k] - half[k])


@inner(linked=False)
def _block_sum(values):
    """Return the sum of a block by pairwise halving down to three numbers; overwrites it."""
    width = BLOCK // 2
    while width >= 3:
        for k in range(width):
            values[k] += values[width + k]
        width //= 2
    return values[0] + values[1] + values[2]


@inner()
def _energy(driven, first, velocities, rows, terms):
    """Return ½ Σ m v₋·v₊ of a block without driven numbers; overwrites `terms` (BLOCK,).

    `velocities` are those at mid-step and at the end; v₊ is extrapolated from them.
    """
    half, end = velocities
    n = half.shape[0]
    _energy_terms(half, end, rows[2], terms[:n])
    _overwrite(driven, first, rows[1], terms[:n])
    terms[n:] = 0.0
    return 0.5 * _block_sum(terms)


@kernel()
def accelerate(masses, acting, out, start, stop):
    """Write the accelerations of nodes start … stop into `out` (n, 3); 0 where held."""
    rows, flat = (scratch(BLOCK), zero_scratch(BLOCK), scratch(BLOCK)), out.reshape(-1)
    _repeat_vector(acting.gravity, rows[0])
    j = count_below(acting.rows, start)
    for first in range(3 * start, 3 * stop, BLOCK):
        block = flat[first : min(first + BLOCK, 3 * stop)]
        j = _accelerations(masses, acting, (first, j), rows, block)


@kernel()
def drift(masses, acting, last, dt, out, start, stop):
    """Write points, mid-step velocities and predicted velocities of nodes start … stop.

    `last` has points and velocities before the step. Predicted is v + dt a, with a at the start.
    Held degrees of freedom, driven ones included, are not accelerated: they drift at the velocity
    before the step.
    """
    rows, block = (scratch(BLOCK), zero_scratch(BLOCK), scratch(BLOCK)), scratch(BLOCK)
    _repeat_vector(acting.gravity, rows[0])
    j = count_below(acting.rows, start)
    points, velocities = out.points.reshape(-1), out.velocities.reshape(-1)
    points_before, velocities_before = last.points.reshape(-1), last.velocities.reshape(-1)
    halves = out.half.reshape(-1)
    for first in range(3 * start, 3 * stop, BLOCK):
        end = min(first + BLOCK, 3 * stop)
        accelerations = block[: end - first]
        j = _accelerations(masses, acting, (first, j), rows, accelerations)
        before = points_before[first:end], velocities_before[first:end]
        _drift_points(before, accelerations, dt, halves[first:end], points[first:end])
        _predict_velocities(before[1], accelerations, dt, velocities[first:end])


@kernel()
def kick(masses, acting, mid, out, start, stop):
    """Write the velocities of nodes start … stop at the end of a step, and kinetic energies.

    `out.energy` has one sum ½ Σ m v₋·v₊ for each BLOCK of numbers, three a node; see `_energy`.
    `mid` is a `Kick`. Damping is implicit, by the velocity at the end, so that it is of second
    order and stable. Driven degrees of freedom keep their predicted velocity, and have no energy.
    """
    rows, terms = (scratch(BLOCK), zero_scratch(BLOCK), scratch(BLOCK)), scratch(BLOCK)
    _repeat_vector(acting.gravity, rows[0])
    j = count_below(acting.rows, start)
    damping_factor = 1.0 / (1.0 + 0.5 * mid.dt * mid.damping)
    halves, predicted = mid.half.reshape(-1), mid.predicted.reshape(-1)
    velocities = out.velocities.reshape(-1)
    for first in range(3 * start, 3 * stop, BLOCK):
        end = min(first + BLOCK, 3 * stop)
        block, half = velocities[first:end], halves[first:end]
        j = _accelerations(masses, acting, (first, j), rows, block)
        _kick_velocities(half, mid.dt, damping_factor, block)
        _overwrite(masses.driven, first, predicted[first:end], block)
        out.energy[first // BLOCK] = _energy(masses.driven, first, (half, block), rows, terms)


@kernel()
def kinetic(masses, velocities, out, start, stop):
    """Write ½ Σ m v² of nodes start … stop without driven degrees of freedom.

    `out` has one sum for each BLOCK of numbers, three a node.
    """
    terms, mass, flat = scratch(BLOCK), scratch(BLOCK), velocities.reshape(-1)
    rows = mass, zero_scratch(BLOCK), mass
    for first in range(3 * start, 3 * stop, BLOCK):
        end = min(first + BLOCK, 3 * stop)
        block = flat[first:end]
        _repeat_masses(masses.mass[first // 3 :], mass[: end - first])
        out[first // BLOCK] = _energy(masses.driven, first, (block, block), rows, terms)
