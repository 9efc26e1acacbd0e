"""Bounds of a surface's derivatives over each element and its smooth neighbours."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contiga.arrays.codes import SMOOTH
from contiga.elements.element_arrays import Records
from contiga.pointer_records import pass_by_pointer
from contiga.records import FloatArray, IndexArray

ORDERS = np.array([[1, 0], [0, 1], [2, 0], [1, 1], [0, 2], [3, 0], [2, 1], [1, 2], [0, 3]])
"""(9, 2) orders in s and t of the derivatives that the leaves bound."""


@pass_by_pointer
class Surroundings(NamedTuple):
    """Blocks of up to 3 × 3 elements of one patch without kinks, one around each of n elements."""

    reach: FloatArray
    """(n, 4) least and greatest s, then t, of the block, in the parameters of its element."""
    bound: FloatArray
    """(n, 9) bounds of the derivatives with respect to these s and t over the block, in the order
    of `ORDERS`; infinite where an element of the block is trimmed away."""


class Blocks(NamedTuple):
    """The part of `Surroundings` that does not depend on the shape."""

    elements: IndexArray
    """(n, 9) elements of each block, with repetitions where it has fewer than nine."""
    reach: FloatArray
    """(n, 4) as in `Surroundings`."""
    scale: FloatArray
    """(n, 9) factors from derivatives with respect to (u, v) to those with respect to (s, t):
    powers of the element's widths."""


def blocks_of(table: Records) -> Blocks:
    """Return the blocks around the elements of a `table`, across smooth sides but no seams."""
    n, box = len(table), table["box"]
    centres, widths = np.arange(n), box[:, 1::2] - box[:, ::2]
    next_element, reach = np.tile(centres[:, None], 4), np.tile([-0.5, 0.5, -0.5, 0.5], (n, 1))
    for side in range(4):
        other, axis = table["neighbour"][:, side], side // 2
        is_smooth = (table["kind"][:, side] == SMOOTH) & (table["patch"][other] == table["patch"])
        is_smooth &= box[other, side ^ 1] == box[:, side]  # not across a seam
        next_element[is_smooth, side] = other[is_smooth]
        extent = (widths[other, axis] / widths[:, axis])[is_smooth]
        reach[is_smooth, side] += extent if side % 2 else -extent
    corners = [next_element[next_element[:, i], j] for i in (0, 1) for j in (2, 3)]
    scale = widths[:, :1] ** ORDERS[:, 0] * widths[:, 1:] ** ORDERS[:, 1]
    return Blocks(np.column_stack([centres, next_element, *corners]), reach, scale)


def surroundings_of(blocks: Blocks, leaves: Records) -> Surroundings:
    """Return bounds of the derivatives over the block around each element, in its (s, t).

    They are the largest bounds of the leaves in the block, and infinite if an element of the block
    is trimmed away.
    """
    on_face = leaves["element"] >= 0
    elements, bound = leaves["element"][on_face], np.zeros(blocks.scale.shape)
    np.maximum.at(bound, elements, leaves["bound"][on_face])
    trimmed = np.ones(len(bound), np.bool_)
    trimmed[elements] = False
    bound[trimmed] = np.inf  # elements that are trimmed away have no leaves, so no bounds
    around = (bound / blocks.scale)[blocks.elements].max(axis=1)
    return Surroundings(blocks.reach, around * blocks.scale)
