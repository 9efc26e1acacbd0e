"""Bars of two nodes: elastic ones, cables, and belts."""

from __future__ import annotations

import numpy as np
import pytest
from tests.unit.matter import rig

from contiga.errors import InputError
from contiga.materials import Belt, Elastic
from contiga.matter import Assembled
from contiga.matter.coefficients import Material

ENDS = np.array([[0.0, 0.0, 0.0], [2.0, 1.0, 2.0]])
"""Three apart."""
WEBBING = Belt(
    loading=[[0, 0], [0.03, 2.5], [0.12, 11.0]],
    unloading=[[0, 0], [0.06, 0.5], [0.12, 5.0]],
    hysteresis_slope=300.0,
)

STIFF = {Elastic: 4.0 * 0.5, Belt: 300.0}
"""Force at the strain one, on the steepest line."""


def bar(material: Material) -> Assembled:
    """One bar of section 0.5."""
    return rig.one_part("bar2", ENDS, np.array([[0, 1]]), material, section=0.5)


@pytest.mark.interpreted
@pytest.mark.parametrize("stretch", [1.2, 0.9])
def test_a_bar_pulls_along_itself(stretch: float) -> None:
    along = ENDS[1] / 3.0
    force, energy = rig.still(bar(Elastic(young=4.0)), ENDS * stretch)
    expected = 4.0 * 0.5 * (stretch - 1.0)
    np.testing.assert_allclose(force, [expected * along, -expected * along], atol=1e-14)
    assert energy == pytest.approx(0.5 * 2.0 * (stretch - 1.0) ** 2 * 3.0, rel=1e-12)


def test_a_cable_does_not_push() -> None:
    cable = bar(Elastic(young=4.0, compression=False))
    force, energy = rig.still(cable, 0.9 * ENDS)
    assert not force.any()
    assert energy == 0.0
    np.testing.assert_array_equal(
        rig.still(cable, 1.1 * ENDS)[0], rig.still(bar(Elastic(young=4.0)), 1.1 * ENDS)[0]
    )


def test_a_belt_follows_its_curves_and_loses_what_lies_between() -> None:
    matter = bar(WEBBING)
    state, lost, pulls = matter.start(), 0.0, []
    up = np.linspace(0.0, 0.1, 41)
    for strain in np.concatenate([up, up[::-1][1:]]):
        answer = matter.forces(state, ENDS * (1.0 + strain), np.zeros((2, 3)), 0.0)
        state, lost = answer.state, lost + answer.energy.hysteresis
        pulls.append(np.sqrt(np.sum(answer.force[0] ** 2)))
    top = 2.5 + 8.5 / 0.09 * 0.07
    assert pulls[40] == pytest.approx(top, rel=1e-12)
    low = 0.5 + 75.0 * 0.04
    between = 0.5 * 0.03 * 2.5 + 0.5 * 0.07 * (2.5 + top) - 0.5 * 0.06 * 0.5
    between -= 0.5 * 0.04 * (0.5 + low)
    between -= 0.5 * (top - low) ** 2 / (300.0 - 75.0)
    assert lost == pytest.approx(3.0 * between, rel=1e-9)
    assert pulls[-1] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("material", [Elastic(young=4.0), WEBBING])
def test_row_sums_bound_the_stiffness(material: Material) -> None:
    matter = bar(material)
    for stretch in (1.01, 1.05):
        q = ENDS * stretch
        exact = np.abs(rig.tangent(matter, q)).sum(axis=1).reshape(-1, 3).max(axis=1)
        told = matter.stiffness(matter.start()._replace(points=q))
        assert (told >= exact * (1.0 - 1e-6)).all()
        if material is not WEBBING:
            assert (told <= 1.1 * exact).all()


def test_a_belt_carries_its_mass_at_its_nodes() -> None:
    np.testing.assert_allclose(bar(WEBBING).mass, 0.5 * 2.0 * 0.5 * 3.0)


def test_a_belt_whose_curves_cross_is_refused() -> None:
    with pytest.raises(InputError, match="above the loading"):
        Belt(loading=2.0, unloading=[[0, 0], [0.1, 0.1], [0.2, 0.5]], hysteresis_slope=10.0)


@pytest.mark.parametrize("material", [Elastic(young=4.0), WEBBING])
def test_a_bar_whose_ends_meet_pulls_nowhere_and_is_as_stiff_as_ever(material: Material) -> None:
    matter = bar(material)
    place = np.broadcast_to(ENDS[1], ENDS.shape)
    answer = matter.forces(matter.start(), place, np.zeros_like(ENDS), 0.1)
    np.testing.assert_array_equal(answer.force, 0.0)
    sums = matter.stiffness(answer.state)
    np.testing.assert_allclose(sums, 2.0 * STIFF[type(material)] / 3.0, rtol=1e-12)  # 2 k
    np.testing.assert_array_equal(matter.nodal_fields(answer.state).stress, 0.0)
