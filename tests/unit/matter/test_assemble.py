"""What is refused of matter, and what is worked out of it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.unit.matter import rig

from contiga.errors import InputError, MeshError
from contiga.materials import Elastic, NeoHooke
from contiga.matter import Part, assemble

RUBBER = NeoHooke(young=3.0, poisson=0.45)
CABLE = Elastic(young=3.0, compression=False)
GOOD: dict[str, Any] = {
    "kind": "tet4",
    "elements": np.array([[0, 1, 2, 3]]),
    "material": RUBBER,
    "density": 2.0,
}


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"kind": "quad4"}, "kind of element"),
        ({"density": 0.0}, "density: must be positive"),
        ({"density": float("nan")}, "density: must be positive"),
        ({"elements": np.zeros((0, 4), int)}, "rows of nodes"),
        ({"elements": np.array([[0.0, 1.0, 2.0, 3.0]])}, "rows of nodes"),
        ({"elements": np.array([[0, 1, 2]])}, "Triangles are membranes, no solids"),
        ({"thickness": 0.1}, "has no thickness"),
        ({"kind": "bar2", "elements": np.array([[0, 1]]), "material": CABLE}, "needs a section"),
        ({"kind": "bar2", "elements": np.array([[0, 1]])}, "NeoHooke is no material of bar2"),
        ({"kind": "tri3", "elements": np.array([[0, 1, 2]])}, "tri3 needs a thickness"),
        ({"kind": "tri3", "elements": np.array([[0, 1, 2]]), "thickness": -1.0}, "positive"),
        ({"material": Elastic(young=1.0, compression=False)}, "solids carry compression"),
    ],
)
def test_a_wrong_part_is_refused(change: dict[str, Any], says: str) -> None:
    with pytest.raises(InputError, match=says):
        assemble(rig.ONE_TET, [Part(**(GOOD | change))])


@pytest.mark.parametrize(
    ("nodes", "elements", "says"),
    [
        (rig.ONE_TET, [[0, 2, 1, 3]], r"element 0 \(tet4, at 0.25, 0.25, 0.25\) is inside out"),
        (rig.ONE_TET * [1, 1, 0], [[0, 1, 2, 3]], "has no volume"),
        (rig.ONE_TET * [1, 1, 1e-14], [[0, 1, 2, 3]], "has no volume"),
        (rig.ONE_TET, [[0, 1, 2, 4]], "corner that is no row"),
        (rig.ONE_TET, [[0, 1, 2, -1]], "corner that is no row"),
        (np.vstack([rig.ONE_TET, [[5, 5, 5]]]), [[0, 1, 2, 3]], "node 4 is in no element"),
        (np.where(rig.ONE_TET == 1, np.inf, 0), [[0, 1, 2, 3]], "not finite"),
    ],
)
def test_a_wrong_mesh_is_refused(nodes: np.ndarray, elements: list[list[int]], says: str) -> None:
    with pytest.raises(MeshError, match=says):
        assemble(nodes, [Part(**(GOOD | {"elements": np.array(elements)}))])


def test_a_hexahedron_in_the_order_of_a_grid_is_refused() -> None:
    with pytest.raises(MeshError, match=r"is inside out|has no volume"):
        rig.one_part("hex8", rig.grid((1, 1, 1)), rig.cells((1, 1, 1)), RUBBER)


def test_triangles_without_area_are_refused() -> None:
    line = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0]])
    with pytest.raises(MeshError, match="has no area"):
        rig.one_part("tri3", line, np.array([[0, 1, 2]]), RUBBER, thickness=0.1)


def test_matter_without_parts_and_damping_below_zero_are_refused() -> None:
    with pytest.raises(InputError, match="needs a part"):
        assemble(rig.ONE_TET, [])
    with pytest.raises(InputError, match="damping"):
        assemble(rig.ONE_TET, [Part(**GOOD)], damping=-1.0)


@pytest.mark.parametrize("young", [0.0, -1.0, float("inf"), "soft"])
def test_a_wrong_modulus_is_refused(young: Any) -> None:
    with pytest.raises(InputError, match="young"):
        Elastic(young=young)


@pytest.mark.parametrize("poisson", [0.5, 0.6, -1.0, float("nan"), None])
def test_a_wrong_ratio_is_refused(poisson: Any) -> None:
    with pytest.raises(InputError, match="poisson"):
        NeoHooke(young=1.0, poisson=poisson)


@pytest.mark.parametrize("kind", ["tet4", "hex8"])
def test_mass_is_that_of_the_volume(kind: str) -> None:
    counts = (3, 2, 2)
    nodes = rig.grid(counts, (2.0, 1.0, 1.0))
    elements = rig.tets(counts) if kind == "tet4" else rig.hexes(counts)
    matter = rig.one_part(kind, nodes, elements, RUBBER)
    assert matter.mass.sum() == pytest.approx(4.0, rel=1e-13)
    centre = matter.mass @ nodes / matter.mass.sum()
    np.testing.assert_allclose(centre, [1.0, 0.5, 0.5], rtol=0.2)


def test_lumped_masses_stand_beside_those_of_elements() -> None:
    lumped = [0.0, 2.0, 0.5, 0.0]
    plain = assemble(rig.ONE_TET, [Part(**GOOD)])
    matter = assemble(rig.ONE_TET, [Part(**GOOD)], lumped=lumped)
    np.testing.assert_allclose(matter.mass, plain.mass + lumped, rtol=1e-15)


@pytest.mark.parametrize("lumped", [1.0, [1.0, 2.0], [1.0, 1.0, 1.0, -1.0], [np.inf, 0, 0, 0]])
def test_lumped_masses_that_are_none_are_refused(lumped: Any) -> None:
    with pytest.raises(InputError, match="lumped: must be masses of the nodes"):
        assemble(rig.ONE_TET, [Part(**GOOD)], lumped=lumped)


@pytest.mark.parametrize("kind", ["tet4", "hex8"])
def test_the_skin_is_closed_and_faces_outward(kind: str) -> None:
    """The sum of normals is zero, and x·n over three is the volume."""
    counts = (3, 2, 2)
    nodes = rig.grid(counts, (2.0, 1.0, 1.0))
    elements = rig.tets(counts) if kind == "tet4" else rig.hexes(counts)
    facets = rig.one_part(kind, nodes, elements, RUBBER).facets
    a, b, c = (nodes[facets[:, k]] for k in range(3))
    normals = 0.5 * np.cross(b - a, c - a)
    np.testing.assert_allclose(normals.sum(axis=0), 0.0, atol=1e-14)
    assert np.sum(a * normals) / 3.0 == pytest.approx(2.0, rel=1e-13)
    assert np.sqrt((normals**2).sum(axis=1)).sum() == pytest.approx(2 * (2 + 2 + 1), rel=1e-13)


def test_the_state_is_left_as_it_is() -> None:
    matter = rig.one_part("tet4", rig.ONE_TET, np.array([[0, 1, 2, 3]]), RUBBER)
    state = matter.start()
    before = state.points.copy()
    answer = matter.forces(state, 1.1 * rig.ONE_TET, np.zeros((4, 3)), 0.1)
    np.testing.assert_array_equal(state.points, before)
    np.testing.assert_array_equal(answer.state.points, 1.1 * rig.ONE_TET)
    assert not np.shares_memory(matter.start().points, state.points)
