"""Pieces of a surface, small and flat enough to decide which cells of a grid they meet.

Each has a box and a slab that contain it: those of its Bernstein coefficients, widened by the width
of its edges. Pieces that are trimmed away are left out.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from contiga.arrays.codes import CUT, OUT
from contiga.arrays.kernels.rows_nb import double_rows, put
from contiga.elements.kernels.bounds_nb import restrict
from contiga.geometry.kernels.trim_nb import box_state
from contiga.jit import inner, kernel

LOW, HIGH, NORMAL, SLAB_LOW, SLAB_HIGH = 0, 3, 6, 9, 10
"""Columns of a piece: its box, and the slab SLAB_LOW ≤ normal · x ≤ SLAB_HIGH."""
COLUMNS = 11
"""Number of columns of a piece."""
MAX_PENDING = 128
"""Largest number of pending parts of an element."""
MIN_SIZE = 2.0**-24
"""Side of a piece (local parameters) below which it is not halved."""


class PieceLimits(NamedTuple):
    """Limits on the size and number of pieces, lengths."""

    max_length: float
    """Largest length of a piece that no trim cuts."""
    max_trimmed_length: float
    """Largest length of a piece that a trim cuts."""
    max_thickness: float
    """Largest thickness."""
    max_pieces: float
    """Number of pieces above which none is halved."""


@inner()
def _net_normal(net, degree):
    """Return the unit normal of the diagonals of a control net; zero where they are parallel."""
    p, q = degree
    last = (p + 1) * (q + 1) - 1
    x = (net[last, 0] - net[0, 0], net[last, 1] - net[0, 1], net[last, 2] - net[0, 2])
    a = q
    b = p * (q + 1)
    y = (net[a, 0] - net[b, 0], net[a, 1] - net[b, 1], net[a, 2] - net[b, 2])
    n = (x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0])
    length = math.sqrt(n[0] ** 2 + n[1] ** 2 + n[2] ** 2)
    if length == 0.0:
        return 0.0, 0.0, 0.0
    return n[0] / length, n[1] / length, n[2] / length


@inner()
def _longest_row(net, lines, steps):
    """Return the length of the longest row of a control net.

    `lines` are the number of rows and the stride between them, `steps` the number of legs and their
    stride.
    """
    longest = 0.0
    for i in range(lines[0]):
        total = 0.0
        for k in range(steps[0]):
            a = i * lines[1] + k * steps[1]
            b = a + steps[1]
            total += math.sqrt(
                (net[b, 0] - net[a, 0]) ** 2
                + (net[b, 1] - net[a, 1]) ** 2
                + (net[b, 2] - net[a, 2]) ** 2
            )
        longest = max(longest, total)
    return longest


@inner()
def hull(net, count, n, piece):
    """Write the box and the slab along `n` of net[:count] to `piece`.

    Returns the thickness of the slab.
    """
    for c in range(3):
        piece[LOW + c] = math.inf
        piece[HIGH + c] = -math.inf
        piece[NORMAL + c] = n[c]
    piece[SLAB_LOW] = math.inf
    piece[SLAB_HIGH] = -math.inf
    for k in range(count):
        height = 0.0
        for c in range(3):
            piece[LOW + c] = min(piece[LOW + c], net[k, c])
            piece[HIGH + c] = max(piece[HIGH + c], net[k, c])
            height += n[c] * net[k, c]
        piece[SLAB_LOW] = min(piece[SLAB_LOW], height)
        piece[SLAB_HIGH] = max(piece[SLAB_HIGH], height)
    return piece[SLAB_HIGH] - piece[SLAB_LOW]


@inner()
def widen(piece, margin):
    """Widen the box and slab of a piece by a margin."""
    for c in range(3):
        piece[LOW + c] -= margin
        piece[HIGH + c] += margin
    piece[SLAB_LOW] -= margin
    piece[SLAB_HIGH] += margin


@kernel()
def surface_pieces(elements, trims, origin, margins, limits):
    """Return pieces (n, 11) relative to `origin`, and their middles (n, 3): element, s, t.

    Elements are halved until their parts are within `limits` (`PieceLimits`), or there are
    `max_pieces`; parts outside the trims are left out. `margins` (elements,) widen the pieces of
    each element, a length.
    """
    pieces = np.empty((4096, COLUMNS))
    middles = np.empty((4096, 3))
    stack = np.empty((MAX_PENDING, 5))
    n_pieces = 0
    for e in range(elements.table.shape[0]):
        row = elements.table[e]
        if row["trim"] == OUT:
            continue
        degree = (row["degree"][0], row["degree"][1])
        n = (degree[0] + 1) * (degree[1] + 1)
        coefs = elements.coefs[row["bernstein"] : row["bernstein"] + 4 * n]
        net = np.empty((n, 4))
        put(stack, 0, (-0.5, 0.5, -0.5, 0.5, float(row["trim"])))
        top = 1
        while top > 0:
            top -= 1
            box = (stack[top, 0], stack[top, 1], stack[top, 2], stack[top, 3])
            state = stack[top, 4]
            if state == CUT:
                u, v = row["box"][0], row["box"][2]
                du, dv = row["box"][1] - u, row["box"][3] - v
                u0, u1 = u + (box[0] + 0.5) * du, u + (box[1] + 0.5) * du
                v0, v1 = v + (box[2] + 0.5) * dv, v + (box[3] + 0.5) * dv
                state = box_state(trims, row["patch"], u0, u1, v0, v1)
                if state == OUT:
                    continue
            restrict(coefs, degree, box, net)
            for k in range(n):
                for c in range(3):
                    net[k, c] = net[k, c] / net[k, 3] + (row["origin"][c] - origin[c])
            # Bounds of its length along s and along t, by its control net.
            p, q = degree
            along_s = _longest_row(net, (q + 1, 1), (p, q + 1))
            along_t = _longest_row(net, (p + 1, q + 1), (q, 1))
            longest = max(along_s, along_t)
            if n_pieces == pieces.shape[0]:
                pieces = double_rows(pieces)
                middles = double_rows(middles)
            thickness = hull(net, n, _net_normal(net, degree), pieces[n_pieces])
            is_small = longest <= (limits.max_trimmed_length if state == CUT else limits.max_length)
            is_small = is_small and min(thickness, longest) <= limits.max_thickness
            side = 0 if along_s >= along_t else 2
            width = box[side + 1] - box[side]
            is_full = top + 2 > MAX_PENDING or n_pieces > limits.max_pieces
            if is_small or width <= MIN_SIZE or is_full:
                widen(pieces[n_pieces], margins[e])
                put(middles, n_pieces, (float(e), 0.5 * (box[0] + box[1]), 0.5 * (box[2] + box[3])))
                n_pieces += 1
                continue
            half = 0.5 * (box[side] + box[side + 1])
            for k in range(2):
                put(stack, top, (box[0], box[1], box[2], box[3], state))
                stack[top, side + 1 - k] = half
                top += 1
    return pieces[:n_pieces], middles[:n_pieces]
