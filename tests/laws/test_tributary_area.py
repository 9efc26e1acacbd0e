"""Laws of the area a node is given, on random triangulations."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from tests.blocks import facet_areas

from contiga.slaves.skin import CellBlock, skin, tributary_area
from contiga.slaves.slave import Slave

finite = st.floats(-1e3, 1e3)


@st.composite
def triangulations(draw):
    """Points and triangles on them, crossing, doubled and flat ones included."""
    n = draw(st.integers(3, 20))
    points = draw(hnp.arrays(np.float64, (n, 3), elements=finite))
    m = draw(st.integers(1, 30))
    facets = draw(hnp.arrays(np.int32, (m, 3), elements=st.integers(0, n - 1)))
    return points, facets


@given(triangulations())
def test_the_sum_over_nodes_is_the_area_of_the_facets(mesh):
    points, facets = mesh
    total = facet_areas(points, facets).sum()
    area = tributary_area(points, facets)
    assert area.shape == (len(points),)
    assert (area >= 0.0).all()
    assert abs(area.sum() - total) <= 1e-14 * (1 + len(facets)) * max(total, 1e-300)


@given(triangulations(), st.randoms(use_true_random=False))
def test_numbering_of_nodes_facets_and_corners_does_not_matter(mesh, random):
    points, facets = mesh
    area = tributary_area(points, facets)
    order = list(range(len(points)))
    random.shuffle(order)
    rank = np.empty(len(order), dtype=np.int32)
    rank[order] = np.arange(len(order), dtype=np.int32)
    shuffled = rank[facets][::-1, [1, 2, 0]]
    again = tributary_area(points[order], shuffled)
    assert np.allclose(again[rank], area, rtol=1e-9, atol=1e-9 * (1e-12 + area.sum()))


@given(triangulations(), st.floats(1e-3, 1e3))
def test_scaling_lengths_scales_areas_by_the_square(mesh, factor):
    points, facets = mesh
    slave = Slave(points, facets)
    fresh = Slave(points * factor, facets)
    assert np.allclose(
        slave.scaled(factor).area, fresh.area, rtol=1e-9, atol=1e-12 * factor**2 * 1e6
    )


@given(st.integers(1, 3), st.integers(1, 3), st.integers(1, 3), st.randoms(use_true_random=False))
def test_the_skin_of_a_block_does_not_depend_on_how_its_cells_are_written(nx, ny, nz, random):
    shape = (nx + 1, ny + 1, nz + 1)
    points = np.stack(np.meshgrid(*map(np.arange, shape), indexing="ij"), -1).reshape(-1, 3) * 1.0
    index = np.arange(len(points)).reshape(shape)
    corners = [
        (0, 0, 0),
        (1, 0, 0),
        (1, 1, 0),
        (0, 1, 0),
        (0, 0, 1),
        (1, 0, 1),
        (1, 1, 1),
        (0, 1, 1),
    ]
    cells = [
        [index[i + a, j + b, k + c] for a, b, c in corners]
        for i in range(nx)
        for j in range(ny)
        for k in range(nz)
    ]
    turns = ([0, 1, 2, 3, 4, 5, 6, 7], [1, 2, 3, 0, 5, 6, 7, 4], [4, 5, 1, 0, 7, 6, 2, 3])
    written = [[cell[i] for i in random.choice(turns)] for cell in cells]
    random.shuffle(written)
    # Some are told twice inside out: the skin's sense comes from the volume.
    written = [cell[4:] + cell[:4] if random.random() < 0.3 else cell for cell in written]
    facets = skin(points, [CellBlock("hexahedron", np.array(written))])
    a, b, c = (points[facets[:, i]] for i in range(3))
    assert np.isclose(facet_areas(points, facets).sum(), 2 * (nx * ny + ny * nz + nz * nx))
    assert np.isclose(np.einsum("ij,ij->", a, np.cross(b, c)) / 6, nx * ny * nz)
