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

# A leaf leaves its tangent parallelogram by at most this share of its larger extent: flat leaves
# save a third of a search, and of bodies of many curved faces take too much memory.
FLATNESS = (0.125, 0.25)
FLAT_LEAVES = 200_000
# Halvings of one element at most.
DEPTH = 9
# Halvings of a stretch of a trimming piece at most.
CURVE_DEPTH = 8
# Voxels of the grid of seeds along its longest side, and how far it goes beyond the body, in them.
VOXELS = 64
BEYOND = 3


class Hierarchy(NamedTuple):
    """Leaves over every element that is not trimmed away whole, and over every trimming piece."""

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
    """The hierarchy of a body."""
    for flatness in FLATNESS:
        faces = hierarchy_nb.surface_leaves(elements, flatness, DEPTH)
        curves = curve_leaves_nb.curve_leaves(elements, grid, trims, flatness, CURVE_DEPTH)
        rows = np.concatenate([faces, curves])
        if len(rows) <= FLAT_LEAVES:
            break
    element = rows[:, 0].astype(np.int32)
    box, bound, low, high = np.split(rows[:, 1:], [4, 13, 16], axis=1)
    # Where its edges have width, a face reaches that much beyond them.
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
    """Return what the closest point is searched among; forms are exact to `tolerance`, a length."""
    leaves, plates, tree, low, high = hierarchy
    forms = forms_of(elements, trims, tolerance)
    formed = np.isin(leaves["element"], np.flatnonzero(forms["kind"] != NO_FORM))
    if not formed.any():
        return Items(leaves, plates, tree, forms[:0].copy())
    rows, item = np.unique(leaves["element"][formed], return_inverse=True)
    whole = np.zeros(len(rows), LEAF)
    whole["element"], whole["patch"] = rows, elements.table["patch"][rows]
    whole["has_form"], whole["box"] = 1, (-0.5, 0.5, -0.5, 0.5)
    item_low, item_high = np.full((len(rows), 3), np.inf), np.full((len(rows), 3), -np.inf)
    np.minimum.at(item_low, item, low[formed])
    np.maximum.at(item_high, item, high[formed])
    tree, order = tree_over(
        np.concatenate([low[~formed], item_low]), np.concatenate([high[~formed], item_high])
    )
    leaves = np.concatenate([leaves[~formed], whole])[order]
    plates = np.concatenate([plates[~formed], np.zeros(len(rows), PLATE)])[order]
    return Items(leaves, plates, tree, forms)


def tree_over(low: FloatArray, high: FloatArray) -> tuple[Records, IntArray]:
    """Nodes of a hierarchy over boxes (n, 3), and the boxes in its order."""
    *columns, order = tree_nb.build(low, high)
    tree = np.zeros(len(columns[0]), NODE)
    tree["low"], tree["high"], tree["first"], tree["count"] = columns
    return tree, order


def empty_seeds(tree: Records) -> Seeds:
    """Return a grid of voxels over a hierarchy, without seeds yet."""
    low, high = tree["low"][0], tree["high"][0]
    if not np.isfinite(low).all():  # a body without leaves
        low = high = np.zeros(3)
    side = float((high - low).max()) / (VOXELS - 2 * BEYOND) or 1.0
    voxels = np.ceil((high - low) / side).astype(np.int32) + 2 * BEYOND
    leaf = np.full(int(np.prod(voxels)), -1, np.int32)
    return Seeds(low - BEYOND * side, np.array([1.0 / side]), voxels, leaf)
