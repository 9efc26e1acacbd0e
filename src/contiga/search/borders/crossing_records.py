"""Records of arrays of the kernels that look for crossings."""

from __future__ import annotations

from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from contiga.pointer_records import pass_by_pointer
from contiga.records import FloatArray, IndexArray


@pass_by_pointer
class Starts(NamedTuple):
    """Places on pairs of leaves that Newton's method starts from, as many of each pair."""

    pairs: IndexArray
    """(n, 2) leaves."""
    share: FloatArray
    """(n, count, 2, 2) where in its leaf a place is: shares of the leaf's sides."""
    distance: FloatArray
    """(n, count) between the two places, length."""


@pass_by_pointer
class CommonPoints(NamedTuple):
    """The points that places of two leaves each were led to."""

    met: NDArray[np.bool_]
    """(n, count) whether to one point, and no start before of the same leaves to the same one."""
    uv: FloatArray
    """(n, count, 2, 2) parameters in the patches."""
    point: FloatArray
    """(n, count, 2, 3) points, body frame."""
    along: FloatArray
    """(n, count, 2, 2, 3) derivatives there along u and v."""

    @classmethod
    def of(cls, n: int, count: int) -> Self:
        """Memory for n pairs."""
        each = n, count, 2
        met = np.empty(each[:2], np.bool_)
        return cls(met, np.empty((*each, 2)), np.empty((*each, 3)), np.empty((*each, 2, 3)))


class LeadWork(NamedTuple):
    """Memory for one pair of places, both leaves' two parameters one after the other."""

    place: FloatArray
    """(4,) in their elements."""
    wide: FloatArray
    """(4,) widths of the elements in the parameters of their patches."""
    slope: FloatArray
    """(4, 3) how the first moves with its parameters, and against the second with those."""
    h: FloatArray
    """(4, 6) derivatives of an element."""
