"""Records of arrays passed between kernels of geometry."""

from __future__ import annotations

from typing import NamedTuple

from contiga.geometry.kernels.evaluate_nb import Scratch
from contiga.records import FloatArray, IndexArray

AREA, FLUX = 0, 1
"""Kinds of integrals over patches."""


class Samples(NamedTuple):
    """Points of a curve."""

    t: FloatArray
    """(n,) their parameters, ascending."""
    point: FloatArray
    """(n, 1, 3)."""


class ImageWork(NamedTuple):
    """Memory for a point of an image."""

    t: FloatArray
    """(1,) parameter on the p-curve."""
    uv: FloatArray
    """(1, 1, 3) point of the p-curve."""
    bases: Scratch
    """Work arrays of `surface_point`."""
    point: FloatArray
    """(1, 1, 3) point of the surface there."""


class CurveWork(NamedTuple):
    """Memory for a foot on the edge's curve."""

    t: FloatArray
    """(1,)."""
    derivatives: FloatArray
    """(1, 3, 3) C, C′, C″."""
    nearest: IndexArray
    """(1,) the sample nearest to the previous point."""


class GaussRule(NamedTuple):
    """A quadrature rule for every element."""

    nodes: FloatArray
    """(n,) in [0, 1]."""
    weights: FloatArray
    """(n,)."""
    parts: int
    """Number of equal parts of an element in each direction."""
    kind: int
    """AREA: |S_u × S_v|; FLUX: see `add_moments`."""
