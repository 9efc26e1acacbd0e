"""Find parts of a model without effect, tables outside the run, and contacts defined twice."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from contiga.dynamics.free import Dependent, Free
from contiga.dynamics.prescribed import Moved, Poses, Rotate, Translate
from contiga.dynamics.stepping import AutoSteps, EqualSteps
from contiga.simulation.checks.finding import Finding
from contiga.simulation.checks.scene import Scene

# Smallest share of the run that a table of motion should cover; less suggests another unit.
_MIN_COVERAGE = 0.05
# Largest plausible number of steps; more suggest another unit.
_MAX_STEPS = 150_000


def check_parts(scene: Scene) -> Iterator[Finding]:
    """Report slaves and bodies that nothing refers to, and slaves in contact without active points.

    Slaves of elements and free bodies may stand alone.
    """
    model = scene.model
    used_slaves = {part.slave for part in model.contacts} | model.mechanism.tied.keys()
    for name, slave in model.slaves.items():
        if name not in used_slaves and not model.mechanism.nodes[name].has_elements:
            yield Finding(
                "unused",
                f"slave {name}",
                "no contact has it",
                f'Give it a [[contact]] with slave = "{name}", or take it out',
            )
        elif name in used_slaves and not slave.slave.active.any():
            yield Finding(
                "inactive",
                f"slave {name}",
                f"none of its {len(slave.slave)} points takes part in contact: no facet has them",
                "Choose parts that have facets, or take its points as a cloud",
            )
    used_bodies = {part.master for part in model.contacts}
    used_bodies |= {sensor.body for sensor in model.point_sensors}
    used_bodies |= {body for sensor in model.relative for body in sensor.between}
    used_bodies |= {end for spring in model.springs.values() for end in spring.between}
    used_bodies |= {end for joint in model.joints.values() for end in joint.between}
    used_bodies |= {load.body for load in model.loads}
    body_motions: list[object] = [part.motion for part in model.bodies.values()]
    for motion in (*body_motions, *(part.motion for part in model.slaves.values())):
        if isinstance(motion, Dependent):
            used_bodies |= set(motion.hosts)
    for name, body in model.bodies.items():
        if name not in used_bodies and not isinstance(body.motion, Free):
            yield Finding(
                "unused",
                f"body {name}",
                "no contact, spring, joint, load or sensor has it",
                f'Give it a [[contact]] with master = "{name}", or take it out',
            )


def check_times(scene: Scene) -> Iterator[Finding]:
    """Report tables of motion that cover less than `_MIN_COVERAGE` of the run, and tiny steps.

    Steps are tiny if the run has more than `_MAX_STEPS` of them, the largest if they are automatic.
    """
    model, fmt = scene.model, scene.fmt
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
        if min(last, end) - max(first, start) < _MIN_COVERAGE * (end - start):
            yield Finding(
                "span",
                where,
                f"its table goes from t = {first:.4g} to {fmt(last, 'time')}, and the run from "
                f"{start:.4g} to {fmt(end, 'time')}: outside the table it stands still",
                f"Give times in {fmt.unit('time')}, or let the run end with the table",
            )
    stepping = model.stepping
    if isinstance(stepping, EqualSteps | AutoSteps):
        longest = stepping.most if isinstance(stepping, AutoSteps) else stepping.step
        count = (stepping.end - stepping.start) / longest
        if count > _MAX_STEPS:
            yield Finding(
                "steps",
                "time",
                f"its steps are no longer than {fmt(longest, 'time')}: until "
                f"{fmt(stepping.end, 'time')} they are {count:.3g} or more",
                'Look at the unit of step and largest; step = "auto" takes as many as are needed',
            )


def check_pairs(scene: Scene) -> Iterator[Finding]:
    """Report contacts of a pair that has one already, and pairs that neither move nor touch.

    The latter need motions that are known to the end.
    """
    pair_names: dict[tuple[str, str], str] = {}
    for pair in scene.pairs:
        key = pair.part.master, pair.part.slave
        if key in pair_names:
            yield Finding(
                "twice",
                pair.where,
                f"{pair_names[key]} has the same body and the same slave: both push",
                "Take one of them out, or give them different parts of the slave",
            )
        pair_names.setdefault(key, pair.part.name)
        if pair.free or not pair.foretold or pair.relative is None or pair.touches:
            continue
        if (np.ptp(pair.relative, axis=0) == 0.0).all():
            yield Finding(
                "still",
                pair.where,
                f"neither {pair.part.master} nor {pair.part.slave} moves, and they do not touch",
                "Give one of them a motion",
            )
