"""Bounds of the derivatives of a surface around each of its elements."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contiga.arrays.codes import SMOOTH
from contiga.elements.element_arrays import Records
from contiga.pointer_records import pass_by_pointer
from contiga.records import FloatArray, IndexArray

ORDERS = np.array([[1, 0], [0, 1], [2, 0], [1, 1], [0, 2], [3, 0], [2, 1], [1, 2], [0, 3]])
"""Orders in s and t of the derivatives that leaves bound."""


@pass_by_pointer
class Surroundings(NamedTuple):
    """Each element with those around it, three by three at most, of its patch and without kinks."""

    reach: FloatArray
    """(n, 4) how far they go: lowest and highest s, lowest and highest t, in the element's own."""
    bound: FloatArray
    """(n, 9) bounds of the derivatives over all of them by the element's s and t, as of `LEAF`."""


class Blocks(NamedTuple):
    """What surroundings are made of, in any shape."""

    elements: IndexArray
    """(n, 9) the elements; where there is none a number twice."""
    reach: FloatArray
    """(n, 4) as of `Surroundings`."""
    scale: FloatArray
    """(n, 9) powers of the widths of elements that derivatives by (s, t) have and those by (u, v)
    have not."""


def blocks_of(table: Records) -> Blocks:
    """Find the elements around those of a `table`."""
    n, box = len(table), table["box"]
    here, widths = np.arange(n), box[:, 1::2] - box[:, ::2]
    beside, reach = np.tile(here[:, None], 4), np.tile([-0.5, 0.5, -0.5, 0.5], (n, 1))
    for side in range(4):
        other, axis = table["neighbour"][:, side], side // 2
        goes_on = (table["kind"][:, side] == SMOOTH) & (table["patch"][other] == table["patch"])
        goes_on &= box[other, side ^ 1] == box[:, side]  # not across a seam
        beside[goes_on, side] = other[goes_on]
        share = (widths[other, axis] / widths[:, axis])[goes_on]
        reach[goes_on, side] += share if side % 2 else -share
    corners = [beside[beside[:, i], j] for i in (0, 1) for j in (2, 3)]
    scale = widths[:, :1] ** ORDERS[:, 0] * widths[:, 1:] ** ORDERS[:, 1]
    return Blocks(np.column_stack([here, beside, *corners]), reach, scale)


def surroundings_of(blocks: Blocks, leaves: Records) -> Surroundings:
    """Bound the derivatives around the elements in a shape that has these leaves."""
    on_face = leaves["element"] >= 0
    elements, bound = leaves["element"][on_face], np.zeros(blocks.scale.shape)
    np.maximum.at(bound, elements, leaves["bound"][on_face])
    trimmed = np.ones(len(bound), np.bool_)
    trimmed[elements] = False
    bound[trimmed] = np.inf  # trims leave nothing of them, and nothing is known of them
    around = (bound / blocks.scale)[blocks.elements].max(axis=1)
    return Surroundings(blocks.reach, around * blocks.scale)
