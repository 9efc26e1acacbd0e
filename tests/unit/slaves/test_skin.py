"""Skins of single cells and small meshes whose surfaces are known by hand."""

from __future__ import annotations

import numpy as np
import pytest
from tests.blocks import facet_areas

from contiga.slaves.cells import N_NODES, SHELLS, SOLIDS, split_quads, split_shells
from contiga.slaves.skin import CellBlock, mend_degenerate, skin, tributary_area

CUBE = np.array(
    [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], float
)
UP = np.array([0.0, 0.0, 1.0])
# Corners of one cell of each shape, with its volume and area.
SHAPES = {
    "tetra": (CUBE[[0, 1, 3, 4]], 1 / 6, 1.5 + np.sqrt(3) / 2),
    "hexahedron": (CUBE, 1.0, 6.0),
    "wedge": (CUBE[[0, 1, 3, 4, 5, 7]], 0.5, 3.0 + np.sqrt(2)),
    "pyramid": (CUBE[[0, 1, 2, 3, 4]], 1 / 3, 2.0 + np.sqrt(2)),
}


def block(kind, *cells):
    return CellBlock(kind, np.array(cells, dtype=np.int64))


def cell(kind):
    """One straight-sided cell of `kind`: nodes on edges and faces at their middles."""
    shape = kind.rstrip("0123456789")
    corners = SHAPES[shape][0]
    solid = SOLIDS[kind]
    points = np.full((solid.n_nodes, 3), np.nan)
    points[: len(corners)] = corners
    for face, on_corners in zip(solid.faces, solid.corner_faces, strict=True):
        n = len(on_corners)
        for i, node in enumerate(face[n : 2 * n]):
            points[node] = 0.5 * (points[face[i]] + points[face[(i + 1) % n]])
        for node in face[2 * n :]:
            points[node] = points[list(on_corners)].mean(axis=0)
    if kind == "hexahedron27":
        points[26] = 0.5
    return points


def volume(points, facets):
    """Divergence theorem; positive for outward normals."""
    a, b, c = (points[facets[:, i]] for i in range(3))
    return np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0


