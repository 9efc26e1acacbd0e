"""Strains and stored energies of elements: closed forms, and sums against those of a step."""

from __future__ import annotations

import numpy as np
import pytest
from tests.blocks import block

from contiga.materials import Belt, Elastic, Fabric, Foam, NeoHooke
from contiga.matter import Assembled, Part, assemble
from contiga.matter.element_fields import ElementFields, KindFields, at_facets, at_nodes
from contiga.matter.strain import largest_principal

CELLS = {"tet4": "tetra", "hex8": "hexahedron"}
STRETCH = np.array([1.2, 0.9, 1.05])
GREEN = 0.5 * (STRETCH**2 - 1.0)
LINE = np.array([[0.0, 0.0], [0.1, 0.2], [0.5, 0.8]])


def _turned(angle: float = 0.7) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    about_z = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    return about_z @ np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])


def _solid(kind: str, material: object) -> Assembled:
    slave = block((4, 3, 3), (1.0, 2.0, 3.0), kind=CELLS[kind])
    elements = np.asarray(slave.elements[CELLS[kind]])
    return assemble(
        slave.points, [Part(kind=kind, elements=elements, material=material, density=1.0)]
    )


def _flat(kind: str, material: object) -> Assembled:
    nodes = np.array([[0.0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0]])
    triangles = kind == "tri3"
    elements = [[0, 1, 2], [0, 2, 3]] if triangles else [[0, 1], [1, 2], [2, 3]]
    return assemble(
        nodes,
        [
            Part(
                kind=kind,
                elements=np.array(elements),
                material=material,
                density=1.0,
                thickness=0.1 if triangles else None,
                section=None if triangles else 0.3,
            )
        ],
    )


def _stored(matter: Assembled, q: np.ndarray) -> tuple[float, float]:
    """What a step there stores, and the sum over the elements."""
    answer = matter.forces(matter.start(), q, np.zeros_like(q), 1.0)
    inside = matter.element_fields(answer.state)
    whole = sum(float((one.volumes * one.fields.energy_density).sum()) for one in inside)
    return answer.energy.strain + answer.energy.hourglass, whole


@pytest.mark.parametrize("kind", CELLS)
@pytest.mark.parametrize("volume", ["element", "nodes"])
def test_a_turned_stretch_has_its_strain_and_energy(kind: str, volume: str) -> None:
    young, poisson = 3.0, 0.4
    mu, lam = young / 2.8, young * 0.4 / (1.4 * 0.2)
    matter = _solid(kind, NeoHooke(young=young, poisson=poisson, volume=volume))
    q = (matter.nodes * STRETCH) @ _turned().T
    fields = matter.nodal_fields(matter.forces(matter.start(), q, 0.0 * q, 1.0).state)
    J = STRETCH.prod()
    exact = 0.5 * mu * ((STRETCH**2).sum() - 3.0) - mu * np.log(J) + 0.5 * lam * (J - 1.0) ** 2
    np.testing.assert_allclose(fields.energy_density, exact, rtol=1e-9)
    np.testing.assert_allclose(fields.strain[:, :3], np.tile(GREEN, (len(q), 1)), atol=1e-12)
    np.testing.assert_allclose(fields.strain[:, 3:], 0.0, atol=1e-12)
    np.testing.assert_allclose(largest_principal(fields.strain), 0.22, atol=1e-8)


def test_shear_has_its_tensor_strain() -> None:
    matter = _solid("hex8", Elastic(young=1.0))
    q = matter.nodes + 0.2 * matter.nodes[:, [1]] * [1.0, 0.0, 0.0]
    strain = matter.nodal_fields(matter.forces(matter.start(), q, 0.0 * q, 1.0).state).strain
    np.testing.assert_allclose(strain, np.tile([0, 0.02, 0, 0.1, 0, 0], (len(q), 1)), atol=1e-12)


