"""Groups of items that pairs join, directly or not."""

from __future__ import annotations

import numpy as np

from contiga.records import IndexArray, IntArray


def groups_of(first: IndexArray, second: IndexArray, n: int) -> IntArray:
    """Return the group (n,) of each of n items, where pairs first[k], second[k] are joined.

    Groups are numbered in the order of their first items. The higher root of each pair gets the
    lower one as its parent, then every item its root (Shiloach & Vishkin, An O(log n) parallel
    connectivity algorithm, 1982): scipy's function takes longer to import than this to run.

    >>> groups_of(np.array([4, 1]), np.array([2, 4]), 5).tolist()
    [0, 1, 1, 2, 1]
    """
    lowest = np.arange(n)
    while True:
        a, b = lowest[first], lowest[second]
        differs = a != b
        if not differs.any():
            return np.unique(lowest, return_inverse=True)[1].astype(np.int32)
        first, second, a, b = first[differs], second[differs], a[differs], b[differs]
        np.minimum.at(lowest, np.maximum(a, b), np.minimum(a, b))
        while (roots := lowest[lowest]).tobytes() != lowest.tobytes():
            lowest = roots
