"""Disjoint sets, by union and find."""

from __future__ import annotations

import numpy as np

from contiga.jit import inner


@inner()
def root(parent, i):
    """Return the lowest member of the set that contains i; the path to it in `parent` is halved."""
    while parent[i] != i:
        parent[i] = parent[parent[i]]
        i = parent[i]
    return i


@inner()
def unite(parent, a, b):
    """Join the sets that contain a and b in `parent`; the lowest member is the root."""
    if parent[a] == parent[b]:  # nearly always, after the first pairs
        return
    a = root(parent, a)
    b = root(parent, b)
    if a < b:
        parent[b] = a
    else:
        parent[a] = b


@inner()
def set_numbers(parent):
    """Return the set (n,) int32 of each item; sets are numbered in the order of first items."""
    label = np.empty(parent.shape[0], np.int32)
    count = 0
    for i in range(parent.shape[0]):
        r = root(parent, i)
        if r == i:
            label[i] = count
            count += 1
        else:
            label[i] = label[r]
    return label
