"""Certificates: whether a continued foot is on the same branch as its start.

Question: does a branch of stationary points lead from the last foot to this one as the point moves?
The input is two feet and the motion between; the result is yes, or not proved. There is one proof,
by bounds of the curvature around each part of an element (`neighbourhoods`); it fails wherever the
surface has a kink or a border in reach. Read `branch_nb`, then the kernels that compute the bounds.
"""
