"""Kernels of closest points, in reading order: each uses those before it.

In all of them `h` (4, 6) is work: it holds the point and derivatives of the place that was
evaluated last. `nearest` (4,) is the result of a search, see the columns in `curve_nb`.

- local_nb: f = |S − P|²/2 about a foot, and the step that lowers it inside one element
- around_nb: the elements that meet at a foot, and the direction of steepest descent among them
- global_scope_nb: the part of a body that a search is restricted to: all of it, one patch, or
  minima that face a guard
- global_nb: the closest point of a body: branch and bound with rigorous lower bounds
- walk_nb: the local foot from a start: safeguarded Newton's method that walks over elements and
  patches
- pseudo_normal_nb: the sum of the normals around a kink, weighted by angle: it decides the side of
  a point there
- foot_nb: from a foot to its record: point, normal, gap; over an edge to the next face
- newton_nb: one round of Newton's method on one point, and the record of its foot: shared by lanes
  and threads
- one_foot_nb: the foot of one point by Newton's method, in an element or the next one of its patch
- safe_distance_nb: how far a point can go before it can touch: a lower bound of its distance
- edge_width_nb: edges have width: a path that meets the carrier of a face beside it also meets the
  face where it passes its edge, as seen along the path, within the width of that edge
- proof_nb: proof that a foot is the closest point of a body, by the growth of f around it
- nearest_nb: closest points: a guess by Newton's method, and its proof; otherwise a search
- facing_nb: closest feet that do not face away from a guard
"""
