"""Feet and first hits of points on triangle meshes: the rival of exact geometry."""

from contiga.search.faceted.condition import Condition, condition_of
from contiga.search.faceted.hits import first_hit
from contiga.search.faceted.inside import contains
from contiga.search.faceted.projection import project

__all__ = ["Condition", "condition_of", "contains", "first_hit", "project"]
