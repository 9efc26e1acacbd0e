"""Find steps that are too long for elements, and nodes that belong to none."""

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

MUCH = 0.05
"""Share of its mass that a part may be given before it is told."""


def added_masses(nodes: NodeMover) -> tuple[AddedMass, ...]:
    """Return the mass that mass scaling gave each part of a slave; empty without any."""
    matter = getattr(nodes, "matter", None)
    added: tuple[AddedMass, ...] = getattr(matter, "added", ())
    return added


def check_matter(scene: Scene) -> Iterator[Finding]:
    """Report what a run would refuse at its first step, and nodes that nothing moves."""
    model, stepping = scene.model, scene.model.stepping
    if not model.mechanism.deforms:
        return
    standing = place(model, None, stepping.start)
    for name, part in model.slaves.items():
        # Places at which no way of a node is held or driven, though they are given.
        if not isinstance(part.motion, Deforming):
            continue
        for key in ("fixed", "driven"):
            given = getattr(part.motion, key)
            several = isinstance(given, Sequence) and not isinstance(given, str)
            for table in given if several else [given]:
                if isinstance(table, Mapping) and len(table.get("hold", "x")) == 0:
                    yield Finding(
                        "held",
                        f"slave {name}",
                        f"a table of {key} has hold = []: that leaves all ways free",
                        'Name the ways, as hold = ["x", "y", "z"], or leave hold out for all of '
                        "them",
                    )
    for name, nodes in model.mechanism.joined.items():
        critical = Rates(*nodes.rates(standing.slaves[name])).critical
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
        for one in added:
            if one.share > MUCH:
                yield Finding(
                    "scaled",
                    f"slave {name}",
                    f"mass scaling gives {one.part} {100.0 * one.share:.3g} % more mass than its "
                    f"{one.mass:.4g}: it weighs and resists as much more",
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
