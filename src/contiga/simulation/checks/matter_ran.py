"""Find strains beyond tables and energy in hourglass modes after a run."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from contiga.dynamics.deforming_nodes import DeformingNodes
from contiga.records import FloatArray
from contiga.simulation.checks.finding import Finding
from contiga.simulation.checks.layers import BEYOND
from contiga.simulation.checks.material_checks import elements_of
from contiga.simulation.checks.scene import Scene
from contiga.simulation.system_state import SystemState

# Strain past the end of a table by rounding, relative.
_TABLE_TOL = 1e-9
# Largest share of hourglass energy in the energy of elements.
_MAX_HOURGLASS_SHARE = 0.1
# Energies below this share of the largest one are negligible.
_NEGLIGIBLE = 1e-4


def check_matter_ran(
    scene: Scene, history: Mapping[str, FloatArray], last: SystemState
) -> Iterator[Finding]:
    """Report strains beyond the tables of materials, and much energy in hourglass modes.

    Much is more than `_MAX_HOURGLASS_SHARE` of the energy of elements, unless that is negligible.
    `last` is the state at the end, which remembers the largest strains.
    """
    for name, nodes in scene.model.mechanism.nodes.items():
        if isinstance(nodes, DeformingNodes):
            # The largest strain of each part, relative to the end of its table.
            largest_strains = nodes.reached(last.slaves[name])
            for part in dict.fromkeys(part.name for part in nodes.parts):
                of_part = [reached for reached in largest_strains if reached.part == part]
                worst = max(of_part, key=lambda reached: reached.strain / reached.end, default=None)
                if worst is not None and worst.strain > (1.0 + _TABLE_TOL) * worst.end:
                    yield Finding(
                        "table",
                        f"slave {name}",
                        f"the {worst.what} of {elements_of(part, nodes.parts)} reaches "
                        f"{worst.strain:.3g}, and its table ends at {worst.end:.3g}: beyond that "
                        f"it is {BEYOND['linear']}",
                        "Let the table go as far as the matter does",
                    )
    if "energy.hourglass" in history:
        # Large hourglass energy relative to the energy of elements, lost or stored.
        energies = {
            name: history[f"energy.{name}"] for name in ("strain", "hysteresis", "viscosity")
        }
        element_energy = float(np.max(sum(energies.values())))
        modes = float(np.max(history["energy.hourglass"]))
        names = [*energies, "kinetic", "contact", "external"]
        largest = max(float(np.abs(history[f"energy.{name}"]).max()) for name in names)
        if (
            element_energy > 0.0
            and modes > _MAX_HOURGLASS_SHARE * element_energy
            and modes > _NEGLIGIBLE * largest
        ):
            fmt = scene.fmt
            yield Finding(
                "hourglass",
                "elements",
                f"hourglass modes of hexahedra take {fmt(modes, 'energy')}, "
                f"{100.0 * modes / element_energy:.3g} % of the {fmt(element_energy, 'energy')} of "
                "their strain: they are pushed at single nodes, or too coarse for how they bend",
                "Mesh it finer where it is bent and pushed, spread forces over facets, or raise "
                "hourglass",
            )
