"""Closest points.

Question: which point of the body, or of one face, is nearest to a point? Asked with points (n, 3),
body frame, and upper bounds of the distances; answered by a `Projection`. Proved by branch and
bound over the hierarchy, or by a ball that touches at a guessed foot. Read `closest`, `nearest_nb`
(guess and proof), `global_nb` (branch and bound), `walk_nb` (the local foot), `foot_nb` (its
record), `pseudo_normal_nb` (the side of a point at a kink).
"""
