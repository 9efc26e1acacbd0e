"""What the kernels are handed that cut surfaces into flat pieces."""

from __future__ import annotations

from typing import NamedTuple


class PieceLimits(NamedTuple):
    """When pieces are small enough, lengths."""

    whole: float
    """How long one may be where nothing is trimmed away,"""
    cut: float
    """and where it is cut by a trim."""
    thin: float
    """How thick it may be."""
    most: float
    """Number of pieces above which nothing is halved any more."""
