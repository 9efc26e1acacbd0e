"""Check joints: bodies that they move at the start, and redundant constraints."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from contiga.arrays.ordered import length
from contiga.dynamics.linkage import OPEN
from contiga.dynamics.rigid_bodies import bodies_at_start
from contiga.rigid.rigid_lanes import VELOCITY
from contiga.simulation.checks.finding import Finding
from contiga.simulation.checks.scene import Scene
from contiga.simulation.clock import Clock
from contiga.simulation.model import Model
from contiga.simulation.step import advance


def check_joints(scene: Scene) -> Iterator[Finding]:
    """Report bodies that joints move or set in motion at the start, of each kind the worst."""
    model, fmt = scene.model, scene.fmt
    if not model.joints:
        return
    fit, names = model.joint_fit, list(model.bodies)
    bodies = [names[i] for i in model.mechanism.free]
    size = float(model.linkage.table.size[0])
    displacement = np.maximum(fit.moved / size, fit.turned)
    worst = int(np.argmax(displacement))
    if displacement[worst] > OPEN:
        count = int((displacement > OPEN).sum())
        moved_text = "1 free body" if count == 1 else f"{count} free bodies"
        yield Finding(
            "joint",
            f"body {bodies[worst]}",
            f"closing the joints moves {moved_text} from the places given; this one "
            f"is moved by {fmt(float(fit.moved[worst]))} and turned by "
            f"{np.degrees(fit.turned[worst]):.3g}°",
            "Place them so that the points and axes of their joints meet, if that was not intended",
        )
    initial = bodies_at_start(fit.rows, model.mechanism.fixed)
    state = advance(model, None, model.stepping.start, Clock()).state
    changes = state.rigid[:, VELOCITY : VELOCITY + 3] - initial.rows[:, VELOCITY : VELOCITY + 3]
    speeds = [length(change) for change in changes]
    fastest = float(np.sqrt(np.square(initial.rows[:, VELOCITY : VELOCITY + 3]).sum(axis=1)).max())
    worst = int(np.argmax(speeds))
    if speeds[worst] > OPEN * fastest:
        yield Finding(
            "joint",
            f"body {bodies[worst]}",
            "its joints do not allow the velocities and spins given to it and its neighbours: "
            f"the velocity of its centre at the start differs by {fmt(speeds[worst], 'velocity')}",
            "Give compatible velocities and spins, if that was not intended",
        )


def joint_notes(model: Model) -> list[str]:
    """Return a note on redundant constraints, which planar loops of revolute joints always have.

    The list is empty if there are none.
    """
    if not model.joints or not model.joint_fit.redundant:
        return []
    fit = model.joint_fit
    return [
        f"joints {', '.join(fit.dependent)}: {fit.redundant} of their constraints follow from the "
        "others: the motion is right, but the reactions are not unique, and the smallest are "
        "reported. Where each reaction is needed, use joints with fewer constraints, such as a "
        "spherical or cylindrical instead of a revolute joint"
    ]
