"""Sets that are joined, by union and find."""

from __future__ import annotations

from contiga.num.jit import inner


@inner()
def root(parent, i):
    """The first member of the set that holds i; ways to it are halved."""
    while parent[i] != i:
        parent[i] = parent[parent[i]]
        i = parent[i]
    return i


@inner()
def unite(parent, a, b):
    """Make the sets that hold a and b one."""
    if parent[a] == parent[b]:  # nearly always, once the first are through
        return
    a = root(parent, a)
    b = root(parent, b)
    if a < b:
        parent[b] = a
    else:
        parent[a] = b
