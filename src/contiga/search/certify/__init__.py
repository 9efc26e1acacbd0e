"""Certificates: whether a foot that was continued is on the branch its start was on.

Question: does a branch of stationary points lead from the last foot to this one as the point goes
its way? Asked with two feet and the way between; answered by yes, or not proved, or where the
branch ends. Records are `Near`, `Bending`, `Cells`, `EdgeSegment` and `EdgeWork` of
`certify_records`. Read `branch_nb` (the quick certificate by the bounds kept around each part of an
element, `neighbourhoods`), `cells_nb`, then those at creases, vertices and edges, and `follow_nb`:
a way part by part.
"""
