"""A point of the body in every leaf: what a search can be sure of before it opens any."""

from __future__ import annotations

import math

import numpy as np

from contiga.elements.kernels.element_nb import evaluate
from contiga.num.jit import kernel
from contiga.search.kernels.curve_nb import curve_point
from contiga.search.kernels.global_nb import in_face


@kernel()
def fill_middles(elements, grid, trims, leaves):
    """The middles of all leaves, body axes; infinite where the trims leave none."""
    h = np.empty((4, 6))
    d = np.empty((3, 3))
    for k in range(leaves.shape[0]):
        e = leaves[k]["element"]
        box = leaves[k]["box"]
        if e < 0:
            e, _, _ = curve_point(elements, grid, trims, -1 - e, 0.5 * (box[0] + box[1]), h, d)
            x, y, z = d[0, 0], d[0, 1], d[0, 2]
        else:
            s = 0.5 * (box[0] + box[1])
            t = 0.5 * (box[2] + box[3])
            evaluate(elements, e, s, t, h)
            x, y, z = h[0, 0], h[1, 0], h[2, 0]
            if not in_face(elements, trims, e, s, t):
                x = math.inf
        origin = elements.table[e]["origin"]
        leaves[k]["middle"][0] = x + origin[0]
        leaves[k]["middle"][1] = y + origin[1]
        leaves[k]["middle"][2] = z + origin[2]
