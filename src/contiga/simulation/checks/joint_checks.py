"""Checks of joints: what they move at the start, and constraints that depend on others."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from contiga.arrays.ordered import length
from contiga.dynamics.linkage import OPEN
from contiga.dynamics.rigid_bodies import started
from contiga.rigid.rigid_lanes import VELOCITY
from contiga.simulation.checks.finding import Finding
from contiga.simulation.checks.scene import Scene
from contiga.simulation.clock import Clock
from contiga.simulation.step import advance


def check_joints(scene: Scene) -> Iterator[Finding]:
    """Bodies that joints move or set in motion at the start, and redundant constraints."""
    model, said = scene.model, scene.said
    if not model.joints:
        return
    fit, names = model.joint_fit, list(model.bodies)
    bodies = [names[i] for i in model.mechanism.free]
    size = float(model.linkage.table.size[0])
    off = np.maximum(fit.moved / size, fit.turned)
    if (worst := int(np.argmax(off))) >= 0 and off[worst] > OPEN:
        count = int((off > OPEN).sum())
        yield Finding(
            "joint",
            f"body {bodies[worst]}",
            f"joints that close have {count} free bodies elsewhere than they stand; this one "
            f"is moved by {said(float(fit.moved[worst]))} and turned by "
            f"{np.degrees(fit.turned[worst]):.3g}°",
            "Place them so that the points and axes of their joints meet, if that was not meant",
        )
    given = started(fit.rows, model.mechanism.fixed)
    begun = advance(model, None, model.stepping.start, Clock()).state
    changes = begun.rigid[:, VELOCITY : VELOCITY + 3] - given.rows[:, VELOCITY : VELOCITY + 3]
    speeds = [length(change) for change in changes]
    fastest = float(np.sqrt(np.square(given.rows[:, VELOCITY : VELOCITY + 3]).sum(axis=1)).max())
    worst = int(np.argmax(speeds))
    if speeds[worst] > OPEN * fastest:
        yield Finding(
            "joint",
            f"body {bodies[worst]}",
            "its joints do not allow the velocity and spin that it and its neighbours start with: "
            f"its centre starts {said(speeds[worst], 'velocity')} from what is given",
            "Give velocities and spins that go together, if that was not meant",
        )
    if fit.redundant:
        yield Finding(
            "redundant",
            f"joints {', '.join(fit.dependent)}",
            f"{fit.redundant} of their constraints follow from the others: the motion is right, "
            "and the reactions told are the least of those that have it",
            "Remove what holds the same twice; where reactions of each are needed in a loop, take "
            "joints that hold less, as a spherical or cylindrical one in place of a revolute",
        )
