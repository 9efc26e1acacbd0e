"""Kernels, in reading order: certificates of tracked feet. Each stands on those before it.

- rest_nb: what an element's surface leaves its second-order Taylor polynomial by, over a box
- bend_nb: how much an element bends over a box: rigorous bounds of its normal curvatures and
  widths
- pole_nb: how much an element bends over a box with a side that is one point, as at the pole of a
  sphere
- part_nb: parts of elements, sixteen each, and what the record of a neighbourhood takes over of one
- wide_neighbourhood_nb: surroundings of parts beside which elements are narrow: whole rows and
  columns of parts
- neighbourhood_nb: bounds around every sixteenth of an element: what the quick certificate of a
  tracked foot asks
- branch_nb: the certificate of a tracked foot: that it is on the branch its start was on
- cells_nb: the cell about a foot, and how it goes on across a side of its element
- fold_nb: a crease and its two faces beside a foot: frames, and how far they turn along it
- crease_nb: the certificate of feet on and beside a crease
- vertex_nb: the certificate of feet at a vertex, and on a crease up to one
- joined_nb: whether one branch joins two feet: a part of a motion, proved at once
- edge_segment_nb: the edge segment of an edge that runs through a cell of a face: which it is,
  where, how it bends
- about_edge_nb: the fold next to a foot: two faces that end at one edge, with cells of both and
  their bounds
- edge_nb: the certificate of feet on and beside the edges of trimmed faces
- within_face_nb: the certificate of feet that stay on their face, beside edges which f falls away
  from
- follow_nb: following the branch of a foot part by part, where its surroundings do not prove it at
  once
"""
