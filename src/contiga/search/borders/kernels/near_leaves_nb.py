"""Pairs of leaves of faces that may come nearer than a distance: the hierarchy met with itself.

Two nodes are opened while their boxes meet; of the leaves at the ends the plates must, which are
rectangles as thick as the leaf departs from them, by their separating axes.
"""

from __future__ import annotations

import math

from contiga.jit import inner, kernel
from contiga.jit.scratch import scratch, stack_int64

DEPTH = 512
"""Pairs of nodes that wait at once: three a level of the hierarchy of each of the two."""


@kernel()
def list_near_leaves(tree, leaves, plates, within, pairs):
    """Return how many pairs of leaves of faces there are, each once; the first are listed in
    `pairs`."""
    stack = stack_int64(DEPTH, 2)
    stack[0, 0] = 0
    stack[0, 1] = 0
    axes = scratch(6, 3)
    n = 0
    top = 1
    while top > 0:
        top -= 1
        a = stack[top, 0]
        b = stack[top, 1]
        if not _boxes_meet(tree[a], tree[b], within):
            continue
        if tree[a]["count"] > 0 and tree[b]["count"] > 0:
            first, past = tree[b]["first"], tree[b]["first"] + tree[b]["count"]
            for i in range(tree[a]["first"], tree[a]["first"] + tree[a]["count"]):
                if leaves[i]["element"] < 0:
                    continue
                for j in range(i + 1 if a == b else first, past):
                    if leaves[j]["element"] < 0 or not _plates_meet(
                        plates[i], plates[j], within, axes
                    ):
                        continue
                    if n < pairs.shape[0]:
                        pairs[n, 0] = i
                        pairs[n, 1] = j
                    n += 1
            continue
        for i in range(2):
            for j in range(2):
                # An end stays itself; of a node and itself each pair of children counts once.
                if (i > 0 and tree[a]["count"] > 0) or (j > 0 and tree[b]["count"] > 0):
                    continue
                if a == b and i > j:
                    continue
                stack[top, 0] = a if tree[a]["count"] > 0 else tree[a]["first"] + i
                stack[top, 1] = b if tree[b]["count"] > 0 else tree[b]["first"] + j
                top += 1
    return n


@inner()
def _boxes_meet(one, two, within):
    for c in range(3):
        if one["low"][c] > two["high"][c] + within or two["low"][c] > one["high"][c] + within:
            return False
    return True


@inner()
def _plates_meet(one, two, within, axes):
    """Return whether the balls about two plates meet, and no axis of either separates them.

    `axes` (6, 3) is memory: their sides, then their normals.
    """
    x = two["middle"][0] - one["middle"][0]
    y = two["middle"][1] - one["middle"][1]
    z = two["middle"][2] - one["middle"][2]
    if math.sqrt(x * x + y * y + z * z) > one["radius"] + two["radius"] + within:
        return False
    for c in range(3):
        axes[0, c] = one["x"][c]
        axes[1, c] = one["y"][c]
        axes[2, c] = two["x"][c]
        axes[3, c] = two["y"][c]
        axes[4, c] = one["normal"][c]
        axes[5, c] = two["normal"][c]
    thick = within + one["departure"] + two["departure"]
    for k in range(6):
        a = axes[k, 0]
        b = axes[k, 1]
        c = axes[k, 2]
        reach = thick * math.sqrt(a * a + b * b + c * c)
        for i in range(4):
            reach += abs(axes[i, 0] * a + axes[i, 1] * b + axes[i, 2] * c)
        if abs(x * a + y * b + z * c) > reach:
            return False
    return True
