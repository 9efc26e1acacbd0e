"""Kernels, in reading order: the search on exact geometry. Each stands on those before it.

- tree_nb: a binary hierarchy of boxes, built by halving at the median of the longest axis
- hierarchy_nb: leaves over the elements: their parts in boxes, with bounds of the derivatives
- curve_nb: trimming pieces in space: the surface along a p-curve, and its closest point
- curve_leaves_nb: leaves over the trimming pieces: stretches of one element each, with rigorous
  bounds
- local_nb: f = |S − P|²/2 about a foot, and the step that lowers it inside one element
- face_nb: elements as pieces of faces: what the trims leave of them, and sides that are one point
- closest_cell_nb: one cell of an element against a point: whether it can hold a closer one, or
  just one minimum
- plates_nb: every leaf laid flat, with how far it leaves that, for bounds before anything is opened
- global_among_nb: what of a body a search may answer: all of it, one patch, or minima that do not
  face away
- global_nb: the closest point of a body: branch and bound with rigorous lower bounds
- around_nb: the elements that meet at a foot, and which of them leads down from there
- walk_nb: the local foot from a start: safeguarded Newton that walks over elements and patches
- pseudo_normal_nb: the sum of the normals around a kink, weighted by angle: it decides the side
  of a point there
- foot_nb: from a foot to its record: point, normal, gap; crossing to the next face
- newton_nb: one round of Newton's method on one point, and the record of its foot: what lanes and
  threads share
- one_foot_nb: the foot of one point by Newton's method, in an element or the next one of its patch
- lanes_nb: Newton's method on many points of one element at once: the fast lane of tracking
- bins_nb: rows in the order of their elements: what lanes are handed of them, and what these find
- safe_distance_nb: how far a point can go before it can touch: a lower bound of its distance
- edge_width_nb: edges have width: a path that meets the carrier of a face beside it still meets
  the face where it passes its edge, as seen along the path, within the width of that edge
- flat_cell_nb: where a path crosses a cell that is a point, or flat along the path: its ends tell
- crossing_nb: where a straight path crosses one leaf, cell by cell, with tolerances that are
  lengths
- side_pieces_nb: pieces of a surface, small and flat enough to tell which cells of a grid they
  meet
- piece_lists_nb: pieces of a surface near every voxel of a grid: whether a short path is clear of
  all of them
- hit_nb: crossings of swept points: the segments p0 → p1 against the exact surface
- side_grid_nb: which cells of a grid hold surface, and which of the others are joined
- side_nb: looking up a grid of known sides: the side of a point, and whether a way is clear of
  surface
- ball_plane_nb: touching balls: how large a ball may touch a surface from inside or outside and
  hold no more
- ball_cell_nb: cells of elements with rigorous bounds of how their surface runs, turns and bends
- ball_block_nb: blocks of cells over which a patch is smooth: how near its own points come to
  touching balls
- ball_bound_nb: the corner values of cells: what all other cells of the body leave of their
  touching balls
- ball_nb: radii of touching balls at feet, looked up in the cells of the elements
- rest_nb: what an element's surface leaves its second-order Taylor polynomial by, over a box
- bend_nb: how much an element bends over a box: rigorous bounds of its normal curvatures and
  widths
- pole_nb: how much an element bends over a box with a side that is one point, as at the pole of a
  sphere
- part_nb: parts of elements, sixteen each, and what the record of a ring takes over of one
- wide_ring_nb: surroundings of parts beside which elements are narrow: whole rows and columns of
  parts
- ring_nb: bounds around every sixteenth of an element: what the quick certificate of a tracked
  foot asks
- branch_nb: the certificate of a tracked foot: that it is on the branch its start was on
- onward_nb: where Newton's method goes on when it leaves an element
- lane_proof_nb: the quick certificate of many feet of one element at once
- mixed_lanes_nb: lanes of an element each: feet that have left their element, and those of elements
  that have few
- nearest_nb: closest points: guessed by Newton's method, and the guess proved; else searched for
- facing_nb: closest points of what does not face away from a guard
- project_nb: the outer loops of tracking: ranges of rows, each row solved on its own
- cells_nb: the cell about a foot, and how it goes on across a side of its element
- fold_nb: a crease and its two faces beside a foot: frames, and how far they turn along it
- crease_nb: the certificate of feet on and beside a crease
- vertex_nb: the certificate of feet at a vertex, and on a crease up to one
- joined_nb: whether one branch joins two feet: a part of a motion, proved at once
- strand_nb: the strand of an edge that runs through a cell of a face: which it is, where, how it
  bends
- about_edge_nb: the fold next to a foot: two faces that end at one edge, with cells of both and
  their bounds
- edge_nb: the certificate of feet on and beside the edges of trimmed faces
- within_face_nb: the certificate of feet that stay on their face, beside edges which f falls away
  from
- follow_nb: following the branch of a foot part by part, where its surroundings do not prove it
  at once
- track_nb: tracking whole: chunks of points, each from binning to the certificates of its feet
- row_nb: tracking one point by itself: what a thread of a GPU does
- joint_nb: how well two faces meet along the trimming pieces of their common edge, measured at
  samples
"""
