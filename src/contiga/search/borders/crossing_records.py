"""Records of arrays of the kernels that look for crossings."""

from __future__ import annotations

from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from contiga.pointer_records import pass_by_pointer
from contiga.records import FloatArray, IndexArray


@pass_by_pointer
class Starts(NamedTuple):
    """Starting places of Newton's method on pairs of leaves, the same number for each pair."""

    pairs: IndexArray
    """(n, 2) leaves."""
    fractions: FloatArray
    """(n, count, 2, 2) place in its leaf, as fractions of the leaf's sides."""
    distance: FloatArray
    """(n, count) between the two places, length."""


@pass_by_pointer
class CommonPoints(NamedTuple):
    """The points where Newton's method ended, on both leaves of each pair."""

    is_common: NDArray[np.bool_]
    """(n, count) whether it is a common point, and no earlier start of the pair led to it."""
    uv: FloatArray
    """(n, count, 2, 2) parameters in the patches."""
    point: FloatArray
    """(n, count, 2, 3) points, body frame."""
    tangents: FloatArray
    """(n, count, 2, 2, 3) derivatives there along u and v."""

    @classmethod
    def of(cls, n: int, count: int) -> Self:
        """Memory for n pairs."""
        shape = n, count, 2
        is_common = np.empty(shape[:2], np.bool_)
        uv, point = np.empty((*shape, 2)), np.empty((*shape, 3))
        return cls(is_common, uv, point, np.empty((*shape, 2, 3)))


class NewtonWork(NamedTuple):
    """Memory for one pair of places; the two parameters of each leaf follow one another."""

    place: FloatArray
    """(4,) in their elements."""
    width: FloatArray
    """(4,) widths of the elements in the parameters of their patches."""
    jacobian: FloatArray
    """(4, 3) derivatives of the first point minus the second, one row per parameter."""
    h: FloatArray
    """(4, 6) derivatives of an element."""
