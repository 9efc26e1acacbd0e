"""From what the search has found to forces: laws, sums over points, and where the work went."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contiga.arrays.layout import locked
from contiga.arrays.ordered import row_products
from contiga.contact.as_one import grip_as_one
from contiga.contact.checks import PLAIN, checked_answer
from contiga.contact.force_records import Answer, Felt, Frame, LastForces
from contiga.contact.kernels import totals_nb
from contiga.contact.loads import NO_FORCES, NO_SIZES, NONE, NOWHERE, Guards, Loads
from contiga.contact.search_records import Detected
from contiga.contact.state_rows import kept_of
from contiga.contact.touching import ContactRows, PreviousStep
from contiga.jit import straight
from contiga.laws.friction import Friction, FrictionInput, FrictionOutput
from contiga.laws.normal import Law
from contiga.records import ByteArray, FloatArray, IntArray, LawInput, LawOutput
from contiga.slaves.sampling import Sampling


class Response(NamedTuple):
    """What law and friction say of the points that carry."""

    normal: LawOutput
    friction: FrictionOutput | None


class Forces(NamedTuple):
    """What the points that carry feel, and what that sums up to."""

    world: FloatArray
    """(k, 3) forces on them, world axes."""
    viscosity: FloatArray | None
    """(k,) damping over the rate of penetration; None where nothing is damped."""
    wrench: FloatArray
    """(6,) on the body, about its reference point, world axes."""
    energies: FloatArray
    """(5,) where the work went up to now, as `ContactEnergy`."""


NOTHING = NO_SIZES, NO_FORCES, NO_FORCES, NO_SIZES
"""`KeptRows.carried` of the last step, where there was none."""
NO_ENERGIES = np.zeros(5)
NO_GRIP = NOWHERE, NONE, NONE
"""Forces of friction, what it stored and what it lost, where there is none."""


def law_input(
    points: ContactRows,
    patch: IntArray,
    sampling: Sampling,
    area: FloatArray,
    past: PreviousStep | None,
    law: Law,
) -> LawInput:
    """What the law sees of the points that carry; laws that are not ours cannot write to it.

    `patch` (n,) are the faces that all points have their feet on.
    """
    n_memory, depth = law.n_memory, points.depth
    if type(law) not in PLAIN:
        depth, area = locked(depth), locked(area)
    rows, thickness, mass = points.rows, sampling.thickness, sampling.mass
    if past is None or n_memory == 0:
        memory = np.zeros((len(rows), n_memory))
    else:
        memory = kept_of(past.state).part("memory", rows)
    return LawInput(
        depth,
        points.rate,
        area,
        None if thickness is None else thickness[rows],
        None if mass is None else mass[rows],
        0.0 if past is None else past.dt,
        memory,
        patch[rows] if getattr(law, "needs_patch", False) else None,
    )


def respond(
    law: Law,
    friction: Friction | None,
    points: ContactRows,
    inp: LawInput,
    past: PreviousStep | None,
) -> Response:
    """What law and friction answer, in arrays of their own."""
    answer = checked_answer(law, inp)
    if friction is None:
        return Response(answer, None)
    seen = _friction_input(friction, points, answer, inp, past)
    if getattr(law, "acts_as_one", False) and len(points.rows):
        gripped = grip_as_one(friction, points, seen, past)
    else:
        gripped = friction.respond(seen)
    force = np.empty(points.normal.shape)
    force[...] = gripped.force
    return Response(answer, gripped._replace(force=force))


def _friction_input(
    friction: Friction,
    points: ContactRows,
    answer: LawOutput,
    inp: LawInput,
    past: PreviousStep | None,
) -> FrictionInput:
    rows, n = points.rows, points.normal
    if past is None:
        before, memory = np.zeros_like(n), np.zeros((len(rows), friction.n_memory))
        velocity = np.zeros_like(n)
    else:
        kept = kept_of(past.state)
        before, memory = kept.part("normal_B", rows), kept.part("friction_memory", rows)
        velocity = points.path / past.dt if past.velocity is None else points.velocity
    return FrictionInput(
        normal=locked(n),
        normal_before=before,
        force=answer.force,
        stiffness=_stiffness(points, answer),
        area=locked(inp.area),
        path=points.path * _part_inside(points)[:, None],
        velocity=velocity,
        dt=inp.dt,
        memory=memory,
    )


def _stiffness(points: ContactRows, answer: LawOutput) -> FloatArray:
    """(k,) of the normal force over the penetration; on a plateau of its curve the secant."""
    elastic = answer.force if answer.damping is None else answer.force - answer.damping
    secant = np.zeros(len(elastic))
    np.divide(elastic, points.depth, out=secant, where=points.depth > 0.0)
    return np.where(answer.stiffness > 0.0, answer.stiffness, np.maximum(secant, 0.0))


def _part_inside(points: ContactRows) -> FloatArray:
    """(k,) share of the step's path that a point has gone in contact: of a new one what is below
    the tangent plane at its foot, and nothing of a path that leads away from there."""
    way = -row_products(points.path, points.normal)
    inside = np.zeros(len(way))
    np.divide(np.minimum(points.depth, way), way, out=inside, where=way > 0.0)
    return np.where(points.old, 1.0, inside)


def forces(
    points: ContactRows,
    response: Response,
    p_B: FloatArray,
    past: PreviousStep | None,
    frame: tuple[FloatArray, FloatArray],
) -> Forces:
    """Forces of the points that carry, and where the work done on the contact went, up to now.

    `p_B` (m, 3) are all points, `frame` the pose of the body and its reference point.
    """
    (force, _, stored, _, hysteresis, damping, _), grip = response
    k = len(points.rows)
    felt = Felt(np.empty((k, 3)), np.empty(k), np.empty(totals_nb.TOTALS))
    lost = NONE if hysteresis is None else hysteresis
    damped = NONE if damping is None else damping
    held = NO_GRIP if grip is None else (grip.force, _row(grip.stored), _row(grip.lost))
    if past is None:
        last = LastForces(*NOTHING, NO_ENERGIES, p_B, NO_FORCES)
    else:
        state = past.state
        last = LastForces(*kept_of(state).carried, state.energies, state.points_B, NO_FORCES)
    answer = Answer(force, stored, lost, damped, *held)
    viscous = straight(totals_nb.forces)(points, answer, last, p_B, Frame(*frame), felt)
    totals = felt.totals
    energies = totals[totals_nb.WORK :]
    if past is None:
        all_stored = totals[totals_nb.STORED]
        energies[:] = all_stored, all_stored, 0.0, 0.0, 0.0
    viscosity = felt.viscosity if viscous else None
    return Forces(felt.force, viscosity, totals[: totals_nb.WORK], energies)


def _row(values: FloatArray) -> FloatArray:
    """What is only summed, as kernels take it."""
    return np.array(values, dtype=np.float64).reshape(-1)


def whole_of(
    detected: Detected, places: tuple[FloatArray, FloatArray], felt: Forces
) -> dict[str, FloatArray | IntArray | ByteArray]:
    """The arrays of a state that say something of all points, or of none, by name.

    `places` are those of the points, body axes, and the pose.
    """
    feet, (p_B, X_WB) = detected.feet, places
    return {
        "status": detected.status,
        "feature": feet.feature,
        "patch": feet.patch,
        "uv": detected.uv,
        "last_patch": detected.last_patch,
        "points_B": p_B,
        "pose": X_WB,
        "certified": feet.certified,
        "safe_distance": detected.safe_distance,
        "wrench": felt.wrench,
        "energies": felt.energies,
    }


def loads_of(
    held: ContactRows, opposed: Guards, points: ContactRows, response: Response, felt: Forces
) -> Loads:
    """What a state keeps of the points in contact, `held`, also where they carry no forces.

    `opposed` are those whose nearest wall is opposite.
    """
    (force, stiffness, _, memory, _, damping, tangent), grip = response
    rows, depth, normal, foot, *_ = held
    carried = points.rows, force, stiffness, memory, felt.world
    loads = Loads(rows, depth, normal, foot, *carried, opposed=opposed, tangent=tangent)
    if felt.viscosity is not None:
        loads = loads._replace(damping=damping, viscosity=felt.viscosity)
    if grip is not None:
        # Copies: whoever worked these out may go on with theirs.
        memory, tangential = np.array(grip.memory), np.array(grip.stiffness)
        loads = loads._replace(friction_memory=memory, traction=grip.force, tangential=tangential)
    return loads
