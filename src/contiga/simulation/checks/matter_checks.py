"""Find steps that are too long for elements, and nodes without elements."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from contiga.dynamics.deforming import Deforming
from contiga.dynamics.nodes import NodeMover
from contiga.dynamics.stepping import EqualSteps
from contiga.matter.mass_scaling import AddedMass
from contiga.simulation.checks.finding import Finding
from contiga.simulation.checks.scene import Scene
from contiga.simulation.critical import Rates
from contiga.simulation.step import place

ADDED_MASS_TOL = 0.05
"""Added mass of a part, as a share of its mass, up to which there is no finding."""


def added_masses(nodes: NodeMover) -> tuple[AddedMass, ...]:
    """Return the mass that mass scaling added to each part of a slave; empty without."""
    matter = getattr(nodes, "matter", None)
    added: tuple[AddedMass, ...] = getattr(matter, "added", ())
    return added


def check_matter(scene: Scene) -> Iterator[Finding]:
    """Report defects of slaves of elements that need no run to be seen.

    These are tables that hold no direction, equal steps above the critical one of the elements,
    mass scaling above `ADDED_MASS_TOL`, and active nodes in no element.
    """
    model, stepping = scene.model, scene.model.stepping
    if not model.mechanism.deforms:
        return
    placement = place(model, None, stepping.start)
    for name, part in model.slaves.items():
        # Tables of held or driven nodes that name no direction.
        if not isinstance(part.motion, Deforming):
            continue
        for key in ("fixed", "driven"):
            tables = getattr(part.motion, key)
            several = isinstance(tables, Sequence) and not isinstance(tables, str)
            for table in tables if several else [tables]:
                if isinstance(table, Mapping) and len(table.get("hold", "x")) == 0:
                    yield Finding(
                        "held",
                        f"slave {name}",
                        f"a table of {key} has hold = []: that leaves all ways free",
                        'Name the ways, as hold = ["x", "y", "z"], or leave hold out for all of '
                        "them",
                    )
    for name, nodes in model.mechanism.element_movers.items():
        critical = Rates(*nodes.rates(placement.slaves[name])).critical
        step = stepping.step if isinstance(stepping, EqualSteps) else 0.0
        if step > critical and not model.allow_unstable:
            yield Finding(
                "critical",
                f"slave {name}",
                f"the step of {step:.4g} is longer than the critical one of its elements, "
                f"{critical:.4g}",
                f'Take a step below {0.9 * critical:.3g}, or "auto"',
            )
        added = added_masses(nodes)
        for addition in added:
            if addition.share > ADDED_MASS_TOL:
                yield Finding(
                    "scaled",
                    f"slave {name}",
                    f"mass scaling gives {addition.part} {100.0 * addition.share:.3g} % more mass "
                    f"than its {addition.mass:.4g}: it weighs and resists as much more",
                    "Ask for a shorter step, or mesh it more evenly",
                )
        slave = model.slaves[name].slave
        lone = np.flatnonzero(nodes.bare & slave.active)
        if len(lone):
            where = ", ".join(f"{x:.6g}" for x in slave.points[lone[0]])
            yield Finding(
                "lone",
                f"slave {name}",
                f"{len(lone)} of its points that take part in contact are in no element, the first "
                f"at {where}: they stay where they are",
                "Choose parts of the mesh that have elements, or leave these points out",
            )
