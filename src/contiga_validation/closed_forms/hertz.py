"""Hertz: an exact ball and an exact cylinder on an elastic half space.

The block ends a few radii of contact from its middle, and its outer nodes are where Boussinesq's
point load brings those of a half space: what is left of the block's size falls with its third
power. The load must be known for that, so it is that of the formula; a block held where it was
would carry a sixth more.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

import contiga as cg
from contiga_validation.closed_forms.at_rest import resting
from contiga_validation.closed_forms.case import Answer, Case, absolute, relative
from contiga_validation.closed_forms.foam import bricks
from contiga_validation.closed_forms.matter import GROUP
from contiga_validation.closed_forms.membranes import spaced
from contiga_validation.closed_forms.pictures import compared
from contiga_validation.engine.arrays import FloatArray

NU = 0.3
MODULUS = 1.0 / (1.0 - NU**2)
"""E* of a rigid indenter, E = 1."""
BALL = 50.0
"""Radius over that of the contact, which is 1: strains stay below 2 %."""
DEPTH = 1.0 / BALL
LOAD = 4.0 / 3.0 * MODULUS / BALL
"""4/3 E* √R d^1.5 of a = √(R d) = 1."""
STIFF = 100.0
"""Of the contact, E over length: it gives way by half a percent of the depth."""
FINE, OUTER, FAR = 7, 5, 6.0
"""Even cells up to 1.4 radii of contact, cells that grow beyond, and where the block ends."""


class _Pressed(NamedTuple):
    """What touches at rest."""

    force: float
    """Of the whole contact; a length of the cylinder."""
    radius: float
    """Of the contact, by the mean square distance of the force from its middle."""
    places: FloatArray
    """Distances of nodes from the middle."""
    pressures: FloatArray


def far_field(points: FloatArray) -> FloatArray:
    """(n, 3) displacements of a half space z < 0 under a load down at its origin (Boussinesq; K. L.
    Johnson, Contact Mechanics, 3.2), within the contact those at its border."""
    x, y, z = points.T
    z, r = -z, np.hypot(x, y)
    rho = np.maximum(np.sqrt(r**2 + z**2), 1.0)
    scale = LOAD / (4.0 * math.pi * 0.5 / (1.0 + NU))
    down = scale * (z**2 / rho**3 + 2.0 * (1.0 - NU) / rho)
    out = scale * (z / rho**3 - (1.0 - 2.0 * NU) / (rho * (rho + z)))
    return np.stack([out * x, out * y, -down], axis=1)


def _ball() -> _Pressed:
    """A quarter of the block under a ball."""
    line = spaced(FINE, 1.4, OUTER, FAR)
    rest, elements = bricks((line, line, -line[::-1]))
    sides = elements[:, [4, 5, 6, 7]]
    near = (rest[sides, 2] == 0.0).all(axis=1) & (rest[sides, :2] < 1.5).all(axis=(1, 2))
    edge = (np.abs(rest) == line[-1]).any(axis=1)
    fixed = rest == 0.0
    fixed[:, 2] = False
    fixed[edge] = True
    slave = cg.Slave(
        rest + far_field(rest), sides[near], elements={"hexahedron": elements}, name="block"
    )
    motion = cg.motion.Deforming(
        material=cg.materials.Elastic(young=1.0, poisson=NU), density=1.0, rest=rest, fixed=fixed
    )
    ball = cg.Body([cg.shapes.sphere(radius=BALL, centre=(0.0, 0.0, BALL - DEPTH))])
    law = cg.PenaltyLaw(STIFF, per_area=True)
    contact = cg.Contact(ball, slave, law=law, search="penetration")
    state = resting(slave, motion, 1e-3, contacts=[contact])
    (touching,) = state.contacts.values()
    return _told(state.slaves["it"].points, touching, 4.0, 2.5)


def _told(points: FloatArray, contact: cg.State, whole: float, of_square: float) -> _Pressed:
    """Of a part of the contact, `whole` of which are all of it; a² is `of_square` of the mean."""
    places, force = np.hypot(points[:, 0], points[:, 1]), contact.normal_force
    touching = np.flatnonzero(contact.patch >= 0)
    square = float((force * places**2).sum() / force.sum())
    return _Pressed(
        whole * float(force.sum()),
        math.sqrt(of_square * square),
        places[touching],
        STIFF * contact.penetration[touching],
    )


def _hertz() -> Answer:
    found = _ball()
    peak = 1.5 * LOAD / math.pi
    # The middle is a corner of the quarter, whose area depends on how its side is cut in two.
    inner = (found.places > 0.0) & (found.places < 0.8)
    off = found.pressures[inner] / peak - np.sqrt(1.0 - found.places[inner] ** 2)
    checks = (
        relative("force", found.force, LOAD, 0.025),
        relative("radius of the contact", found.radius, 1.0, 0.025),
        absolute("largest error of the pressure up to 0.8 a, by p₀", np.abs(off).max(), 0.0, 0.05),
    )
    r = np.linspace(0.0, 1.2, 300)
    curve = np.sqrt(np.maximum(1.0 - r**2, 0.0))
    draw = compared(
        ("r/a", "p/p₀"),
        [("formula", r, curve)],
        [("nodes", found.places, found.pressures / peak)],
    )
    return Answer(checks, draw)


CASES = (
    Case(
        "matter-hertz",
        GROUP,
        "A rigid ball on an elastic half space",
        "a = √(R d),  F = 4/3 E* √R d^1.5,  E* = E/(1 − ν²)",
        "A quarter of a block of hexahedra, seven to 1.4 a, without friction; nodes six radii away "
        "are where Boussinesq's load brings them. Of the errors in force and radius 0.8 % and "
        "0.3 % are the contact's own give, the rest is the mesh.",
        _hertz,
    ),
)
