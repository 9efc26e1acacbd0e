"""Rigid motions: poses, twists, screws, quaternions and inertia; signs as `contiga.conventions`.

Question: where is a rigid frame, and how does it move? Read `pose`, `frames`, `twist`,
`screw` (one pose to another), `quaternion`, `inertia`, `rigid_lanes`; `transform` and `movable`
(affine maps).
"""
