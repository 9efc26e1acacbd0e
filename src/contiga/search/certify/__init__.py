"""Certificates: whether a foot that was continued is on the branch its start was on.

Question: does a branch of stationary points lead from the last foot to this one as the point goes
its way? Asked with two feet and the way between; answered by yes, or not proved. There is one
proof, by bounds of the curvature that are kept around each part of an element (`neighbourhoods`);
it is refused wherever the surface has a kink or an end in reach. Read `branch_nb`, then what
builds the bounds.
"""
