"""Kernels, in reading order: boxes over a body, and their leaves. Each stands on those before it.

- tree_nb: a binary hierarchy of boxes, cut by the surface area heuristic
- hierarchy_nb: leaves over the elements: their parts in boxes, with bounds of the derivatives
- curve_nb: trimming pieces in space: the surface along a p-curve, and its closest point
- curve_leaves_nb: leaves over the trimming pieces: stretches of one element each, with rigorous
  bounds, and on which side of them their faces are
- face_nb: elements as pieces of faces: what the trims leave of them, and sides that are one point
- closest_cell_nb: one cell of an element against a point: whether it can hold a closer one, or
  just one minimum
- form_nb: elements whose closest point is a formula
- plates_nb: every leaf laid flat, with how far it leaves that, for bounds before anything is
  opened
"""
