"""Shells and membranes on splines as matter: control points are the degrees of freedom.

They use `contiga.patches`, which joins patches. In reading order: `elements` (points of
elements, and the shell's axes at rest), `slopes` (springs across joints, at clamps and planes of
symmetry), `inside` (stress and strain), `shell`, `assemble`.
"""

from __future__ import annotations

from contiga.matter.iga.assemble import assemble_shell
from contiga.matter.iga.shell import Shell
from contiga.matter.iga.slopes import Symmetry
from contiga.patches.net import Net, join
from contiga.patches.pieces import Joint
from contiga.patches.points import SparseRows, SplinePoints

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
