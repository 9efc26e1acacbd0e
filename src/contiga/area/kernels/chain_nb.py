"""Closed lines from segments, gone along from node to node."""

from __future__ import annotations

import numpy as np

from contiga.jit import kernel


@kernel()
def chain(ends, first, around, order, starts):
    """Go along the segments between nodes `ends` (m, 2) until none is left; returns how many lines.

    Parameters
    ----------
    first, around : the segments at node a are around[first[a]:first[a + 1]], ascending
    order : (2 m,) takes the nodes, line after line
    starts : (m + 1,) takes where lines start in it, and where the last one ends
    """
    unused = np.ones(ends.shape[0], np.bool_)
    at = first[:-1].copy()
    lines = n = 0
    for k in range(ends.shape[0]):
        if not unused[k]:
            continue
        unused[k] = False
        start, node = ends[k, 0], ends[k, 1]
        starts[lines] = n
        lines += 1
        order[n] = start
        n += 1
        while node != start:
            order[n] = node
            n += 1
            while at[node] < first[node + 1] and not unused[around[at[node]]]:
                at[node] += 1
            if at[node] == first[node + 1]:
                break  # facets that meet in no proper surface: the line is closed straight
            s = around[at[node]]
            unused[s] = False
            node = ends[s, 1] if ends[s, 0] == node else ends[s, 0]
    starts[lines] = n
    return lines
