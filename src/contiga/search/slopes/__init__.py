"""Derivatives of feet.

Question: how do the depth of a point and the normal at its foot change with the point? The input is
points (k, 3), body frame, and their feet; the result is `FootSlopes`. On a face the curvature of
the surface decides, on an edge the curvature of the edge; at a vertex the foot stays. Read
`slopes_nb`.
"""
