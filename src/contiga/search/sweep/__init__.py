"""Where paths of points cross a body.

Question: where does the way of a point meet the surface first, or last, and from which side? Asked
with segments a → b (n, 3), body frame; answered by a `Hit`. By interval Newton, with tolerances
that are lengths. Read `hit_nb` (one path), `crossing_nb` (one leaf), `flat_cell_nb`;
`piece_lists` leaves out short paths that are clear of surface.
"""
