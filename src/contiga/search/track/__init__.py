"""Feet continued from the last step.

Question: where is the foot of a point after a small motion? The input is points (n, 3), body frame,
and their last feet; the result is a `Projection`, certified if the previous points are given. There
are several stages, each for the rows that the stage before has not finished (`PendingRows` of
`track_records`). Read `project`, `track_nb` (the stages), `lanes_nb` (many points of one element at
once) and `mixed_lanes_nb` (points of different elements).
"""
