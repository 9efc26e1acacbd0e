"""Kernels of slaves.

- facet_points_nb: points of facets by their shape functions
- shell_offset_nb: the same half a thickness off the mid-surface
"""
