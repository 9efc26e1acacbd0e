"""Damping ratios of slaves that deform: the masses that elements give to nodes and points."""

from __future__ import annotations

import math

import numpy as np
import pytest

import contiga as cg
from contiga.errors import InputError
from contiga.records import FloatArray

RATIO, STIFFNESS, SPEED = 0.3, 50.0, 2.0
GROUND = cg.Body([cg.shapes.plane(width=6.0, length=6.0)])
FACETS = [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]]
SHEET = [[-0.5, -0.4, 0.0], [0.6, -0.5, 0.0], [0.4, 0.7, 0.0], [-0.7, 0.3, 0.0], [0.2, 0.1, 0.0]]


def restitution(ratio: float) -> float:
    """Of a mass on a spring with a damper that does not pull, ζ < 1/√2.

    The force ends while the spring is still pressed (Schwager and Pöschel, Granular Matter 9,
    2007): e = exp(−ζ/√(1 − ζ²) (π − atan(2 ζ √(1 − ζ²)/(1 − 2 ζ²)))).
    """
    swing = math.sqrt(1.0 - ratio * ratio)
    angle = math.pi - math.atan(2.0 * ratio * swing / (1.0 - 2.0 * ratio * ratio))
    return math.exp(-ratio / swing * angle)


def rebound(quadrature: str | int, step: float) -> FloatArray:
    """(5, 3) velocities of a sheet of uneven triangles after it has fallen flat on the ground."""
    motion = cg.motion.Deforming(
        material=cg.materials.Elastic(young=100.0, poisson=0.3),
        density=2.0,
        thickness=0.25,
        velocity=[0.0, 0.0, -SPEED],
    )
    bare = cg.Slave(np.add(SHEET, [0.0, 0.0, 1e-6]), FACETS)
    slave = motion.with_masses(bare)
    law = cg.PenaltyLaw(STIFFNESS, per_area=True, damping_ratio=RATIO)
    contact = cg.Contact(GROUND, slave, law=law, quadrature=quadrature)
    simulation = cg.Simulation(
        bodies={"ground": GROUND},
        slaves={"sheet": (slave, motion)},
        contacts=[contact],
        end=0.5,  # half a swing is π √(ρt/K)/√(1 − ζ²) = 0.33
        step=step,
    )
    return simulation.run().state.slaves["sheet"].velocities


@pytest.mark.parametrize("quadrature", ["nodes", 1, 3, 6])
def test_a_sheet_that_falls_flat_leaves_with_the_speed_of_the_closed_form(
    quadrature: str | int,
) -> None:
    """Each of its nodes has a mass of its own and as much of the spring: it stays flat."""
    velocities = rebound(quadrature, 5e-4)
    np.testing.assert_allclose(velocities[:, :2], 0.0, atol=1e-9)
    np.testing.assert_allclose(velocities[:, 2], SPEED * restitution(RATIO), rtol=2e-3)


def test_nodes_have_the_masses_of_their_elements_and_points_share_them() -> None:
    motion = cg.motion.Deforming(
        material=cg.materials.NeoHooke(young=3.0, poisson=0.3), density=6.0
    )
    tetra = [[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    slave = cg.Slave(tetra, [[0, 2, 1]], elements={"tetra": [[0, 1, 2, 3]]})
    weighed = motion.with_masses(slave)
    assert slave.mass is None
    assert weighed.mass is not None
    np.testing.assert_allclose(weighed.mass, 0.25, rtol=1e-14)
    assert weighed.elements["tetra"].tolist() == [[0, 1, 2, 3]]


def test_a_slave_without_masses_is_refused_with_what_gives_them() -> None:
    law = cg.PenaltyLaw(STIFFNESS, damping_ratio=RATIO)
    with pytest.raises(InputError, match=r"nodal mass.*Deforming\.with_masses\(slave\)"):
        cg.Contact(GROUND, cg.Slave(SHEET, FACETS), law=law)