def edge_counts(facets):
    edges = np.sort(facets[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    return np.unique(edges, axis=0, return_counts=True)[1]


@pytest.mark.parametrize("kind", SOLIDS)
def test_a_single_solid_has_a_closed_outward_skin_of_its_own_area_and_volume(kind):
    points = cell(kind)
    facets = skin(points, [block(kind, np.arange(N_NODES[kind]))])
    _, own_volume, own_area = SHAPES[kind.rstrip("0123456789")]
    assert (edge_counts(facets) == 2).all()
    assert volume(points, facets) == pytest.approx(own_volume, rel=1e-14)
    assert facet_areas(points, facets).sum() == pytest.approx(own_area, rel=1e-14)


@pytest.mark.parametrize("kind", SOLIDS)
def test_every_node_of_a_quadratic_solid_but_its_centre_is_on_its_skin(kind):
    facets = skin(cell(kind), [block(kind, np.arange(N_NODES[kind]))])
    surface = N_NODES[kind] - (1 if kind == "hexahedron27" else 0)
    assert set(facets.ravel().tolist()) == set(range(surface))


@pytest.mark.parametrize("kind", SOLIDS)
def test_a_solid_turned_inside_out_still_has_an_outward_skin(kind):
    points = cell(kind) * [1.0, 1.0, -1.0]
    facets = skin(points, [block(kind, np.arange(N_NODES[kind]))])
    assert volume(points, facets) == pytest.approx(SHAPES[kind.rstrip("0123456789")][1], rel=1e-14)


def test_face_between_two_solids_is_not_skin():
    points = np.vstack([CUBE, CUBE[4:] + UP])
    facets = skin(points, [block("hexahedron", range(8), [4, 5, 6, 7, 8, 9, 10, 11])])
    assert len(facets) == 20
    assert volume(points, facets) == pytest.approx(2.0)
    assert (edge_counts(facets) == 2).all()


def test_linear_and_quadratic_solids_share_a_face_by_its_corners():
    upper = cell("hexahedron20") + UP
    points = np.vstack([CUBE, upper])
    nodes = 8 + np.arange(20)
    nodes[:4] = 4, 5, 6, 7  # the upper cell stands on the corners of the lower one
    facets = skin(points, [block("hexahedron", range(8)), block("hexahedron20", nodes)])
    assert facet_areas(points, facets).sum() == pytest.approx(10.0)


def test_hexahedron_and_pyramid_meet_on_a_quadrilateral():
    points = np.vstack([CUBE, [[0.5, 0.5, 2.0]]])
    facets = skin(points, [block("hexahedron", range(8)), block("pyramid", [4, 5, 6, 7, 8])])
    assert volume(points, facets) == pytest.approx(1.0 + 1 / 3)
    assert (edge_counts(facets) == 2).all()


@pytest.mark.parametrize(
    ("nodes", "own_volume"),
    [
        ([0, 1, 3, 4, 4, 4, 4, 4], 1 / 6),  # LS-DYNA's tetrahedron
        ([1, 0, 3, 4, 4, 4, 4, 4], 1 / 6),  # its folded base would split the wrong way
        ([0, 1, 3, 3, 4, 4, 4, 4], 1 / 6),  # and other codes'
        ([0, 1, 2, 3, 4, 4, 4, 4], 1 / 3),  # pyramid
        ([0, 1, 2, 3, 4, 4, 7, 7], 0.5),  # LS-DYNA's wedge
        ([0, 1, 3, 3, 4, 5, 7, 7], 0.5),
    ],
)
def test_collapsed_hexahedra_have_the_skin_of_what_they_stand_for(nodes, own_volume):
    facets = skin(CUBE, mend_degenerate(block("hexahedron", nodes)))
    assert volume(CUBE, facets) == pytest.approx(own_volume, rel=1e-14)
    assert (edge_counts(facets) == 2).all()


def test_shell_keeps_its_sense():
    up = skin(CUBE, [block("quad", [0, 1, 2, 3])])
    down = skin(CUBE, [block("quad", [3, 2, 1, 0])])
    for facets, sign in ((up, 1.0), (down, -1.0)):
        a, b, c = (CUBE[facets[:, i]] for i in range(3))
        assert (np.cross(b - a, c - a)[:, 2] * sign > 0.0).all()


def test_shell_on_a_solid_adds_no_second_layer():
    solid = block("hexahedron", range(8))
    shells = block("quad", [4, 5, 6, 7], [0, 1, 5, 4])
    alone = skin(CUBE, [solid])
    assert facet_areas(CUBE, skin(CUBE, [shells, solid])).sum() == pytest.approx(
        facet_areas(CUBE, alone).sum()
    )


def test_shell_between_two_solids_is_not_skin():
    points = np.vstack([CUBE, CUBE[4:] + UP])
    solids = block("hexahedron", range(8), [4, 5, 6, 7, 8, 9, 10, 11])
    assert len(skin(points, [solids, block("quad", [4, 5, 6, 7])])) == 20


def test_the_same_shell_twice_counts_once():
    facets = skin(CUBE, [block("quad", [0, 1, 2, 3]), block("quad", [2, 1, 0, 3])])
    assert facet_areas(CUBE, facets).sum() == pytest.approx(1.0)


def test_lines_and_no_cells_have_no_skin():
    assert skin(CUBE, []).shape == (0, 3)
    assert skin(CUBE, [block("line", [0, 1])]).shape == (0, 3)


def test_quads_split_along_the_shorter_diagonal():
    kite = np.array([[0, 0, 0], [2, -0.5, 0], [4, 0, 0], [2, 0.5, 0]], float)
    for turn in range(4):
        triangles, parent = split_quads(kite, np.roll(np.arange(4), turn)[None].astype(np.int32))
        assert all({1, 3} <= set(row) for row in triangles.tolist())
        assert parent.tolist() == [0, 0]


@pytest.mark.parametrize("kind", SHELLS)
def test_split_shells_cover_the_cell_once_in_its_sense(kind):
    n = SHELLS[kind]
    corners = np.array([[0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0]], float)[:n]
    middles = 0.5 * (corners + np.roll(corners, -1, axis=0))
    points = np.vstack([corners, middles, corners.mean(axis=0)])[: N_NODES[kind]]
    if kind == "triangle7":
        assert len(points) == 7
    triangles, parent = split_shells(points, kind, np.arange(len(points), dtype=np.int32)[None])
    a, b, c = (points[triangles[:, i]] for i in range(3))
    twice = np.cross(b - a, c - a)[:, 2]
    assert (twice > 0.0).all()
    assert 0.5 * twice.sum() == pytest.approx(2.0 if n == 4 else 1.0)
    assert set(triangles.ravel().tolist()) == set(range(len(points)))
    assert (parent == 0).all()


def test_quad_with_two_equal_nodes_is_one_triangle():
    for nodes in ([0, 1, 2, 2], [0, 0, 1, 2], [0, 1, 1, 2], [0, 1, 2, 0]):
        triangles, _ = split_shells(CUBE, "quad", np.array([nodes], dtype=np.int32))
        assert len(triangles) == 1
        assert set(triangles[0].tolist()) == {0, 1, 2}


def test_tributary_area_of_a_square_of_two_triangles():
    area = tributary_area(CUBE, np.array([[0, 1, 2], [0, 2, 3]], dtype=np.int32))
    assert area == pytest.approx([1 / 3, 1 / 6, 1 / 3, 1 / 6, 0, 0, 0, 0])
