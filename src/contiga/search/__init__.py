"""Feet and first hits of points on exact geometry."""

import contiga.num.jit  # noqa: F401 (before any kernel: how they are kept)
from contiga.search.entries import first_hit
from contiga.search.inside import contains
from contiga.search.openings import Openings, openings_of
from contiga.search.projection import project

__all__ = ["Openings", "contains", "first_hit", "openings_of", "project"]
