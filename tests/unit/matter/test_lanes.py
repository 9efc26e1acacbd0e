"""Forces of elements summed at nodes: in one order, whatever the threads."""

from __future__ import annotations

import numpy as np
import pytest
from benchmarks.timing import on_threads
from tests.unit.matter import rig

from contiga.materials import NeoHooke
from contiga.matter.blocks import block_sums, in_lanes, node_sums, nodes_in_lanes
from contiga.matter.kernels import lanes_nb
from contiga.matter.kernels.lanes_nb import LANES


@pytest.mark.interpreted
def test_sums_at_nodes_are_those_of_rows() -> None:
    rng = np.random.default_rng(0)
    nodes = rng.integers(0, 30, 200).astype(np.int32)
    partial, out = rng.normal(size=(200, 3)), np.empty((31, 3))
    starts, rows = node_sums(nodes, 31)
    lanes_nb.sum_at_nodes(partial, starts, rows, out, 0, 31)
    expected = np.zeros((31, 3))
    np.add.at(expected, nodes, partial)
    np.testing.assert_array_equal(out, expected)


def test_blocks_know_their_lanes_and_nodes() -> None:
    rng = np.random.default_rng(0)
    elements = np.argsort(rng.random((150, 40)), axis=1)[:, :4].astype(np.int32)
    sums, nodes = block_sums(elements, 40)
    lanes = nodes_in_lanes(elements)
    seen = 0
    for b in range(3):
        for k in range(sums.blocks[b], sums.blocks[b + 1]):
            for place in sums.places[sums.starts[k] : sums.starts[k + 1]]:
                corner, rest = divmod(int(place), 3 * LANES)
                assert rest < LANES
                assert lanes[b, corner, rest] == nodes[k]
                seen += 1
    assert seen == elements.size == len(sums.places)


def test_columns_of_elements_lie_one_after_the_other() -> None:
    values = np.arange(2.0 * 70).reshape(70, 2)
    lanes = in_lanes(values, np.array([-1.0, -2.0]))
    assert lanes.shape == (2, 2 * LANES)
    np.testing.assert_array_equal(lanes[1, :6], values[64:, 0])
    np.testing.assert_array_equal(lanes[1, 6:LANES], -1.0)
    np.testing.assert_array_equal(lanes[0, LANES:], values[:64, 1])


def test_the_same_bits_on_any_number_of_threads() -> None:
    counts = (10, 10, 10)
    nodes = rig.grid(counts)
    matter = rig.one_part("tet4", nodes, rig.tets(counts), NeoHooke(young=1.0, poisson=0.3))
    q = rig.moved(nodes, 0.005)
    with on_threads(1):
        one, stiff = rig.still(matter, q), matter.stiffness(matter.start())
    for _ in range(3):
        two = rig.still(matter, q)
        assert two[0].tobytes() == one[0].tobytes()
        assert two[1] == one[1]
    assert matter.stiffness(matter.start()).tobytes() == stiff.tobytes()
