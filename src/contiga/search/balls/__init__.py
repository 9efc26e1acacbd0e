"""The balls that touch a body from inside and outside.

Question: how large a ball touches the surface at a foot and holds no more of it? Asked with feet
(patch, uv) and a side, answered by a lower bound of the radius: what it proves, `radii` says. The
record is `Balls`. Read `radii`, `ball_nb` (looking up), then how they are worked out: `ball_cells`,
`ball_caps`, `ball_cap_bounds`.
"""
