"""Feet and first hits of points on exact geometry."""

from contiga.search.projection import project

__all__ = ["project"]
