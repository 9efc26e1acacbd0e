"""Kernels of slaves.

- facet_points_nb: points of facets by their shape functions
"""
