"""Kernels, in reading order: closest points. Each stands on those before it.

- local_nb: f = |S − P|²/2 about a foot, and the step that lowers it inside one element
- around_nb: the elements that meet at a foot, and which of them leads down from there
- global_among_nb: what of a body a search may answer: all of it, one patch, or minima that do not
  face away
- global_nb: the closest point of a body: branch and bound with rigorous lower bounds
- walk_nb: the local foot from a start: safeguarded Newton that walks over elements and patches
- pseudo_normal_nb: the sum of the normals around a kink, weighted by angle: it decides the side of
  a point there
- foot_nb: from a foot to its record: point, normal, gap; crossing to the next face
- newton_nb: one round of Newton's method on one point, and the record of its foot: what lanes and
  threads share
- one_foot_nb: the foot of one point by Newton's method, in an element or the next one of its patch
- safe_distance_nb: how far a point can go before it can touch: a lower bound of its distance
- edge_width_nb: edges have width: a path that meets the carrier of a face beside it still meets
  the face where it passes its edge, as seen along the path, within the width of that edge
- proof_nb: whether a foot is the closest point of a body, told by what is around it
- nearest_nb: closest points: guessed by Newton's method, and the guess proved; else searched for
- facing_nb: closest points of what does not face away from a guard
"""
