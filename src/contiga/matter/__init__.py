"""Matter that deforms: from positions of nodes to forces on them. Arrays only, no geometry.

In reading order: `protocol` (methods of matter), `coefficients` and `curves` (parameters of
materials), `materials`, `foam`, `woven`, `parts` (elements with their material, and their checks),
`shapes` (elements at rest), `assemble` and `assembled` (finite elements as matter), `mass_scaling`,
`blocks` and `tables` (tables for kernels), `skin`; `stress`, `strain` and `element_fields` (fields
in elements); `iga` (shells and membranes on splines, a room of its own).

>>> import numpy as np
>>> from contiga.materials import Elastic
>>> from contiga.matter import Part, assemble
>>> bar = Part(
...     kind="bar2",
...     elements=np.array([[0, 1]]),
...     material=Elastic(young=2.0),
...     density=3.0,
...     section=0.5,
... )
>>> matter = assemble([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0]], [bar])
>>> answer = matter.forces(matter.start(), 1.1 * matter.nodes, np.zeros((2, 3)), 0.0)
>>> answer.force.round(12).tolist(), matter.mass.tolist()
([[0.1, 0.0, 0.0], [-0.1, 0.0, 0.0]], [1.5, 1.5])
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
