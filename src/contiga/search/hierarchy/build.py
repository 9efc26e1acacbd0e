"""Leaves and hierarchy of a body: pieces of elements and of trimming curves, in boxes."""

from __future__ import annotations

import numpy as np

from contiga.elements.element_arrays import Elements, Grid, Records
from contiga.geometry.trim import TrimTables
from contiga.records import FloatArray, IntArray
from contiga.search.hierarchy.kernels import curve_leaves_nb, hierarchy_nb, plates_nb, tree_nb
from contiga.search.hierarchy.table_types import LEAF, NODE, PLATE, Seeds

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


def build_hierarchy(
    elements: Elements, grid: Grid, trims: TrimTables
) -> tuple[Records, Records, Records]:
    """Leaves over every element that is not trimmed away whole, and over every trimming piece.

    Returns the leaves in the order of the hierarchy, their plates, and its nodes.
    """
    for flatness in FLATNESS:
        faces = hierarchy_nb.surface_leaves(elements, flatness, DEPTH)
        curves = curve_leaves_nb.curve_leaves(elements, grid, trims, flatness, CURVE_DEPTH)
        if len(faces[0]) + len(curves[0]) <= FLAT_LEAVES:
            break
    element, box, bound, low, high = (
        np.concatenate(pair) for pair in zip(faces, curves, strict=True)
    )
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
    return leaves, plates, tree


def tree_over(low: FloatArray, high: FloatArray) -> tuple[Records, IntArray]:
    """Nodes of a hierarchy over boxes (n, 3), and the boxes in its order."""
    *columns, order = tree_nb.build(low, high)
    tree = np.zeros(len(columns[0]), NODE)
    tree["low"], tree["high"], tree["first"], tree["count"] = columns
    return tree, order


def empty_seeds(tree: Records) -> Seeds:
    """A grid over a hierarchy, without seeds yet."""
    low, high = tree["low"][0], tree["high"][0]
    if not np.isfinite(low).all():  # a body without leaves
        low = high = np.zeros(3)
    side = float((high - low).max()) / (VOXELS - 2 * BEYOND) or 1.0
    voxels = np.ceil((high - low) / side).astype(np.int32) + 2 * BEYOND
    leaf = np.full(int(np.prod(voxels)), -1, np.int32)
    return Seeds(low - BEYOND * side, np.array([1.0 / side]), voxels, leaf)
