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

# kg/m³ of the box around a body: from the lightest foam to more than any metal.
DENSITIES = (5.0, 2.5e4)
# Radius of gyration over the size of a body: more than any hoop of it has, less than any bar.
_GYRATION = (0.02, 1.5)
# m/s and m/s²: beyond what occupant safety, impact and blast have, and beyond any planet.
_FASTEST = 2e4
# m/s: ten times as fast as any meteor. No body is rigid there, and such runs take minutes or hours.
_NOTHING = 1e6
# Sizes of the largest part that a free one goes from its start to the end of the run, alone.
_WAY = 200.0
_HEAVIEST = 300.0
_LIGHTEST = 0.01


def check_masses(scene: Scene) -> Iterator[Finding]:
    """Report masses, inertias and velocities that are most likely in another unit.

    Raises
    ------
    InputError
        A velocity that nothing has.
    """
    model, said = scene.model, scene.said
    g = length(model.gravity)
    metric = g * said.si(1, 0, -2)
    if said.known and g > 0.0 and not _LIGHTEST < metric < _HEAVIEST:
        earth = 9.80665 / said.si(1, 0, -2)
        yield Finding(
            "gravity",
            "world",
            f"gravity is {g:.4g} {said.unit('length')}/{said.unit('time')}², which is "
            f"{metric:.4g} m/s²",
            f"On earth it is {earth:.4g} in these units",
        )
    system, names = model.mechanism, list(model.bodies)
    for k, i in enumerate(system.free):
        part = model.bodies[names[i]]
        assert isinstance(part.motion, Free)
        mass = float(system.fixed[k, MASS])
        # The mass against that of water in the body's box: orders of magnitude.
        volume = float(np.prod(np.ptp(part.body.bounds(), axis=0)))
        solid = said.known and volume > 0.0 and part.body.closed
        if solid and not DENSITIES[0] < mass / volume * said.si(-3, 1, 0) < DENSITIES[1]:
            water = 1000.0 / said.si(-3, 1, 0) * volume
            yield Finding(
                "mass",
                f"body {names[i]}",
                f"its mass is {said(mass, 'mass')}, and its box of water would have "
                f"{said(water, 'mass')}",
                f"Give mass in {said.unit('mass')}, or a density in {said.unit('mass')} per "
                f"{said.unit('length')}³, and look at the unit of its geometry",
            )
        yield from _speed(f"body {names[i]}", part.motion, scene)
        # Radii of gyration that no body of this size has.
        given, own = part.motion.inertia, part.motion.mass
        if given is None or not isinstance(own, float | MassProperties):
            continue
        mass = own.mass if isinstance(own, MassProperties) else own
        largest = float(np.sqrt(np.linalg.eigvalsh(given) / mass).max())
        if not _GYRATION[0] * part.body.size < largest < _GYRATION[1] * part.body.size:
            yield Finding(
                "inertia",
                f"body {names[i]}",
                f"its inertia is that of {said(mass, 'mass')} at {said(largest)} from its "
                f"centre, in a body that is {said(part.body.size)} large",
                f"Give inertias in {said.unit('mass')}·{said.unit('length')}², about the centre of "
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
            yield from _speed(f"slave {name}", slave.motion, scene)


def _speed(where: str, motion: Free | Deforming, scene: Scene) -> Iterator[Finding]:
    said, stepping = scene.said, scene.model.stepping
    speed = float(np.sqrt(np.square(np.atleast_2d(motion.velocity)).sum(axis=1)).max())
    starts = f"it starts at {said(speed, 'velocity')}"
    give = f"Give velocities in {said.unit('velocity')}" if said.known else "Look at its unit"
    if said.known and speed * said.si(1, 0, -1) > _NOTHING:
        raise InputError(
            f"it would start at {speed * said.si(1, 0, -1):.3g} m/s",
            where=where,
            found=said(speed, "velocity"),
            allowed=f"up to {_NOTHING:g} m/s, from {_FASTEST:g} m/s with a warning",
            remedy=give,
        )
    if said.known and speed * said.si(1, 0, -1) > _FASTEST:
        speeds = f"{starts}, which is {speed * said.si(1, 0, -1):.3g} m/s"
        yield Finding("velocity", where, speeds, give)
        return
    largest = max((max(pair.body.size, pair.slave_size) for pair in scene.pairs), default=np.inf)
    way = speed * (stepping.end - stepping.start)
    if way > _WAY * largest:
        yield Finding(
            "velocity",
            where,
            f"{starts} and would go {said(way)} until the end, {way / largest:.3g} times the size "
            "of the largest part",
            f"{give}, and look at that of the end",
        )
