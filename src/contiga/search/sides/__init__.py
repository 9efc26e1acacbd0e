"""Find which side of a closed body a point is on.

Question: is a point inside or outside, and how far may it go before that can change? Asked with
points (n, 3), body frame; answered by sides (1 outside, −1 inside, 0 unknown) and lengths. The
record is `SideGrid`. Read `side_grid` (the record and how it is built), `side_nb` (queries),
`side_pieces_nb` and `side_grid_nb` (the steps of building).
"""
