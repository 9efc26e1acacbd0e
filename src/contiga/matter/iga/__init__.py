"""Shells and membranes on splines as matter: control points are the degrees of freedom.

In reading order: `basis` (basis functions of a patch), `pieces` (patches cut where their slope may
jump), `checks` (what is refused), `net` (patches that share control points), `elements` (Gauss
points, and the shell's axes at rest), `points` (x = N q of points of contact and of what is drawn),
`slopes` (across joints and at planes of symmetry), `inside` (stress and strain), `shell`,
`assemble`. Patches are arrays: anything with degrees, knots, control points and weights, as
`contiga.NurbsSurface` has them.
"""

from __future__ import annotations

from contiga.matter.iga.assemble import assemble_shell
from contiga.matter.iga.net import Net, join
from contiga.matter.iga.pieces import Joint
from contiga.matter.iga.points import SparseRows, SplinePoints
from contiga.matter.iga.shell import Shell
from contiga.matter.iga.slopes import Symmetry

__all__ = [
    "Joint",
    "Net",
    "Shell",
    "SparseRows",
    "SplinePoints",
    "Symmetry",
    "assemble_shell",
    "join",
]