@pytest.mark.parametrize("kind", CELLS)
@pytest.mark.parametrize("material", [
    Elastic(young=2.0, poisson=0.3),
    NeoHooke(young=2.0, poisson=0.45, volume="nodes"),
    Foam(loading=np.array([[0.0, 0.0], [0.5, 0.4], [0.9, 4.0]]), hysteresis=0.2, tension=1.0),
])  # fmt: skip
def test_elements_store_together_what_a_step_stores(kind: str, material: object) -> None:
    matter = _solid(kind, material)
    q = matter.nodes * [1.1, 0.9, 0.95]
    q += 0.05 * np.random.default_rng(5).uniform(-1.0, 1.0, q.shape)
    step, whole = _stored(matter, q)
    assert step > 0.0
    np.testing.assert_allclose(whole, step, rtol=1e-12)


@pytest.mark.parametrize(("kind", "material"), [
    ("tri3", Elastic(young=5.0, poisson=0.3, compression=False)),
    ("tri3", Fabric(warp=LINE, weft=LINE, shear=LINE, direction=[1.0, 0.0, 0.0])),
    ("bar2", Belt(loading=LINE)),
    ("bar2", Elastic(young=5.0)),
])  # fmt: skip
def test_so_do_membranes_and_bars(kind: str, material: object) -> None:
    matter = _flat(kind, material)
    step, whole = _stored(matter, (matter.nodes * [1.1, 1.03, 1.0]) @ _turned().T)
    assert step > 0.0
    np.testing.assert_allclose(whole, step, rtol=1e-12)


@pytest.mark.parametrize("kind", ["tri3", "bar2"])
def test_strains_of_membranes_and_bars_are_in_their_plane_and_along_them(kind: str) -> None:
    matter = _flat(kind, Elastic(young=5.0))
    turned = assemble(
        matter.nodes @ _turned(0.4).T,
        [Part(kind=kind, elements=matter.groups[0].elements, material=Elastic(young=5.0),
              density=1.0, **{"thickness" if kind == "tri3" else "section": 0.3})],
    )  # fmt: skip
    q = (matter.nodes * [1.2, 0.9, 1.0]) @ _turned(1.1).T
    state = turned.start()._replace(points=q)
    own = _turned(0.4)
    six = turned.element_fields(state)[0].fields.strain
    whole = own.T @ six[:, [[0, 3, 5], [3, 1, 4], [5, 4, 2]]] @ own
    along, across = np.diag([0.22, 0.0, 0.0]), np.diag([0.0, -0.095, 0.0])
    exact = [along + across] * 2 if kind == "tri3" else [along, across, along]
    np.testing.assert_allclose(whole, exact, atol=1e-12)


def test_facets_have_their_elements_and_nodes_the_means_of_them() -> None:
    """Two hexahedra, the second of three times the volume, and a triangle of no element."""
    slave = block((2, 1, 1), (2.0, 1.0, 1.0), kind="hexahedron")
    cells = np.asarray(slave.elements["hexahedron"])
    values = np.array([1.0, 5.0])
    own = ElementFields(np.zeros((2, 6)), np.zeros((2, 6)), values)
    groups = [KindFields(cells, np.array([1.0, 3.0]), own)]
    facets = np.concatenate([slave.facets, [[0, 1, len(slave) - 1]]])
    told = at_facets(groups, facets).energy_density
    middle = slave.points[slave.facets].mean(axis=1)[:, 0]
    np.testing.assert_array_equal(told[:-1], np.where(middle < 1.0, 1.0, 5.0))
    assert np.isnan(told[-1])
    nodes = at_nodes(groups, len(slave) + 1).energy_density
    exact = np.select([slave.points[:, 0] < 0.5, slave.points[:, 0] > 1.5], [1.0, 5.0], 4.0)
    np.testing.assert_allclose(nodes[:-1], exact)
    assert np.isnan(nodes[-1])


def test_the_largest_principal_value_is_that_of_lapack() -> None:
    six = np.random.default_rng(2).normal(size=(500, 6))
    six[:100, 3:] = 0.0
    six[:50, 1] = six[:50, 0]
    six[0] = 0.0
    exact = np.linalg.eigvalsh(six[:, [[0, 3, 5], [3, 1, 4], [5, 4, 2]]])[:, 2]
    np.testing.assert_allclose(largest_principal(six), exact, atol=1e-7)
    assert np.isnan(largest_principal(np.full((1, 6), np.nan))).all()
