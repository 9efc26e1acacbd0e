"""Chain segments to closed lines, node by node."""

from __future__ import annotations

import numpy as np

from contiga.jit import kernel


@kernel()
def chain(ends, first, incident, order, starts):
    """Chain the segments between nodes `ends` (m, 2) to lines; return the number of lines.

    At each node the first unused segment follows. A line that finds none is closed straight.

    Parameters
    ----------
    first, incident : the segments at node a are incident[first[a]:first[a + 1]], ascending
    order : (2 m,) out, the nodes, line after line
    starts : (m + 1,) out, where lines start in `order`, and where the last one ends
    """
    unused = np.ones(ends.shape[0], np.bool_)
    next_of = first[:-1].copy()
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
            while next_of[node] < first[node + 1] and not unused[incident[next_of[node]]]:
                next_of[node] += 1
            if next_of[node] == first[node + 1]:
                break  # facets do not form a proper surface: the line is closed straight
            s = incident[next_of[node]]
            unused[s] = False
            node = ends[s, 1] if ends[s, 0] == node else ends[s, 0]
    starts[lines] = n
    return lines
