"""Find masses, inertias, velocities and a gravity that are probably in another unit."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from contiga.arrays.ordered import length
from contiga.dynamics.deforming import Deforming
from contiga.dynamics.free import Free
from contiga.errors import InputError
from contiga.records import MassProperties
from contiga.rigid.rigid_lanes import MASS
from contiga.simulation.checks.finding import Finding
from contiga.simulation.checks.scene import Scene
from contiga.slaves.slave import own_nodes

# Density of the box around a body, kg/m³: from the lightest foam to more than any metal.
DENSITY_RANGE = (5.0, 2.5e4)
# Radius of gyration over the size of a body: from less than any bar to more than any hoop.
_GYRATION_RANGE = (0.02, 1.5)
# Largest plausible speed, m/s: above those of occupant safety, impact and blast.
_MAX_SPEED = 2e4
# Speed that is refused, m/s: ten times that of any meteor, at which no body is rigid.
_IMPOSSIBLE_SPEED = 1e6
# Largest travel of a free part in the run, over the size of the largest part; then the range of
# gravity, m/s².
_MAX_TRAVEL = 200.0
_MAX_GRAVITY = 300.0
_MIN_GRAVITY = 0.01


def check_masses(scene: Scene) -> Iterator[Finding]:
    """Report masses, inertias, velocities and a gravity that are most likely in another unit.

    Slaves of free nodes with facets or elements are reported as well: nothing holds them together.

    Raises
    ------
    InputError
        A velocity above `_IMPOSSIBLE_SPEED`.
    """
    model, fmt = scene.model, scene.fmt
    g = length(model.gravity)
    metric = g * fmt.si(1, 0, -2)
    if fmt.known and g > 0.0 and not _MIN_GRAVITY < metric < _MAX_GRAVITY:
        earth = 9.80665 / fmt.si(1, 0, -2)
        yield Finding(
            "gravity",
            "world",
            f"gravity is {g:.4g} {fmt.unit('length')}/{fmt.unit('time')}², which is "
            f"{metric:.4g} m/s²",
            f"On earth it is {earth:.4g} in these units",
        )
    system, names = model.mechanism, list(model.bodies)
    for k, i in enumerate(system.free):
        part = model.bodies[names[i]]
        assert isinstance(part.motion, Free)
        mass = float(system.fixed[k, MASS])
        # Compare the mass with that of water in the body's box: orders of magnitude.
        volume = float(np.prod(np.ptp(part.body.bounds(), axis=0)))
        solid = fmt.known and volume > 0.0 and part.body.closed
        if solid and not DENSITY_RANGE[0] < mass / volume * fmt.si(-3, 1, 0) < DENSITY_RANGE[1]:
            water = 1000.0 / fmt.si(-3, 1, 0) * volume
            yield Finding(
                "mass",
                f"body {names[i]}",
                f"its mass is {fmt(mass, 'mass')}, and its box of water would have "
                f"{fmt(water, 'mass')}",
                f"Give mass in {fmt.unit('mass')}, or a density in {fmt.unit('mass')} per "
                f"{fmt.unit('length')}³, and look at the unit of its geometry",
            )
        yield from _check_speed(f"body {names[i]}", part.motion, scene)
        # Radii of gyration that are impossible for a body of this size.
        inertia, mass_given = part.motion.inertia, part.motion.mass
        if inertia is None or not isinstance(mass_given, float | MassProperties):
            continue
        mass = mass_given.mass if isinstance(mass_given, MassProperties) else mass_given
        largest = float(np.sqrt(np.linalg.eigvalsh(inertia) / mass).max())
        if not _GYRATION_RANGE[0] * part.body.size < largest < _GYRATION_RANGE[1] * part.body.size:
            yield Finding(
                "inertia",
                f"body {names[i]}",
                f"its inertia is that of {fmt(mass, 'mass')} at {fmt(largest)} from its "
                f"centre, in a body that is {fmt(part.body.size)} large",
                f"Give inertias in {fmt.unit('mass')}·{fmt.unit('length')}², about the centre of "
                "mass",
            )
    for name, slave in model.slaves.items():
        if isinstance(slave.motion, Free):
            mesh = slave.slave
            joined = ", ".join(f"{count} {kind}" for kind, count in mesh.cells.items())
            if not joined and mesh.facets is not None:
                joined = f"{len(mesh.facets)} facets"
            if joined:
                yield Finding(
                    "dust",
                    f"slave {name}",
                    f"its {len(own_nodes(mesh))} nodes are free masses of their own: nothing holds "
                    f"the {joined} together that join them",
                    'Take motion = { kind = "attached" } to a body for what is rigid, "fixed" for '
                    "what gives way by the law of its contact, or points without facets for dust",
                )
        if isinstance(slave.motion, Free | Deforming):
            yield from _check_speed(f"slave {name}", slave.motion, scene)


def _check_speed(where: str, motion: Free | Deforming, scene: Scene) -> Iterator[Finding]:
    """Report a start velocity above `_MAX_SPEED`, or too large for the size of the model.

    A part may not go farther in the run than `_MAX_TRAVEL` times the largest side of any contact.
    The largest is meant if nodes have different ones. Raises `InputError` for an impossible one.
    """
    fmt, stepping = scene.fmt, scene.model.stepping
    speed = float(np.sqrt(np.square(np.atleast_2d(motion.velocity)).sum(axis=1)).max())
    starts = f"it starts at {fmt(speed, 'velocity')}"
    give = f"Give velocities in {fmt.unit('velocity')}" if fmt.known else "Look at its unit"
    if fmt.known and speed * fmt.si(1, 0, -1) > _IMPOSSIBLE_SPEED:
        raise InputError(
            f"it would start at {speed * fmt.si(1, 0, -1):.3g} m/s",
            where=where,
            found=fmt(speed, "velocity"),
            allowed=f"up to {_IMPOSSIBLE_SPEED:g} m/s, from {_MAX_SPEED:g} m/s with a warning",
            remedy=give,
        )
    if fmt.known and speed * fmt.si(1, 0, -1) > _MAX_SPEED:
        speeds = f"{starts}, which is {speed * fmt.si(1, 0, -1):.3g} m/s"
        yield Finding("velocity", where, speeds, give)
        return
    largest = max((max(pair.body.size, pair.slave_size) for pair in scene.pairs), default=np.inf)
    travel = speed * (stepping.end - stepping.start)
    if travel > _MAX_TRAVEL * largest:
        yield Finding(
            "velocity",
            where,
            f"{starts} and would go {fmt(travel)} until the end, {travel / largest:.3g} times the "
            "size of the largest part",
            f"{give}, and look at that of the end",
        )
