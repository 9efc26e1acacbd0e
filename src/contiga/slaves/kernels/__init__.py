"""Kernels of slaves.

- facet_points_nb: points of facets by their shape functions
- facet_sums_nb: from some of these points to corners, and back
- facet_blocks_nb: sparse matrices between the corners of facets
"""
