"""Find where paths of points cross a body.

Question: where does the path of a point cross the surface first, or last, and from which side? It
is asked with segments a → b (n, 3), body frame, and answered by a `Hit`. The method is interval
Newton, with tolerances that are lengths. Read `hit_nb` (one path), `crossing_nb` (one leaf),
`flat_cell_nb`; `moving_nb` is for a surface that moves meanwhile. `piece_lists` skips short paths
that are clear of the surface.
"""
