"""Real meshes: counts of the manifest, closed skins, volumes by two ways, two readers of a deck."""

from __future__ import annotations

import meshio
import numpy as np
import pytest
from tests.blocks import facet_areas

from contiga.io.mesh import lsdyna
from contiga.io.mesh.lsdyna_cards import read_blocks
from contiga.io.mesh.read_mesh import read_mesh
from contiga.slaves.cells import split_shells
from contiga.slaves.mesh_summary import mesh_summary

TYRE = "hmmwv_lugged_tyre_c3d10.inp"
TORUS = "torus_tet4.vtk"
DUMMY = "belted_dummy.k"
_TETRA6_FACES = np.array(
    [[0, 2, 1, 6, 5, 4], [0, 1, 3, 4, 8, 7], [1, 2, 3, 5, 9, 8], [2, 0, 3, 6, 7, 9]]
)


def edge_counts(facets):
    edges = np.sort(facets[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    return np.unique(edges, axis=0, return_counts=True)[1]


def enclosed(points, facets):
    a, b, c = (points[facets[:, i]] for i in range(3))
    return np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0


def tetra_volumes(points, corners):
    a, b, c, d = (points[corners[:, i]] for i in range(4))
    return np.linalg.det(np.stack([b - a, c - a, d - a], axis=1)) / 6.0


def curved_tetra_volumes(points, nodes):
    """Volumes of quadratic tetrahedra, exact: their Jacobian is a cubic.

    Degree-3 rule on the tetrahedron with one negative weight (Keast 1986, rule 2).
    """
    barycentric = np.full((5, 4), 1 / 6)
    barycentric[0] = 1 / 4
    barycentric[np.arange(1, 5), np.arange(4)] = 1 / 2
    weights = np.array([-4 / 5, 9 / 20, 9 / 20, 9 / 20, 9 / 20]) / 6
    pairs = [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)]
    total = np.zeros(len(nodes))
    for at, weight in zip(barycentric, weights, strict=True):
        slopes = np.zeros((10, 4))  # of the shape functions in the barycentric coordinates
        for i in range(4):
            slopes[i, i] = 4 * at[i] - 1
        for k, (i, j) in enumerate(pairs, start=4):
            slopes[k, i], slopes[k, j] = 4 * at[j], 4 * at[i]
        along = slopes[:, 1:] - slopes[:, :1]
        jacobian = np.einsum("mni,nj->mij", points[nodes], along)
        total += weight * np.linalg.det(jacobian)
    return total


def test_tyre_has_the_nodes_and_cells_of_the_manifest(data_dir):
    slave = read_mesh(data_dir / TYRE)
    summary = mesh_summary(slave)
    assert summary["nodes"] == 21_359
    assert summary["cells"] == {"tetra10": 11_171}
    assert [part["label"] for part in summary["parts"]] == [
        "PART1_EG1",
        "BC_INT",
        "BC_CONN",
        "NSET1",
    ]
    lowest, highest = np.array(summary["bounds"])
    assert highest - lowest == pytest.approx([0.53, 1.42, 1.42], abs=5e-3)


def test_tyre_skin_is_closed_and_holds_the_volume_of_its_tetrahedra(data_dir):
    slave = read_mesh(data_dir / TYRE)
    assert (edge_counts(slave.facets) == 2).all()
    cells = meshio.read(data_dir / TYRE).cells_dict["tetra10"]
    # Every tetrahedron with its faces split as the skin's: what they share cancels.
    own = sum(
        enclosed(slave.points, split_shells(slave.points, "triangle6", cells[:, face])[0])
        for face in _TETRA6_FACES
    )
    volume = enclosed(slave.points, slave.facets)
    assert volume == pytest.approx(own, rel=1e-12)
    # The skin is a polyhedron in a curved solid: near, not equal.
    exact = curved_tetra_volumes(slave.points, cells)
    assert (exact > 0.0).all()
    assert volume == pytest.approx(exact.sum(), rel=0.01)


def test_tyre_skin_takes_the_mid_side_nodes_along(data_dir):
    slave = read_mesh(data_dir / TYRE)
    cells = meshio.read(data_dir / TYRE).cells_dict["tetra10"]
    corners = np.unique(cells[:, :4])
    on_skin = np.flatnonzero(slave.active)
    middles = np.setdiff1d(on_skin, corners)
    # A closed skin of F quadratic triangles has 3F/2 edges with a node in the middle of each.
    assert len(middles) == 3 * (len(slave.facets) // 4) // 2
    assert (slave.area[on_skin] > 0.0).all()
    assert (slave.area[~slave.active] == 0.0).all()


def test_area_given_to_the_nodes_of_real_meshes_is_that_of_their_facets(data_dir):
    for name in (TYRE, TORUS, DUMMY):
        slave = read_mesh(data_dir / name)
        total = facet_areas(slave.points, slave.facets).sum()
        assert slave.area.sum() == pytest.approx(total, rel=1e-13)
        assert mesh_summary(slave)["area"] == pytest.approx(total, rel=1e-15)


def test_tyre_inner_surface_is_a_set_of_nodes(data_dir):
    whole = read_mesh(data_dir / TYRE)
    inner = read_mesh(data_dir / TYRE, parts="BC_INT")
    assert inner.active.sum() == 1_130
    assert 0.0 < inner.area.sum() < whole.area.sum()
    assert set(map(tuple, inner.facets.tolist())) < set(map(tuple, whole.facets.tolist()))


def test_torus_skin_is_closed_of_genus_one_and_holds_its_tetrahedra(data_dir):
    slave = read_mesh(data_dir / TORUS)
    assert len(slave) == 115
    assert dict(slave.cells) == {"tetra": 286}
    assert (edge_counts(slave.facets) == 2).all()
    vertices, edges = int(slave.active.sum()), len(edge_counts(slave.facets))
    assert vertices - edges + len(slave.facets) == 0  # Euler characteristic of a torus
    cells = meshio.read(data_dir / TORUS).cells_dict["tetra"]
    volumes = np.abs(tetra_volumes(slave.points, cells))
    assert enclosed(slave.points, slave.facets) == pytest.approx(volumes.sum(), rel=1e-12)


def test_dummy_has_the_nodes_shells_and_parts_of_the_manifest(data_dir):
    slave = read_mesh(data_dir / DUMMY)
    assert len(slave) == 2_043
    assert dict(slave.cells) == {"triangle": 332, "quad": 1_618}
    assert [part.id for part in slave.parts] == list(range(1, 23))
    assert sum(part.n_cells for part in slave.parts) == 1_950
    assert slave.parts[20].name == "part-21"
    assert len(slave.facets) == 332 + 2 * 1_618
    # The deck has no *SECTION_SHELL and no *ELEMENT_MASS.
    assert slave.thickness is None
    assert slave.mass is None


def test_dummy_triangles_are_in_parts_20_and_21(data_dir):
    slave = read_mesh(data_dir / DUMMY, parts=[20, 21])
    cells = {part.id: part.n_cells for part in slave.parts}
    assert len(slave.facets) == cells[20] + cells[21] == 332


def test_areas_of_the_dummys_parts_add_up(data_dir):
    whole = read_mesh(data_dir / DUMMY)
    areas = [read_mesh(data_dir / DUMMY, parts=i).area.sum() for i in range(1, 23)]
    assert sum(areas) == pytest.approx(whole.area.sum(), rel=1e-12)


def test_columns_cards_and_another_library_read_the_same_deck(data_dir):
    deck = pytest.importorskip("lsdyna_mesh_reader").Deck(data_dir / DUMMY)
    blocks = list(read_blocks(data_dir / DUMMY))
    ids, points, (shells,), solids = lsdyna._nodes_and_elements(blocks)
    assert solids == []
    for block in blocks:
        if block.keyword == "NODE":
            by_columns, by_cards = lsdyna._node_columns(block), lsdyna._node_cards(block)
            assert np.array_equal(by_columns[0], by_cards[0])
            assert np.array_equal(by_columns[1], by_cards[1])
        elif block.keyword == "ELEMENT_SHELL":
            by_columns, by_cards = lsdyna._element_columns(block), lsdyna._shell_cards(block)
            assert np.array_equal(by_columns.part, by_cards.part)
            assert np.array_equal(by_columns.nodes, by_cards.nodes)
    section, elements = deck.node_sections[0], deck.element_shell_sections[0]
    assert np.array_equal(ids, section.nid)
    # The library's own number parser is a unit in the last place off now and then.
    assert points == pytest.approx(np.asarray(section.coordinates), rel=1e-15, abs=1e-15)
    assert np.array_equal(shells.part, elements.pid)
