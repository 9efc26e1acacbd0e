"""Hertz: an exact ball and an exact cylinder on an elastic half space.

The block under the ball ends a few contact radii from its middle. Its outer nodes have the
displacements of a half space under a point load (Boussinesq), so that the error of the finite block
falls with the third power of its size. This needs the load, which is taken from the formula; a
block with its outer nodes fixed at rest would carry a sixth more.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

import contiga as cg
from contiga_validation.closed_forms.at_rest import resting
from contiga_validation.closed_forms.case import Answer, Cases, Check, relative, zero
from contiga_validation.closed_forms.foam import bricks
from contiga_validation.closed_forms.matter import GROUP
from contiga_validation.closed_forms.membranes import spaced
from contiga_validation.closed_forms.pictures import Drawing, comparison
from contiga_validation.engine.arrays import FloatArray

CASES = Cases(GROUP)

NU = 0.3
MODULUS = 1.0 / (1.0 - NU**2)
"""E* of a rigid indenter, E = 1."""
BALL = 50.0
"""Radius of the ball; the radius of contact is 1, and strains stay below 2 %."""
DEPTH = 1.0 / BALL
LOAD = 4.0 / 3.0 * MODULUS / BALL
"""Force 4/3 E* √R d^1.5 at a = √(R d) = 1."""
STIFFNESS = 100.0
"""Contact stiffness, E over length: nodes penetrate by half a percent of the depth."""
N_EVEN, N_GROWING, BLOCK_SIZE = 7, 5, 6.0
"""Number of even cells up to 1.4 contact radii, of growing cells beyond, and size of the block."""

FixedMask = NDArray[np.bool_]
"""(n, 3) mask of the fixed degrees of freedom of nodes."""


class _RestingContact(NamedTuple):
    """Contact at rest."""

    force: float
    """Force of the whole contact; per length of the cylinder."""
    radius: float
    """Radius or half width of contact, from the mean square distance of the force."""
    places: FloatArray
    """(k,) distances of touching nodes from the middle."""
    pressures: FloatArray
    """(k,) pressures at these nodes."""


class _Shares(NamedTuple):
    """Factors from the modelled part to the whole contact."""

    force_factor: float
    """Force of the whole over that of the part."""
    radius_factor: float
    """a² over the mean square distance of the force from the middle."""
    n_coordinates: int
    """Number of coordinates in a distance: 2 for x and y, 1 for x."""


def far_field(points: FloatArray) -> FloatArray:
    """Return displacements (n, 3) of a half space z < 0 under a load down at its origin.

    Boussinesq's solution (K. L. Johnson, Contact Mechanics, 3.2). Distances below 1, the radius of
    contact, count as 1.
    """
    x, y, z = points.T
    z, r = -z, np.hypot(x, y)
    rho = np.maximum(np.sqrt(r**2 + z**2), 1.0)
    scale = LOAD / (4.0 * math.pi * 0.5 / (1.0 + NU))
    down = scale * (z**2 / rho**3 + 2.0 * (1.0 - NU) / rho)
    out = scale * (z / rho**3 - (1.0 - 2.0 * NU) / (rho * (rho + z)))
    return np.stack([out * x, out * y, -down], axis=1)


def _ball() -> _RestingContact:
    """Press a ball on a quarter of the block, from the displacements of `far_field`."""
    line = spaced(N_EVEN, 1.4, N_GROWING, BLOCK_SIZE)
    rest, elements = bricks((line, line, -line[::-1]))
    sides = elements[:, [4, 5, 6, 7]]
    is_near_contact = (rest[sides, 2] == 0.0).all(axis=1) & (rest[sides, :2] < 1.5).all(axis=(1, 2))
    edge = (np.abs(rest) == line[-1]).any(axis=1)
    fixed = rest == 0.0
    fixed[:, 2] = False
    fixed[edge] = True
    block = cg.Slave(
        rest + far_field(rest), sides[is_near_contact], elements={"hexahedron": elements}
    )
    ball = cg.shapes.sphere(radius=BALL, centre=(0.0, 0.0, BALL - DEPTH))
    return _settle_under(block, ball, (rest, fixed), _Shares(4.0, 2.5, 2))


def _cylinder() -> _RestingContact:
    """Press a cylinder on half of a strip, one cell thick and in plane strain."""
    line = spaced(2 * N_EVEN, 1.4, N_GROWING, 8.0)
    thick = line[1]
    rest, elements = bricks((line, np.array([0.0, thick]), -line[::-1]))
    sides = elements[:, [4, 5, 6, 7]]
    is_near_contact = (rest[sides, 2] == 0.0).all(axis=1) & (rest[sides, 0] < 1.5).all(axis=1)
    fixed = np.zeros(rest.shape, np.bool_)
    fixed[:, 1] = True
    fixed[rest[:, 0] == 0.0, 0] = True
    fixed[rest[:, 2] == -line[-1]] = True
    # It starts evenly compressed: a cylinder so deep in undeformed cells would invert them.
    start = rest.copy()
    start[:, 2] -= 2.0 * DEPTH * (1.0 + rest[:, 2] / line[-1])
    strip = cg.Slave(start, sides[is_near_contact], elements={"hexahedron": elements})
    roll = cg.shapes.cylinder(
        radius=BALL, height=4.0, centre=(0.0, 0.5 * thick, BALL - 2.0 * DEPTH), axis="y"
    )
    return _settle_under(strip, roll, (rest, fixed), _Shares(2.0 / float(thick), 4.0, 1))


def _settle_under(
    slave: cg.Slave, shape: cg.NurbsSurface, support: tuple[FloatArray, FixedMask], shares: _Shares
) -> _RestingContact:
    """Settle a slave under a shape; `support` is its undeformed nodes and the fixed ones (mask)."""
    rest, fixed = support
    motion = cg.motion.Deforming(
        material=cg.materials.Elastic(young=1.0, poisson=NU), density=1.0, rest=rest, fixed=fixed
    )
    law = cg.PenaltyLaw(STIFFNESS, per_area=True)
    contact = cg.Contact(cg.Body([shape]), slave, law=law, search="penetration")
    state = resting(slave, motion, 1e-3, contacts=[contact])
    (pressed,) = state.contacts.values()
    force, points = pressed.normal_force, state.slaves["it"].points
    places = np.sqrt((points[:, : shares.n_coordinates] ** 2).sum(axis=1))
    touching = np.flatnonzero(pressed.patch >= 0)
    square = float((force * places**2).sum() / force.sum())
    return _RestingContact(
        shares.force_factor * float(force.sum()),
        math.sqrt(shares.radius_factor * square),
        places[touching],
        STIFFNESS * pressed.penetration[touching],
    )


def _pressure_error(
    pressed: _RestingContact, radius: float, peak: float, tolerance: float
) -> Check:
    """Check pressures up to 0.8 of the contact radius against p₀ √(1 − r²/a²), over p₀ = `peak`."""
    inner = pressed.places < 0.8 * radius
    exact = np.sqrt(1.0 - (pressed.places[inner] / radius) ** 2)
    errors = np.abs(pressed.pressures[inner] / peak - exact)
    return zero("largest error of the pressure up to 0.8 a, by p₀", errors.max(), tolerance)


def _pressure_picture(pressed: _RestingContact, radius: float, peak: float) -> Drawing:
    """Return a drawing of the pressures over those of the formula."""
    r = np.linspace(0.0, 1.2, 300)
    return comparison(
        ("r/a", "p/p₀"),
        [("formula", r, np.sqrt(np.maximum(1.0 - r**2, 0.0)))],
        [("nodes", pressed.places / radius, pressed.pressures / peak)],
    )


@CASES.add(
    "matter-hertz",
    "A rigid ball on an elastic half space",
    "a = √(R d),  F = 4/3 E* √R d^1.5,  E* = E/(1 − ν²)",
    "A quarter of a block of hexahedra, seven to 1.4 a, without friction; nodes six radii away "
    "are where Boussinesq's load brings them. Of the errors in force and radius 0.8 % and "
    "0.3 % are the contact's own give, the rest is the mesh.",
)
def _on_a_ball() -> Answer:
    pressed, peak = _ball(), 1.5 * LOAD / math.pi
    checks = (
        relative("force", pressed.force, LOAD, 0.025),
        relative("radius of the contact", pressed.radius, 1.0, 0.025),
        _pressure_error(pressed, 1.0, peak, 0.05),
    )
    return Answer(checks, _pressure_picture(pressed, 1.0, peak))


@CASES.add(
    "matter-hertz-cylinder",
    "A rigid cylinder on an elastic half space",
    "a = √(4 P R/(π E*)),  p₀ = 2 P/(π a)",
    "Half of a strip of hexahedra in plane strain; how far the cylinder goes in depends on the "
    "strip's size, by how much it touches hardly does.",
)
def _on_a_cylinder() -> Answer:
    pressed = _cylinder()
    radius = math.sqrt(4.0 * pressed.force * BALL / (math.pi * MODULUS))
    peak = 2.0 * pressed.force / (math.pi * radius)
    checks = (
        relative("half width of the contact, by the force", pressed.radius, radius, 0.01),
        _pressure_error(pressed, radius, peak, 0.02),
    )
    return Answer(checks, _pressure_picture(pressed, radius, peak))
