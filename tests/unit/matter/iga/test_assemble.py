"""What is refused of shells, and what of them follows from what was asked."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.unit.matter.iga.shells import ELASTIC, made, plate, still

from contiga.errors import InputError
from contiga.materials import Belt, Elastic, Fabric, Foam, NeoHooke
from contiga.matter.iga import assemble_shell, join

FLAT = plate(2, (1, 1), (1.0, 1.0))
RUBBER = NeoHooke(young=3.0, poisson=0.3)


@pytest.mark.parametrize(
    ("more", "told"),
    [
        ({"material": Foam(loading=1.0)}, "material: Foam is no material of shells"),
        ({"material": Belt(loading=1.0)}, "material: Belt is no material of shells"),
        ({"density": 0.0}, "density: must be positive"),
        ({"thickness": -1.0}, "thickness: must be positive"),
        ({"bending": -0.1}, "bending: must not be negative"),
        ({"bending": np.nan}, "bending: must be finite"),
        ({"layers": -1}, "layers: must be a whole number"),
        ({"layers": 0, "material": RUBBER}, "layers: the material is asked layer by layer"),
        ({"rule": 0}, "rule: must be a whole number"),
        ({"slope_stiffness": 0.0}, "slope_stiffness: must be positive"),
        ({"surfaces": [plate(1, (2, 2), (1.0, 1.0))]}, "of degree 1 in a direction does not bend"),
        (
            {"material": Fabric(warp=1.0, shear=1.0, direction=np.ones((2, 3)))},
            "direction: of a shell is one",
        ),
        (
            {"material": Fabric(warp=1.0, shear=1.0, direction=[0, 0, 1])},
            "direction: the warp is across the surface",
        ),
    ],
)
def test_what_is_no_shell_is_told(more: dict[str, Any], told: str) -> None:
    given = {"surfaces": [FLAT]} | more
    with pytest.raises(InputError, match=told):
        made(**given)


def test_a_net_may_be_joined_before() -> None:
    net = join([FLAT])
    shell = assemble_shell(net, material=ELASTIC, density=2.0, thickness=0.1)
    assert shell.net is net
    np.testing.assert_array_equal(shell.mass, made([FLAT]).mass)
    assert shell.mass.sum() == pytest.approx(0.2)


def test_materials_are_asked_where_they_need_it() -> None:
    for material, layers in ((ELASTIC, 0), (RUBBER, 3), (Elastic(young=1.0, compression=False), 3)):
        assert len(made([FLAT], material=material).groups[0].tables.layers) == layers
    assert len(made([FLAT], material=RUBBER, bending=0.0).groups[0].tables.layers) == 0


def test_a_share_of_bending_is_that_of_the_energy() -> None:
    for material in (ELASTIC, RUBBER):
        energies = []
        for share in (1.0, 0.25):
            shell = made([FLAT], material=material, bending=share)
            q = shell.nodes.copy()
            q[:, 2] = 1e-3 * shell.net.sites[:, 0] ** 2
            energies.append(still(shell, q)[1])
        assert energies[1] == pytest.approx(0.25 * energies[0], rel=1e-3)


def test_states_are_left_as_they_are() -> None:
    cloth = Fabric(warp=3.0, shear=0.5, direction=[1, 0, 0])
    shell = made([FLAT], material=cloth, layers=2)
    state = shell.start()
    kept = state.memory.copy(), state.points.copy()
    q = shell.nodes * 1.1
    answer = shell.forces(state, q, np.zeros_like(q), 0.1)
    np.testing.assert_array_equal(state.memory, kept[0])
    np.testing.assert_array_equal(state.points, kept[1])
    assert answer.state.memory.any()
    again = shell.forces(state, q, np.zeros_like(q), 0.1)
    np.testing.assert_array_equal(answer.force, again.force)
    np.testing.assert_array_equal(answer.state.memory, again.state.memory)
