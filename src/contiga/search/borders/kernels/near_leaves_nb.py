"""Pairs of leaves of faces that may come nearer than a distance: a hierarchy traversed with itself.

Two nodes are opened if their boxes meet. Two leaves form a pair if their plates, rectangles as
thick as the departure of the leaf, meet by the separating axis test.
"""

from __future__ import annotations

import math

from contiga.jit import inner, kernel
from contiga.jit.scratch import scratch, stack_int64

STACK_SIZE = 512
"""Largest number of pairs of nodes on the stack: three per level of each of the two nodes."""


@kernel()
def list_near_leaves(tree, leaves, plates, within, pairs):
    """Return the number of pairs of leaves of faces whose plates may be nearer than `within`.

    Each pair counts once. They are listed in `pairs` as far as its rows go; the number may be
    larger.
    """
    stack = stack_int64(STACK_SIZE, 2)
    stack[0, 0] = 0
    stack[0, 1] = 0
    axes = scratch(6, 3)
    n = 0
    top = 1
    while top > 0:
        top -= 1
        a = stack[top, 0]
        b = stack[top, 1]
        is_apart = False
        for c in range(3):
            is_apart = is_apart or tree[a]["low"][c] > tree[b]["high"][c] + within
            is_apart = is_apart or tree[b]["low"][c] > tree[a]["high"][c] + within
        if is_apart:
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
                # A leaf node stays itself; of a node and itself each pair of children counts once.
                if (i > 0 and tree[a]["count"] > 0) or (j > 0 and tree[b]["count"] > 0):
                    continue
                if a == b and i > j:
                    continue
                stack[top, 0] = a if tree[a]["count"] > 0 else tree[a]["first"] + i
                stack[top, 1] = b if tree[b]["count"] > 0 else tree[b]["first"] + j
                top += 1
    return n


@inner()
def _plates_meet(a_record, b_record, within, axes):
    """Return whether the balls about two plates meet within a distance, and no axis separates them.

    The axes are the sides and normals of both: plates apart along another direction may count as
    meeting. `axes` (6, 3) is work.
    """
    x = b_record["middle"][0] - a_record["middle"][0]
    y = b_record["middle"][1] - a_record["middle"][1]
    z = b_record["middle"][2] - a_record["middle"][2]
    if math.sqrt(x * x + y * y + z * z) > a_record["radius"] + b_record["radius"] + within:
        return False
    for c in range(3):
        axes[0, c] = a_record["x"][c]
        axes[1, c] = a_record["y"][c]
        axes[2, c] = b_record["x"][c]
        axes[3, c] = b_record["y"][c]
        axes[4, c] = a_record["normal"][c]
        axes[5, c] = b_record["normal"][c]
    thickness = within + a_record["departure"] + b_record["departure"]
    for k in range(6):
        a = axes[k, 0]
        b = axes[k, 1]
        c = axes[k, 2]
        reach = thickness * math.sqrt(a * a + b * b + c * c)
        for i in range(4):
            reach += abs(axes[i, 0] * a + axes[i, 1] * b + axes[i, 2] * c)
        if abs(x * a + y * b + z * c) > reach:
            return False
    return True
