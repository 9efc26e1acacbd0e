"""Kernels of the search on triangle meshes, in reading order: each uses those before it.

- boxes_nb: a hierarchy of boxes with eight children per node, built by halving at medians
- facet_nb: one point and one triangle: the closest point, normals and features there
- mesh_sides_nb: numbers of the sides of triangles, without sorting them
- order_nb: an order of points along a space-filling curve
- closest_nb: closest points of a mesh: branch and bound over its hierarchy
- entry_nb: crossings of swept points: the segments p0 → p1 against the triangles of a mesh
- facet_slopes_nb: derivatives of depth and normal at feet
- facet_walk_nb: feet continued from the last ones by walking over adjoining triangles
"""
