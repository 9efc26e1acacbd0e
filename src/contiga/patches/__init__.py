"""Spline patches that are one surface: what shells and slaves of splines have in common.

In reading order: `basis` (basis functions of a patch), `pieces` (patches cut where their slope may
jump), `checks` (what is refused), `net` (patches that share control points), `points` (x = N q by
sparse rows), `nodes` (points of the surface that contact sees), `splines` (patches, net and nodes
together). Patches are arrays: anything with degrees, knots, control points and weights, as
`contiga.NurbsSurface` has them.
"""
