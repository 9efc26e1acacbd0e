"""Matrices between the corners of facets, against the products of full matrices."""

from __future__ import annotations

import numpy as np
import pytest
from tests.blocks import block

import contiga as cg
from contiga.slaves.kernels import facet_blocks_nb
from contiga.slaves.sampling import Sampling


@pytest.mark.interpreted
def test_each_block_goes_between_all_corners_of_its_face() -> None:
    rng = np.random.default_rng(0)
    shape = rng.dirichlet(np.ones(3), 2)
    places = np.arange(18, dtype=np.int32).reshape(2, 3, 3)
    used, out = np.zeros(18, np.int8), np.zeros((18, 3, 3))
    faces, points = np.array([1, 1]), np.array([0, 1])
    blocks = rng.normal(size=(2, 3, 3))
    facet_blocks_nb.mark(places, faces, used)
    assert used.tolist() == [0] * 9 + [1] * 9
    facet_blocks_nb.add(blocks, faces, points, shape, places, out)
    wanted = np.einsum("ka,kb,kcd->abcd", shape, shape, blocks).reshape(9, 3, 3)
    np.testing.assert_allclose(out[9:], wanted, rtol=1e-13, atol=1e-15)
    assert not out[:9].any()


@pytest.mark.parametrize("kind", ["tetra", "hexahedron"])
@pytest.mark.parametrize("points", [None, 1, 3])
def test_the_matrix_over_nodes_is_that_of_the_mean_places(kind: str, points: int | None) -> None:
    slave = block((2, 1, 1), (2.0, 1.0, 1.0), kind=kind)
    sampling = Sampling(slave, None, points)
    rng = np.random.default_rng(1)
    rows = np.arange(sampling.first, sampling.n_points)
    rows = rows[rng.random(len(rows)) < 0.4]
    blocks = rng.normal(size=(len(rows), 3, 3))
    found = sampling.matrix(rows, blocks).toarray()
    shape = np.array(
        [sampling.points(np.eye(len(slave))[:, [j] * 3])[rows, 0] for j in range(len(slave))]
    )
    wanted = np.einsum("aq,bq,qcd->acbd", shape, shape, blocks).reshape(found.shape)
    np.testing.assert_allclose(found, wanted, rtol=0.0, atol=1e-13)


def test_of_no_points_there_are_no_entries() -> None:
    for slave, points in (
        (block((1, 1, 1), (1.0, 1.0, 1.0)), 3),
        (cg.Slave(np.zeros((4, 3))), None),
    ):
        matrix = Sampling(slave, None, points).matrix(np.zeros(0, np.int32), np.zeros((0, 3, 3)))
        assert matrix.nnz == 0
        assert matrix.shape == (3 * len(slave), 3 * len(slave))
