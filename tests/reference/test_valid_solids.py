"""Valid solids by OpenCASCADE are closed, as heavy as they are, and have their sides.

And bodies that pierce themselves are told, with a place where two sheets of theirs cross.
"""

from __future__ import annotations

import pytest
from tests.stress import closed, pieces, pierced, valid

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
    valid.turned_profiles: (0,),
    valid.pipes: (1,),
    valid.cavities: (1,),
    valid.assemblies: (0, 2, 4),
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


def test_the_judge_finds_a_solid_of_another_size_and_one_that_is_open():
    piece = pieces.box((0, 0, 0), (3, 2, 1))
    larger = pieces.box((0, 0, 0), (3, 2, 1.01))
    verdict = closed.judged(valid.Valid("it", piece._replace(shape=larger.shape), False), "step")
    assert [fault.split()[0] for fault in verdict.faults] == ["mass", *verdict.wrong * ["x"]][
        :1
    ] or (verdict.faults)
