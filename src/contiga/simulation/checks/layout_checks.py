"""Checks of how a model is put together: parts that do nothing, contacts that are there twice."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from contiga.dynamics.free import Attached, Free
from contiga.simulation.checks.finding import Finding
from contiga.simulation.checks.scene import Pair, Scene


def check_layout(scene: Scene) -> Iterator[Finding]:
    """Slaves and contacts that have no effect, or twice the effect."""
    model = scene.model
    used = {part.slave for part in model.contacts}
    for name, slave in model.slaves.items():
        if name not in used:
            yield Finding(
                "unused",
                f"slave {name}",
                "no contact has it",
                f'Give it a [[contact]] with slave = "{name}", or take it out',
            )
        elif not slave.slave.active.any():
            yield Finding(
                "inactive",
                f"slave {name}",
                f"none of its {len(slave.slave)} points takes part in contact: no facet has them",
                "Choose parts that have facets, or take its points as a cloud",
            )
    yield from _bodies(scene)
    seen: dict[tuple[str, str], str] = {}
    for pair in scene.pairs:
        key = pair.part.master, pair.part.slave
        if key in seen:
            yield Finding(
                "twice",
                pair.where,
                f"{seen[key]} has the same body and the same slave: both push",
                "Take one of them out, or give them different parts of the slave",
            )
        seen.setdefault(key, pair.part.name)
        if _still(pair) and not pair.touches:
            yield Finding(
                "still",
                pair.where,
                f"neither {pair.part.master} nor {pair.part.slave} moves, and they do not touch",
                "Give one of them a motion",
            )


def _bodies(scene: Scene) -> Iterator[Finding]:
    model = scene.model
    used = {part.master for part in model.contacts} | {sensor.body for sensor in model.sensors}
    used |= {end for spring in model.springs.values() for end in spring.between}
    used |= {load.body for load in model.loads}
    motions: list[object] = [part.motion for part in model.bodies.values()]
    motions += [part.motion for part in model.slaves.values()]
    used |= {motion.body for motion in motions if isinstance(motion, Attached)}
    for name, body in model.bodies.items():
        if name not in used and not isinstance(body.motion, Free):
            yield Finding(
                "unused",
                f"body {name}",
                "no contact, spring, load or sensor has it",
                f'Give it a [[contact]] with master = "{name}", or take it out',
            )


def _still(pair: Pair) -> bool:
    """Whether nothing moves one side against the other."""
    if pair.free or not pair.foretold or pair.relative is None:
        return False
    return bool((np.ptp(pair.relative, axis=0) == 0.0).all())
