"""Forces of elements of every kind and material: what holds of all of them."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from tests.unit.matter import rig

from contiga.errors import ElementError
from contiga.materials import Belt, Elastic, Fabric, Foam, NeoHooke
from contiga.matter import Assembled, Part, assemble

RUBBER, STEEL = NeoHooke(young=3.0, poisson=0.45), Elastic(young=3.0, poisson=0.3)
PAD = Foam(loading=[[0.0, 0.0], [0.9, 3.0]], tension=3.0)
SOFT = NeoHooke(young=3.0, poisson=0.499, volume="nodes")
CLOTH = Elastic(young=3.0, poisson=0.3, compression=False)
WOVEN = Fabric(warp=3.0, weft=2.0, shear=0.4, direction=[1.0, 2.0, 0.0])
SHEET = rig.grid((1, 1, 0))
CASES = {
    "tet4 neo-Hooke": ("tet4", rig.grid((1, 1, 1)), rig.tets((1, 1, 1)), RUBBER, {}),
    "tet4 elastic": ("tet4", rig.grid((1, 1, 1)), rig.tets((1, 1, 1)), STEEL, {}),
    "tet4 averaged": ("tet4", rig.grid((1, 1, 1)), rig.tets((1, 1, 1)), SOFT, {}),
    "hex8 neo-Hooke": ("hex8", rig.grid((2, 1, 1)), rig.hexes((2, 1, 1)), RUBBER, {}),
    "hex8 elastic": ("hex8", rig.ONE_HEX, rig.hexes((1, 1, 1)), STEEL, {}),
    "hex8 foam": ("hex8", rig.ONE_HEX, rig.hexes((1, 1, 1)), PAD, {}),
    "tri3 neo-Hooke": ("tri3", SHEET, rig.sheet(1, 1), RUBBER, {"thickness": 0.2}),
    "tri3 fabric": ("tri3", SHEET, rig.sheet(1, 1), WOVEN, {"thickness": 0.2}),
    "bar2 elastic": ("bar2", SHEET, np.array([[0, 1], [1, 3], [2, 3]]), STEEL, {"section": 0.1}),
    "bar2 belt": ("bar2", SHEET, np.array([[0, 3], [1, 2]]), Belt(loading=0.3), {"section": 0.1}),
    "tri3 elastic": ("tri3", SHEET, rig.sheet(1, 1), STEEL, {"thickness": 0.2}),
    "tri3 slack": ("tri3", SHEET, rig.sheet(1, 1), CLOTH, {"thickness": 0.2}),
}


@pytest.fixture(params=CASES, ids=lambda name: name.replace(" ", "_"))
def matter(request: pytest.FixtureRequest) -> Assembled:
    kind, nodes, elements, material, more = CASES[request.param]
    return rig.one_part(kind, nodes, elements, material, **more)


@pytest.mark.interpreted
def test_forces_are_the_gradient_of_what_is_stored(matter: Assembled) -> None:
    q = rig.moved(matter.nodes * [1.2, 1.1, 1.15], 0.05)
    force, _ = rig.still(matter, q)
    expected = rig.by_differences(matter, q)
    np.testing.assert_allclose(force, expected, rtol=0, atol=1e-8 * np.abs(force).max())


@pytest.mark.interpreted
def test_nothing_pushes_matter_at_rest(matter: Assembled) -> None:
    force, energy = rig.still(matter, matter.nodes)
    np.testing.assert_allclose(force, 0.0, atol=1e-14)
    assert abs(energy) < 1e-14


def test_a_rigid_motion_stores_nothing(matter: Assembled) -> None:
    turn = Rotation.from_rotvec([1.0, -2.0, 0.5]).as_matrix()
    force, energy = rig.still(matter, matter.nodes @ turn.T + [3.0, 4.0, -5.0])
    np.testing.assert_allclose(force, 0.0, atol=1e-12)
    assert abs(energy) < 1e-12


def test_forces_turn_with_the_matter(matter: Assembled) -> None:
    turn = Rotation.from_rotvec([1.0, -2.0, 0.5]).as_matrix()
    q = rig.moved(matter.nodes, 0.05)
    (force, energy), (turned, same) = rig.still(matter, q), rig.still(matter, q @ turn.T + 2.0)
    np.testing.assert_allclose(turned, force @ turn.T, rtol=0, atol=1e-12 * np.abs(force).max())
    assert same == pytest.approx(energy, rel=1e-12)


def test_forces_and_moments_balance(matter: Assembled) -> None:
    q = rig.moved(matter.nodes, 0.05)
    force, _ = rig.still(matter, q)
    np.testing.assert_allclose(force.sum(axis=0), 0.0, atol=1e-14)
    np.testing.assert_allclose(np.cross(q, force).sum(axis=0), 0.0, atol=1e-14)


@pytest.mark.parametrize("kind", ["tet4", "hex8", "tri3"])
def test_an_even_strain_pushes_no_inner_node(kind: str) -> None:
    """The patch test: a mesh distorted inside, in a field whose gradient is everywhere the same."""
    if kind != "tri3":
        counts = (3, 3, 3)
        elements = rig.tets(counts) if kind == "tet4" else rig.hexes(counts)
        nodes, more = rig.grid(counts), {}
    else:
        counts = (3, 3, 0)
        nodes, elements, more = rig.grid(counts), rig.sheet(3, 3), {"thickness": 0.2}
    axes = [axis for axis in range(3) if counts[axis]]
    inner = ((nodes[:, axes] > 0.01) & (nodes[:, axes] < 0.99)).all(axis=1)
    nodes[np.ix_(inner, axes)] += np.random.default_rng(0).uniform(
        -0.05, 0.05, (inner.sum(), len(axes))
    )
    strain = np.array([[1.2, 0.1, 0.05], [-0.03, 0.95, 0.02], [0.1, 0.0, 1.1]])
    for material in (RUBBER, STEEL, SOFT):
        force, _ = rig.still(
            rig.one_part(kind, nodes, elements, material, **more), nodes @ strain.T
        )
        assert inner.sum() > 3
        np.testing.assert_allclose(force[inner], 0.0, atol=1e-13)
        assert np.abs(force).max() > 0.01


def test_blocks_that_are_not_full_change_nothing() -> None:
    """A mesh of several blocks is the sum of its elements one by one."""
    counts = (3, 3, 3)
    nodes, elements = rig.grid(counts), rig.tets(counts)
    q = rig.moved(nodes, 0.02)
    force, energy = rig.still(rig.one_part("tet4", nodes, elements, RUBBER), q)
    summed, stored = np.zeros_like(q), 0.0
    for corners in elements:
        alone = rig.one_part("tet4", nodes[corners], np.arange(4)[None], RUBBER)
        part, w = rig.still(alone, q[corners])
        summed[corners] += part
        stored += w
    np.testing.assert_allclose(force, summed, rtol=0, atol=1e-14)
    assert energy == pytest.approx(stored, rel=1e-13)


def test_an_element_that_turns_inside_out_is_named() -> None:
    counts = (3, 3, 3)
    nodes, elements = rig.grid(counts), rig.tets(counts)
    matter = rig.one_part("tet4", nodes, elements, RUBBER)
    q = nodes.copy()
    apex = elements[70]
    q[apex[3]] -= 1.2 * (nodes[apex[3]] - nodes[apex[:3]].mean(axis=0))
    with pytest.raises(ElementError) as caught:
        rig.still(matter, q)
    edges = q[elements[:, 1:]] - q[elements[:, :1]]
    wrong = np.flatnonzero(np.linalg.det(edges) <= 0.0)
    assert 70 in wrong
    assert caught.value.element == wrong[0]
    assert caught.value.count == len(wrong)
    np.testing.assert_allclose(caught.value.place, q[elements[wrong[0]]].mean(axis=0))
    assert "at the time 0.25" in str(caught.value.at(0.25))


def test_a_node_that_is_not_finite_is_no_silent_nan() -> None:
    matter = rig.one_part("tet4", rig.ONE_TET, np.array([[0, 1, 2, 3]]), RUBBER)
    q = rig.ONE_TET.copy()
    q[2, 1] = np.nan
    with pytest.raises(ElementError):
        rig.still(matter, q)


def test_parts_share_their_nodes() -> None:
    nodes = rig.grid((1, 1, 1))
    solid = Part(kind="tet4", elements=rig.tets((1, 1, 1)), material=RUBBER, density=2.0)
    skin = Part(
        kind="tri3", elements=np.array([[0, 1, 3]]), material=STEEL, density=3.0, thickness=0.1
    )
    both = assemble(nodes, [solid, skin])
    q = rig.moved(nodes, 0.05)
    alone = rig.one_part("tet4", nodes, solid.elements, RUBBER)
    force, energy = rig.still(both, q)
    rest, stored = rig.still(alone, q)
    triangle = rig.one_part("tri3", nodes[[0, 1, 3]], np.array([[0, 1, 2]]), STEEL, thickness=0.1)
    more, w = rig.still(triangle, q[[0, 1, 3]])
    rest[[0, 1, 3]] += more
    np.testing.assert_allclose(force, rest, rtol=0, atol=1e-15)
    assert energy == pytest.approx(stored + w, rel=1e-14)
    assert both.mass.sum() == pytest.approx(2.0 * 1.0 + 3.0 * 0.05, rel=1e-14)


def test_damping_takes_what_it_says() -> None:
    nodes = rig.ONE_TET
    part = Part(kind="tet4", elements=np.array([[0, 1, 2, 3]]), material=RUBBER, density=6.0)
    matter = assemble(nodes, [part], damping=0.5)
    v = np.ones((4, 3))
    answer = matter.forces(matter.start(), nodes, v, 0.1)
    np.testing.assert_allclose(answer.force, -0.5 * 0.25, rtol=1e-12)
    assert answer.energy.viscosity == pytest.approx(0.1 * 12 * 0.5 * 0.25, rel=1e-12)
