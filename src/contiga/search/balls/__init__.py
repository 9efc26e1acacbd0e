"""The balls that touch a body from inside and outside.

Question: how large a ball touches the surface at a foot and contains no other point of it? Asked
with feet (patch, uv) and a side, answered by a lower bound of the radius; `radii` states what it
proves. The record is `Balls`. Read `radii`, `ball_nb` (look-up), then how they are computed:
`ball_cells`, `ball_caps`, `ball_cap_bounds`.
"""
