"""Feet continued from the last step.

Question: where has the foot of a point gone that went a little way? Asked with points (n, 3), body
frame, and their last feet; answered by a `Projection`, certified where it is told where the points
were. In stages, each for the rows that the one before has left (`Left` of `track_records`). Read
`project`, `track_nb` (the stages), `lanes_nb` (many points of one element at once) and
`mixed_lanes_nb` (points of an element each).
"""
