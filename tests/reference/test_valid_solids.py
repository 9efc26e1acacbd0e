"""Valid solids by OpenCASCADE are closed, as heavy as they are, and have their sides.

And bodies that pierce themselves are told, with a place where two sheets of theirs cross.
"""

from __future__ import annotations

import numpy as np
import pytest
from tests import occ_solids
from tests.stress import closed, pieces, pierced, valid

import contiga as cg

SOLIDS = {
    valid.lattice: (0, 1, 7),
    valid.heap: (3, 16),
    valid.beams: (0, 1, 2),
    valid.pallet: (2,),
    valid.rails: (1,),
    valid.tangent_boss: (2, 3, 7),
    valid.overhanging_boss: (0, 2, 5),
    valid.square_boss_askew: (3, 4),
    valid.touching_loops: (2, 5),
    valid.stepped: (3, 4),
    valid.flange: (2,),
    valid.flush_pin: (0, 1),
    valid.half_round: (1, 2),
    valid.crossing_rods: (24,),
    valid.cones: (0, 4),
    valid.fillets: (0,),
    valid.hollow: (0, 1),
    valid.drafted: (1,),
    valid.wedges: (0, 4),
    valid.prisms: (0,),
    valid.turned_profiles: (3,),
    valid.cavities: (1,),
    valid.assemblies: (0, 3, 4),
}
"""Some of each family, which come by STEP, by IGES, as solids and as loose faces, and directly."""
PIERCED = {
    pierced.lids: (0, 1, 2),
    pierced.bulges: (0, 1),
    pierced.turned_eights: (0, 1),
    pierced.pits: (0, 1, 2),
    pierced.springs: (0,),
    pierced.overlapping: (2,),
}


def named(chosen):
    """Parameters of each family and number, with a name."""
    return [
        pytest.param(family, number, id=f"{family.__name__} {number}")
        for family, numbers in chosen.items()
        for number in numbers
    ]


@pytest.mark.parametrize(("family", "number"), named(SOLIDS))
def test_a_valid_solid_is_closed_with_its_mass_and_its_sides(family, number):
    solid = valid.made(family, number)
    verdict = closed.judged(solid, closed.way_of(solid, number))
    assert verdict.faults == []
    assert verdict.judged > 0.9 * closed.POINTS


@pytest.mark.parametrize(("family", "number"), named(PIERCED))
def test_a_body_that_pierces_itself_is_told_with_the_place(family, number):
    assert pierced.told(pierced.made(family, number)).fault == ""


def test_another_mass_and_sides_are_judged_wrong():
    piece = pieces.box((0, 0, 0), (3, 2, 1))
    larger = pieces.box((0, 0, 0), (3, 2, 1.1)).shape
    verdict = closed.judged(valid.Valid("it", piece._replace(shape=larger)), "step")
    assert verdict.off == pytest.approx(0.1)
    assert verdict.wrong > 0


def test_an_open_box_is_judged_wrong():
    piece = pieces.box((0, 0, 0), (10, 10, 10))
    lidless = occ_solids.lidless_box()
    verdict = closed.judged(valid.Valid("it", piece._replace(shape=lidless)), "step")
    assert verdict.faults[0].startswith("open")


def test_a_body_that_does_not_pierce_itself_is_judged_as_not_told():
    sound = pierced.Pierced("it", lambda: cg.Body([cg.shapes.sphere()]))
    assert pierced.told(sound).fault == "not told"


def test_a_place_off_the_crossing_is_judged_wrong():
    ball, other = cg.shapes.sphere(), cg.shapes.sphere(centre=(1.0, 0.0, 0.0))
    body = cg.Body([ball, other])
    on = np.array([0.5, np.sqrt(0.75), 0.0])
    assert pierced.off_sheets(body, (0, 1), on) < 1e-12
    assert pierced.off_sheets(body, (0, 1), np.add(on, (0.0, 1e-3, 0.0))) > 5e-4
