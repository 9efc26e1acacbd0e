"""Stops a run whose elements go unstable, with the reason, before its numbers overflow."""

from __future__ import annotations

import numpy as np

from contiga.arrays.ordered import length
from contiga.errors import RunError
from contiga.simulation.critical import limit_of
from contiga.simulation.model import Model
from contiga.simulation.system_state import SystemState
from contiga.slaves.sampling import more_points
from contiga.slaves.skin import facet_width

GAINED = 100.0
"""Times the energy that came in: near the critical step what is stable holds some times as much."""
SHAKEN = 1e-3
"""Part of the size of a slave that its fastest node goes in a step before anything is said: the
energies of what hardly moves are rounding."""


def check_stable(model: Model, state: SystemState) -> None:
    """Refuse to go on where elements have more energy than ever came in.

    Raises
    ------
    RunError
        Names the slave, the time, its fastest node and where that is, and what to do.
    """
    energy = state.energy
    gained, came = -energy.error, max(energy.initial + energy.external, 0.0)
    joined = model.mechanism.joined
    for name, nodes in joined.items():
        # What counts as their kinetic energy is kept by unstable steps, too.
        slave = state.slaves[name]
        gained += nodes.shaken(slave) - nodes.energy(slave).kinetic
    if gained <= GAINED * came:
        return
    for name in joined:
        slave = state.slaves[name]
        speeds = np.sqrt(np.square(slave.velocities).sum(axis=1))
        node = int(np.argmax(np.where(np.isfinite(speeds), speeds, np.inf)))
        size = length(np.ptp(model.slaves[name].slave.points, axis=0))
        if speeds[node] * state.step <= SHAKEN * size:
            continue
        place = ", ".join(f"{x:.6g}" for x in slave.points[node])
        raise RunError(
            f"t = {state.time:g}: slave {name!r} is unstable: {gained:.4g} of energy came from "
            f"nothing, and {came:.4g} from outside. Node {node} at ({place}) goes at "
            f"{speeds[node]:.4g}. {remedy(model, state, name)}"
        )


def remedy(model: Model, state: SystemState, slave: str) -> str:
    """Advice about a slave that is unstable."""
    critical = limit_of(model, state).critical
    if state.step > critical:
        return f'Take steps below {0.9 * critical:.3g}, or step = "auto"'
    mesh = model.slaves[slave].slave
    width = np.inf if mesh.facets is None else facet_width(mesh.points, mesh.facets)
    for part in model.contacts:
        deep = state.contacts[part.name].max_penetration
        if part.slave == slave and deep > width:
            return (
                f"Its facets, {width:.4g} wide, are too coarse for {part.master}, in which points "
                f"of theirs lie {deep:.4g} deep: mesh it finer there"
                f"{more_points(part.contact.quadrature)}"
            )
    return "Look at its material, at its contacts and at the units; shorter steps show which it is"
