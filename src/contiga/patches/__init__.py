"""Spline patches that form one surface, for shells and for slaves of splines.

In reading order: `basis` (basis functions of a patch), `pieces` (patches cut where their slope may
jump), `checks` (patches that cannot be a shell), `net` (patches that share control points),
`points` (x = N q by sparse rows), `nodes` (nodes of contact on the surface), `splines` (patches,
net and nodes together). Patches are arrays: anything with degrees, knots, control points and
weights, as `contiga.NurbsSurface` has them.
"""
