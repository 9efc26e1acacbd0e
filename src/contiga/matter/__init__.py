"""What deforms: from where nodes are to the forces on them. Arrays only, nothing of geometry.

In reading order: `protocol` (what is asked of matter), `coefficients`, `curves`,
`materials`, `foam`, `woven` (materials), `parts` (elements with their
material, and what is refused of them), `shapes` (elements at rest), `assemble` and `assembled`
(finite elements as matter), `blocks` and `tables` (how kernels are handed them), `skin`.
"""

from __future__ import annotations

from contiga.matter.assemble import assemble
from contiga.matter.assembled import Assembled
from contiga.matter.parts import Part
from contiga.matter.protocol import Matter, MatterEnergy, MatterForces, MatterState

__all__ = [
    "Assembled",
    "Matter",
    "MatterEnergy",
    "MatterForces",
    "MatterState",
    "Part",
    "assemble",
]
