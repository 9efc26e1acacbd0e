"""Tables as kernels take them."""

from __future__ import annotations

from typing import NamedTuple

from contiga.records import FloatArray


class CurveTable(NamedTuple):
    """A force that cannot pull, straight between its nodes: `Characteristic.carried` of a table."""

    x: FloatArray
    """(n,) nodes, zero or above, rising."""
    y: FloatArray
    """(n,) force there, zero or above."""
    energy: FloatArray
    """(n,) ∫ y dx from zero to there."""
    slope: FloatArray
    """(n,) of the force behind each node."""


class BoundTable(NamedTuple):
    """A curve that lines of one slope K meet."""

    curve: CurveTable
    drop: FloatArray
    """(n,) the most of K x − y up to each node: it never falls."""
