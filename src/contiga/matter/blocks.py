"""Elements laid out in blocks of lanes, and the order in which forces are summed at nodes."""

from __future__ import annotations

from math import ceil
from typing import NamedTuple

import numpy as np

from contiga.arrays.layout import locked
from contiga.arrays.threads import run_ranges
from contiga.jit import straight
from contiga.matter.kernels import lanes_nb
from contiga.matter.kernels.lanes_nb import LANES
from contiga.matter.protocol import MatterState
from contiga.matter.tables import BlockSums, Memory
from contiga.records import FloatArray, IntArray

MIN_NODES = 2000
"""Least number of nodes for a thread."""


class NodeSums(NamedTuple):
    """Rows, of all blocks of all groups of elements, that are summed at each node."""

    starts: IntArray
    """(m + 1,) place in `rows` at which those of a node begin."""
    rows: IntArray
    """(r,) in the order in which they are summed."""


def count_blocks(n: int) -> int:
    """Return the number of blocks of n elements."""
    return ceil(n / LANES)


def in_lanes(values: FloatArray, padding: FloatArray | None = None) -> FloatArray:
    """Return columns (n, c) of elements as (b, c · LANES), each column LANES numbers.

    The last block is padded with the row of the last element, or with `padding` (c,).
    """
    n, columns = values.shape
    full = np.empty((count_blocks(n) * LANES, columns))
    full[:n] = values
    full[n:] = values[-1] if padding is None else padding
    blocks = full.reshape(-1, LANES, columns).transpose(0, 2, 1)
    return np.ascontiguousarray(blocks).reshape(len(blocks), -1)


def nodes_in_lanes(elements: IntArray) -> IntArray:
    """Return corners (n, k) as (b, k, LANES), the last block padded with the last element."""
    n, corners = elements.shape
    blocks = count_blocks(n)
    full = np.concatenate([elements, np.repeat(elements[-1:], blocks * LANES - n, axis=0)])
    lanes = full.reshape(blocks, LANES, corners).transpose(0, 2, 1)
    return np.ascontiguousarray(lanes, dtype=np.int32)


def block_sums(elements: IntArray, n_nodes: int) -> tuple[BlockSums, IntArray]:
    """Return the sums in blocks of elements (n, k), and the node (r,) of each row.

    The rows of a block are its nodes, ascending; lanes are summed in the order of elements.
    """
    n, corners = elements.shape
    lane, block = np.arange(n) % LANES, np.arange(n) // LANES
    keys = (block[:, None] * np.int64(n_nodes) + elements).ravel()
    places = (3 * np.arange(corners)[None, :] * LANES + lane[:, None]).ravel()
    order = np.argsort(keys, kind="stable")
    rows, starts = np.unique(keys[order], return_index=True)
    blocks = np.searchsorted(rows, np.arange(count_blocks(n) + 1) * np.int64(n_nodes))
    sums = BlockSums(
        blocks.astype(np.int32),
        np.append(starts, len(keys)).astype(np.int32),
        places[order].astype(np.int32),
    )
    return sums, (rows % n_nodes).astype(np.int32)


def node_sums(nodes_of_rows: IntArray, n_nodes: int) -> NodeSums:
    """Return the sums of rows at nodes, each in the order of the rows."""
    starts = np.zeros(n_nodes + 1, np.int32)
    np.cumsum(np.bincount(nodes_of_rows, minlength=n_nodes), out=starts[1:])
    return NodeSums(starts, np.argsort(nodes_of_rows, kind="stable").astype(np.int32))


def sum_at_nodes(partial: FloatArray, sums: NodeSums) -> FloatArray:
    """Return the sums (m, 3) at the nodes of the rows `partial` (r, 3) of all blocks."""
    out = np.empty((len(sums.starts) - 1, 3))
    run_ranges(straight(lanes_nb.sum_at_nodes), len(out), MIN_NODES, partial, *sums, out)
    return out


def memory_of(blocks: int, places: slice, state: MatterState, new: FloatArray) -> Memory:
    """Return the `places` of a group of elements in the memory of a state, and in `new` memory.

    Both are views, the old one read-only.
    """
    old = state.memory[places].reshape(blocks, -1)
    return Memory(locked(old), new[places].reshape(blocks, -1))
