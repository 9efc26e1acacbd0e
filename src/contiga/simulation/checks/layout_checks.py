"""Find parts of a model that do nothing, and contacts that are there twice."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from contiga.dynamics.free import Dependent, Free
from contiga.dynamics.prescribed import Moved, Poses, Rotate, Translate
from contiga.dynamics.stepping import AutoSteps, EqualSteps
from contiga.simulation.checks.finding import Finding
from contiga.simulation.checks.scene import Scene

# Of the run: a table of motion that covers less is most likely in another unit.
_SHORT = 0.05
# More steps than runs are made of: one is most likely in another unit.
_MANY_STEPS = 150_000


def check_layout(scene: Scene) -> Iterator[Finding]:
    """Report what has no effect or twice the effect, tables outside the run, many steps."""
    model = scene.model
    used = {part.slave for part in model.contacts} | model.mechanism.tied.keys()
    for name, slave in model.slaves.items():
        if name not in used and not model.mechanism.nodes[name].joined:
            yield Finding(
                "unused",
                f"slave {name}",
                "no contact has it",
                f'Give it a [[contact]] with slave = "{name}", or take it out',
            )
        elif name in used and not slave.slave.active.any():
            yield Finding(
                "inactive",
                f"slave {name}",
                f"none of its {len(slave.slave)} points takes part in contact: no facet has them",
                "Choose parts that have facets, or take its points as a cloud",
            )
    model = scene.model
    used = {part.master for part in model.contacts} | {
        sensor.body for sensor in model.point_sensors
    }
    used |= {body for sensor in model.relative for body in sensor.between}
    used |= {end for spring in model.springs.values() for end in spring.between}
    used |= {end for joint in model.joints.values() for end in joint.between}
    used |= {load.body for load in model.loads}
    every: list[object] = [part.motion for part in model.bodies.values()]
    every += [part.motion for part in model.slaves.values()]
    used |= {host for motion in every if isinstance(motion, Dependent) for host in motion.hosts}
    for name, body in model.bodies.items():
        if name not in used and not isinstance(body.motion, Free):
            yield Finding(
                "unused",
                f"body {name}",
                "no contact, spring, joint, load or sensor has it",
                f'Give it a [[contact]] with master = "{name}", or take it out',
            )
    # Tables of motion that are over, or not begun, in most of the run.
    said = scene.said
    start, end = model.stepping.start, model.stepping.end
    motions = [(f"body {name}", part.motion) for name, part in model.bodies.items()]
    motions += [
        (f"slave {name}", part.motion.motion)
        for name, part in model.slaves.items()
        if isinstance(part.motion, Moved)
    ]
    for where, motion in motions:
        if not isinstance(motion, Translate | Rotate | Poses):
            continue
        first, last = float(motion.times[0]), float(motion.times[-1])
        if min(last, end) - max(first, start) < _SHORT * (end - start):
            yield Finding(
                "span",
                where,
                f"its table goes from t = {first:.4g} to {said(last, 'time')}, and the run from "
                f"{start:.4g} to {said(end, 'time')}: outside the table it stands still",
                f"Give times in {said.unit('time')}, or let the run end with the table",
            )
    # Steps so short that a run takes many more than any that is meant.
    stepping = scene.model.stepping
    if isinstance(stepping, EqualSteps | AutoSteps):
        longest = stepping.most if isinstance(stepping, AutoSteps) else stepping.step
        count = (stepping.end - stepping.start) / longest
        if count > _MANY_STEPS:
            yield Finding(
                "steps",
                "time",
                f"its steps are no longer than {scene.said(longest, 'time')}: until "
                f"{scene.said(stepping.end, 'time')} they are {count:.3g} or more",
                'Look at the unit of step and largest; step = "auto" takes as many as are needed',
            )
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
        if pair.free or not pair.foretold or pair.relative is None or pair.touches:
            continue
        if (np.ptp(pair.relative, axis=0) == 0.0).all():
            yield Finding(
                "still",
                pair.where,
                f"neither {pair.part.master} nor {pair.part.slave} moves, and they do not touch",
                "Give one of them a motion",
            )
