"""Kernels of boxes and leaves, in reading order: each depends on the ones before it only.

In all of them `h` (4, 6) and `d` (3, 3) are work: they hold the point and derivatives of the
element, and of the trimming curve, at the place that was evaluated last.

- tree_nb: a binary hierarchy of boxes, cut by the surface area heuristic
- hierarchy_nb: leaves over the elements: their parts in boxes, with bounds of the derivatives
- curve_nb: trimming pieces in space: the surface along a p-curve, and its closest point
- curve_leaves_nb: leaves over the trimming pieces: stretches of one element each, with rigorous
  bounds, and the side on which their faces are
- face_nb: elements as parts of trimmed faces, and their poles
- closest_cell_nb: one cell of an element and a point: whether it can contain a closer point, or a
  single minimum
- form_nb: elements whose closest point is a formula
- plates_nb: flat copies of all leaves, with their largest departure, for cheap bounds
"""
