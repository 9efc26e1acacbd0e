"""Derivatives of feet.

Question: how do the depth of a point and the normal at its foot change with the point? Asked with
points (k, 3), body frame, and their feet; answered by `FootSlopes`. On a face the curvature of the
surface decides, on an edge that of the edge, at a vertex the foot stays. Read `slopes_nb`.
"""
