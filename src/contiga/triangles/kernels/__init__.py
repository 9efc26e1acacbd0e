"""Kernels, in reading order: the search on triangle meshes. Each stands on those before it.

- boxes_nb: a hierarchy of boxes with eight children a node, built by halving at medians
- facet_nb: one point and one triangle: the closest point, and what the surface is like there
- mesh_sides_nb: sides of triangles that are one: counted without sorting them
- order_nb: an order of points along space, so that each is near the one before
- closest_nb: closest points of a mesh: branch and bound over its hierarchy
- entry_nb: crossings of a swept point: the segment p0 → p1 against the triangles of a mesh
- facet_slopes_nb: derivatives of depth and normal at feet
- facet_walk_nb: feet continued from the last ones by walking over adjoining triangles
"""
