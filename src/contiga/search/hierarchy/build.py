"""Build the leaves and the hierarchy of a body, among which the closest point is searched.

Leaves are pieces of elements and of trimming curves, in boxes.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contiga.arrays.codes import NO_FORM
from contiga.elements.element_arrays import Elements, Grid, Records
from contiga.geometry.trim import TrimTables
from contiga.records import FloatArray, IntArray
from contiga.search.hierarchy.forms import forms_of
from contiga.search.hierarchy.kernels import curve_leaves_nb, hierarchy_nb, plates_nb, tree_nb
from contiga.search.hierarchy.table_types import LEAF, NODE, PLATE, Items, Seeds

# Largest departures of a leaf from its tangent parallelogram, as shares of its larger extent: flat
# leaves save a third of a search, but bodies of many curved faces would take too much memory.
FLATNESSES = (0.125, 0.25)
MAX_FLAT_LEAVES = 200_000
# Largest number of halvings of an element.
MAX_HALVINGS = 9
# Largest number of halvings of a stretch of a trimming piece.
MAX_CURVE_HALVINGS = 8
# Number of voxels of the grid of seeds along its longest side, and its margin around the body.
N_VOXELS = 64
VOXEL_MARGIN = 3


class Hierarchy(NamedTuple):
    """Leaves over every element that is not completely trimmed away, and every trimming piece."""

    leaves: Records
    """`LEAF`, in the order of the hierarchy."""
    plates: Records
    """`PLATE` of each leaf."""
    tree: Records
    """`NODE`, the root first."""
    low: FloatArray
    """(leaves, 3) corners of their boxes."""
    high: FloatArray


def build_hierarchy(elements: Elements, grid: Grid, trims: TrimTables) -> Hierarchy:
    """Build the leaves of a body, their plates, and the hierarchy over their boxes.

    The leaves have the first of `FLATNESSES` that needs at most `MAX_FLAT_LEAVES` of them, or the
    last. Their boxes are widened by four roundings of the largest coordinate, boxes of faces also
    by the `edge_tolerance` of their element. All rows are in the order of the hierarchy.
    """
    for flatness in FLATNESSES:
        faces = hierarchy_nb.surface_leaves(elements, flatness, MAX_HALVINGS)
        curves = curve_leaves_nb.curve_leaves(elements, grid, trims, flatness, MAX_CURVE_HALVINGS)
        rows = np.concatenate([faces, curves])
        if len(rows) <= MAX_FLAT_LEAVES:
            break
    element = rows[:, 0].astype(np.int32)
    box, bound, low, high = np.split(rows[:, 1:], [4, 13, 16], axis=1)
    # A face reaches beyond its edges by their width.
    on_face = element >= 0
    edge_tolerance = elements.table["edge_tolerance"][element[on_face], None]
    low[on_face] -= edge_tolerance
    high[on_face] += edge_tolerance
    reach = max(float(np.abs(low).max(initial=0.0)), float(np.abs(high).max(initial=0.0)))
    margin = 4.0 * np.finfo(float).eps * reach
    tree, order = tree_over(low - margin, high + margin)
    leaves = np.zeros(len(order), LEAF)
    leaves["element"], leaves["box"], leaves["bound"] = element[order], box[order], bound[order]
    on_face = leaves["element"] >= 0
    leaves["patch"][on_face] = elements.table["patch"][leaves["element"][on_face]]
    leaves["patch"][~on_face] = trims.piece_patch[-1 - leaves["element"][~on_face]]
    plates = np.zeros(len(leaves), PLATE)
    plates_nb.fill_plates(elements, grid, trims, leaves, margin, plates)
    return Hierarchy(leaves, plates, tree, low[order] - margin, high[order] + margin)


def items_of(
    hierarchy: Hierarchy, elements: Elements, trims: TrimTables, tolerance: float
) -> Items:
    """Return the items of the closest point search; forms are exact to `tolerance`, a length.

    All leaves of an element with a form become one item, whose plate is zero; other leaves stay as
    they are. The hierarchy over the items is built anew. A body without forms gets the arrays of
    `hierarchy` themselves.
    """
    leaves, plates, tree, low, high = hierarchy
    forms = forms_of(elements, trims, tolerance)
    has_form = np.isin(leaves["element"], np.flatnonzero(forms["kind"] != NO_FORM))
    if not has_form.any():
        return Items(leaves, plates, tree, forms[:0].copy())
    # The leaves of an element with a form become one item.
    rows, item = np.unique(leaves["element"][has_form], return_inverse=True)
    n = len(rows)
    form_items = np.zeros(n, LEAF)
    form_items["element"], form_items["patch"] = rows, elements.table["patch"][rows]
    form_items["has_form"], form_items["box"] = 1, (-0.5, 0.5, -0.5, 0.5)
    item_low, item_high = np.full((n, 3), np.inf), np.full((n, 3), -np.inf)
    np.minimum.at(item_low, item, low[has_form])
    np.maximum.at(item_high, item, high[has_form])
    tree, order = tree_over(
        np.concatenate([low[~has_form], item_low]), np.concatenate([high[~has_form], item_high])
    )
    leaves = np.concatenate([leaves[~has_form], form_items])[order]
    plates = np.concatenate([plates[~has_form], np.zeros(n, PLATE)])[order]
    return Items(leaves, plates, tree, forms)


def tree_over(low: FloatArray, high: FloatArray) -> tuple[Records, IntArray]:
    """Return the `NODE` rows of a hierarchy over boxes, and the order (n,) of the boxes in it.

    `low` and `high` (n, 3) are their corners. `first` of a node with leaves is an index into the
    order. The root is the first row. Without boxes it has `low` +inf, `high` −inf and no leaves.
    """
    *columns, order = tree_nb.build(low, high)
    tree = np.zeros(len(columns[0]), NODE)
    tree["low"], tree["high"], tree["first"], tree["count"] = columns
    return tree, order


def empty_seeds(tree: Records) -> Seeds:
    """Return a grid of cubic voxels over the box of a hierarchy, without seeds yet (−1).

    It has `N_VOXELS` along the longest side, including a margin of `VOXEL_MARGIN` at both ends. The
    voxels of a body without leaves, or in one point, have the side 1.
    """
    low, high = tree["low"][0], tree["high"][0]
    if not np.isfinite(low).all():  # a body without leaves
        low = high = np.zeros(3)
    side = float((high - low).max()) / (N_VOXELS - 2 * VOXEL_MARGIN) or 1.0
    voxels = np.ceil((high - low) / side).astype(np.int32) + 2 * VOXEL_MARGIN
    leaf = np.full(int(np.prod(voxels)), -1, np.int32)
    return Seeds(low - VOXEL_MARGIN * side, np.array([1.0 / side]), voxels, leaf)
