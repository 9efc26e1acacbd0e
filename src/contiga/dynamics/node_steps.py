"""Steps of nodes that forces move: see `kernels/nodes_nb`."""

from __future__ import annotations

from math import ceil

import numpy as np
from numpy.typing import NDArray

from contiga.arrays.layout import locked
from contiga.arrays.threads import run_ranges
from contiga.dynamics.kernels import nodes_nb
from contiga.dynamics.node_records import Acting, Course, Drifted, Kick, Kicked, Masses
from contiga.dynamics.nodes import Pushes
from contiga.records import FloatArray

NODES = 16384
"""Below which a second thread does not pay; a multiple of the nodes of a block."""
NOTHING = np.zeros((0, 3))
"""Of what does not act."""


def masses_of(mass: FloatArray, held: NDArray[np.bool_], led: NDArray[np.bool_]) -> Masses:
    """Masses (n,) with the ways (n, 3) that no force moves and that motions or bodies have."""
    none, given = (locked(some if some.any() else some[:0]) for some in (held, led))
    return Masses(locked(mass), none, given)


def acting(
    contacts: Pushes,
    elements: FloatArray,
    gravity: FloatArray,
    loads: FloatArray = NOTHING,
    drag: FloatArray = NOTHING,
) -> Acting:
    """Forces, of all but contacts (n, 3), and gravity (3,), as kernels take them."""
    others: list[FloatArray] = [contacts.forces, elements, loads, drag, gravity]
    return Acting(locked(contacts.rows), *map(locked, others))


def accelerated(masses: Masses, forces: Acting) -> FloatArray:
    """(n, 3) accelerations, zero where nodes are held."""
    out = np.empty(forces.elements.shape)
    run_ranges(nodes_nb.accelerate, len(out), NODES, masses, forces, out)
    return out


def drifted(
    masses: Masses, forces: Acting, points: FloatArray, velocities: FloatArray, dt: float
) -> Drifted:
    """Nodes a step on from points and velocities (n, 3)."""
    shape = points.shape
    out = Drifted(np.empty(shape), np.empty(shape), np.empty(shape))
    last = Course(locked(points), locked(velocities))
    run_ranges(nodes_nb.drift, len(points), NODES, masses, forces, last, dt, out)
    return out


def kicked(
    masses: Masses, forces: Acting, speeds: tuple[FloatArray, FloatArray], dt: float, damping: float
) -> Kicked:
    """The end of a step, from the velocities (n, 3) of its middle and those foreseen."""
    half, foreseen = map(locked, speeds)
    out = Kicked(np.empty(half.shape), np.empty(_blocks(half)))
    given = Kick(half, foreseen, dt, damping)
    run_ranges(nodes_nb.kick, len(half), NODES, masses, forces, given, out)
    return out


def kinetic(masses: Masses, velocities: FloatArray) -> float:
    """½ Σ m v² of velocities (n, 3) of nodes that forces move."""
    out = np.empty(_blocks(velocities))
    run_ranges(nodes_nb.kinetic, len(velocities), NODES, masses, locked(velocities), out)
    return float(out.sum())


def _blocks(velocities: FloatArray) -> int:
    return ceil(velocities.size / nodes_nb.BLOCK)
