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

# Of the length of a table: what a strain may be past its end by rounding.
_PAST = 1e-9
# Of the energy that elements take: what hourglass modes may have of it.
_HOURGLASS = 0.1
# And of the largest energy of any kind: below it all of theirs is next to nothing.
_NOTHING = 1e-4


def check_matter_ran(
    scene: Scene, history: Mapping[str, FloatArray], last: SystemState
) -> Iterator[Finding]:
    """Report strains beyond the tables of materials, and much energy in hourglass modes."""
    for name, nodes in scene.model.mechanism.nodes.items():
        if isinstance(nodes, DeformingNodes):
            # The largest strain of each part, by the table that it is farthest beyond.
            reached = nodes.reached(last.slaves[name])
            for part in dict.fromkeys(part.name for part in nodes.parts):
                own = [one for one in reached if one.part == part]
                worst = max(own, key=lambda one: one.strain / one.end, default=None)
                if worst is not None and worst.strain > (1.0 + _PAST) * worst.end:
                    yield Finding(
                        "table",
                        f"slave {name}",
                        f"the {worst.what} of {elements_of(part, nodes.parts)} reaches "
                        f"{worst.strain:.3g}, and its table ends at {worst.end:.3g}: beyond that "
                        f"it is {BEYOND['linear']}",
                        "Let the table go as far as the matter does",
                    )
    if "energy.hourglass" in history:
        # Hourglass modes that have much of what elements take, lost or stored, at the most of both.
        of = {name: history[f"energy.{name}"] for name in ("strain", "hysteresis", "viscosity")}
        taken = float(np.max(sum(of.values())))
        modes = float(np.max(history["energy.hourglass"]))
        others = [*of, "kinetic", "contact", "external"]
        largest = max(float(np.abs(history[f"energy.{name}"]).max()) for name in others)
        if taken > 0.0 and modes > _HOURGLASS * taken and modes > _NOTHING * largest:
            said = scene.said
            yield Finding(
                "hourglass",
                "elements",
                f"hourglass modes of hexahedra take {said(modes, 'energy')}, "
                f"{100.0 * modes / taken:.3g} % of the {said(taken, 'energy')} of their strain: "
                "they are pushed at single nodes, or too coarse for how they bend",
                "Mesh it finer where it is bent and pushed, spread forces over facets, or raise "
                "hourglass",
            )
