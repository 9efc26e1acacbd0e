"""Rigid surfaces: exact bodies, and the protocol of any master.

Question: what do the rooms above ask of a rigid surface, exact or of triangles? Read `protocol`,
`body` (exact geometry), `body_summary`; `closest_point_search` (masters of a user's own);
`nearness` and `sampling` (distances to parts, and points on them).
"""
