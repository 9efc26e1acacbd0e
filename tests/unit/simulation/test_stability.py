"""What is said of elements that have gone unstable."""

from __future__ import annotations

import pytest
from tests.cases.matter import mesh

import contiga as cg
from contiga.simulation.critical import remedy


@pytest.mark.parametrize(("centre", "deep"), [(0.0, True), (40.0, False)])
def test_points_deeper_than_facets_are_wide_are_called_too_coarse(centre, deep) -> None:
    """Not a matter of units: a ball of 30 around the middle of a sheet with facets of 5."""
    sheet = mesh("triangle", 8, 1000.0)
    ball = cg.Body([cg.shapes.sphere(radius=30.0, centre=(0.0, 0.0, centre))])
    cloth = cg.motion.Deforming(
        material=cg.materials.Elastic(young=50.0), density=1e-3, thickness=0.5
    )
    law = cg.PenaltyLaw(1.0, per_area=True)
    contact = cg.Contact(ball, sheet, law=law, quadrature=3, search="penetration")
    simulation = cg.Simulation(
        bodies={"ball": ball},
        slaves={"sheet": (sheet, cloth)},
        contacts=[contact],
        end=1.0,
        step="auto",
    )
    said = remedy(simulation, simulation.start(), "sheet")
    assert ("5 wide, are too coarse for ball, in which points of theirs lie" in said) == deep
    assert ("units" in said) != deep
