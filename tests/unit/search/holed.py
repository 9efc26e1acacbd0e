"""A bumpy plate with a hole, and the boxes of leaves."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

import contiga as cg


def holed_plate(waves=2):
    """A bumpy plate with a round hole about its middle, the outer border as p-curves too."""
    patch = cg.shapes.bumpy_plate(waves=waves)
    square = [(0, 0), (1, 0), (1, 1), (0, 1), (0, 0)]
    outer = tuple(
        cg.NurbsCurve(1, [0, 0, 1, 1], [[*a, 0.0], [*b, 0.0]]) for a, b in pairwise(square)
    )
    hole = (cg.shapes.circle(radius=0.2, centre=[0.5, 0.5, 0]),)
    return cg.Body([patch], trims=[(outer, hole)])


def leaf_boxes(tables):
    low, high = np.empty((2, len(tables.leaves), 3))
    for node in tables.tree[tables.tree["count"] > 0]:
        own = slice(node["first"], node["first"] + node["count"])
        low[own], high[own] = node["low"], node["high"]
    return low, high
