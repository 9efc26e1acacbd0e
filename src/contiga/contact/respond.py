"""From what the search has found to forces: rates, laws, friction, and where the work went.

Points that carry as one are those of a law that gives one force for all of them. The point that
carries passes from node to node as bodies slide and roll; what friction holds must not stay behind
with the nodes. It is that of one point: with the sum of the normal forces, their mean normal, and
the mean way of the points, weighted by their shares at both ends of the step, so that its work is
that of its forces on the points, to second order.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from contiga.arrays.layout import as_numbers, as_points, locked, real
from contiga.arrays.ordered import length, product
from contiga.arrays.threads import run_ranges
from contiga.contact.kernels import carrying_nb, relative_nb, totals_nb
from contiga.contact.loads import NO_FORCES, NO_ROWS, NO_SIZES, NONE, NOWHERE, Column
from contiga.contact.search_records import BoolArray, Detected
from contiga.contact.shape import Shape
from contiga.contact.state import State
from contiga.errors import InputError
from contiga.jit import straight
from contiga.laws.friction import (
    Coulomb,
    Friction,
    FrictionInput,
    FrictionOutput,
    ViscousFriction,
)
from contiga.laws.normal import AdaptiveLaw, Law, PenaltyLaw
from contiga.records import (
    ByteArray,
    FloatArray,
    IndexArray,
    IntArray,
    LawInput,
    LawOutput,
    SurfacePlaces,
)
from contiga.rigid.frames import POINTS
from contiga.slaves.sampling import Sampling

PLAIN = frozenset({PenaltyLaw, AdaptiveLaw})
"""Laws of this package, and none derived from them, that ask nothing of users' curves."""
OWN_FRICTION = frozenset({Coulomb, ViscousFriction})
"""Frictions of this package, and none derived from them, which write to none of their input."""
NO_ENERGIES = np.zeros(5)

Velocities: TypeAlias = tuple[ArrayLike, ArrayLike]
"""(v, w): velocity of a frame's origin and its spin, world axes."""


class RelativeVelocity(NamedTuple):
    """Velocities of points against a body, which are worked out of those that are asked for."""

    sampling: Sampling
    nodes: FloatArray
    """(n, 3) velocities of the slave's nodes, world axes."""
    points: FloatArray
    """(m, 3) places of all points, world axes."""
    pose: FloatArray
    twist: FloatArray
    """(2, 3) velocity of the body's origin and its spin, world axes."""

    def at(self, rows: IndexArray) -> FloatArray:
        """Return (k, 3) of points `rows`, ascending, body axes."""
        p_W, v_W = self.points.take(rows, axis=0), self.nodes
        v_W = self.sampling.points_at(rows, v_W) if self.sampling.first else v_W.take(rows, axis=0)
        v_B = np.empty(v_W.shape)
        given = v_W, p_W, self.pose, self.twist, v_B
        run_ranges(straight(relative_nb.relative), len(rows), POINTS, *given)
        return v_B


def relative_velocity(
    sampling: Sampling,
    p_W: FloatArray,
    poses: tuple[FloatArray, FloatArray],
    velocity: ArrayLike | None,
    twist: Velocities | FloatArray | None,
) -> RelativeVelocity | None:
    """Return how the points p_W (m, 3) go against the body; None where no velocity is given.

    `poses` are those of the body before and now.
    """
    if velocity is None:
        if twist is not None:
            raise InputError(
                "the twist of the master is given and the velocity of the slave is not",
                where="velocity",
                allowed="both or neither",
                remedy="Give velocity=(n, 3), zeros of a slave that stands still",
            )
        return None
    if twist is None and not np.array_equal(*poses):
        raise InputError(
            "the velocity of the slave is given and the twist of the master, which moves, is not",
            where="twist",
            allowed="both or neither",
            remedy="Give twist=(v, w): velocity of the master's origin and its spin",
        )
    v_W = as_points(velocity, "velocity")
    if len(v_W) != sampling.n_nodes:
        raise InputError(
            "velocity must have one row a slave point",
            where="velocity",
            found=len(v_W),
            allowed=str(sampling.n_nodes),
        )
    first = straight(relative_nb.first_unknown)(v_W, p_W)
    if first >= 0:
        raise InputError(
            "a point that has a place has no velocity",
            where=f"velocity[{first}]",
            found=v_W[first].tolist(),
            allowed="three finite numbers a point",
        )
    if twist is None:
        return RelativeVelocity(sampling, v_W, p_W, poses[1], np.zeros((2, 3)))
    real(twist, "twist")
    try:
        body = np.array(twist, np.float64)
    except (TypeError, ValueError):
        body = NONE
    if body.shape != (2, 3) or not np.isfinite(body).all():
        raise InputError(
            "a twist is a velocity and a spin",
            where="twist",
            found=twist,
            allowed="(v, w) of three finite numbers each",
        )
    return RelativeVelocity(sampling, v_W, p_W, poses[1], body)


@dataclass(frozen=True, eq=False)
class PreviousStep:
    """The step before, from which points came where they are."""

    state: State
    """Of the last step."""
    dt: float
    """Zero in statics, where there are no rates."""
    velocity: RelativeVelocity | None
    """Against the body, where it is known exactly."""
    shape: Shape | None = None
    """How the body has changed; None of one that keeps its shape."""

    @cached_property
    def points(self) -> FloatArray:
        """Points (n, 3) before, body axes; those in contact carried along with their feet since."""
        state = self.state
        if self.shape is None:
            return state.points_B
        rows, points = np.flatnonzero(state.patch >= 0), state.points_B.copy()
        feet = SurfacePlaces(state.patch[rows], state.uv[rows])
        points[rows] += self.shape.carried_before(feet, points[rows])
        return points


def feet_carried(past: PreviousStep) -> Column:
    """Return where the surface has carried the feet of the last step, (n, 3) in body axes."""
    rows, feet = past.state.kept.foot_B
    if past.shape is not None:
        feet = feet + (past.points[rows] - past.state.points_B[rows])
    return Column(rows, feet)


class ContactRows(NamedTuple):
    """Points in contact, one row each, body axes."""

    rows: IntArray
    depth: FloatArray
    """(k,) λ."""
    normal: FloatArray
    foot: FloatArray
    path: FloatArray
    """(k, 3) against the surface in the step; zero at the start and of points without a past."""
    inside: FloatArray
    """(k,) share of that path that a point has gone in contact: of a new one what is below the
    tangent plane at its foot, and nothing of a path that leads away from there."""
    old: BoolArray
    """(k,) whether each was in contact before."""
    switched: BoolArray
    """(k,) whether its foot was on another patch or another feature, or nowhere."""
    rate: FloatArray
    """(k,) dλ/dt: exact where velocities are given, else of old contacts the change of λ over the
    step and of new ones their speed of approach; zero at the start."""
    velocity: FloatArray
    """(k, 3) against the body; (0, 3) where velocities are not given."""

    @classmethod
    def of(cls, rows: IntArray, velocity: FloatArray = NOWHERE) -> ContactRows:
        """Make one of these rows, with nothing else filled in."""
        k = len(rows)
        normal, foot, path = np.empty((k, 3)), np.empty((k, 3)), np.empty((k, 3))
        depth, inside, rate = np.empty(k), np.empty(k), np.empty(k)
        old, switched = np.empty((2, k), np.bool_)
        return cls(rows, depth, normal, foot, path, inside, old, switched, rate, velocity)

    def since(self, first: int) -> ContactRows:
        """Return those of them from the point `first` on: the ones that carry forces."""
        k = int(np.searchsorted(self.rows, first))
        return ContactRows._make(values[k:] for values in self)


class LastDepths(NamedTuple):
    """The places and depths of points at the last step."""

    patch: IntArray
    """(n,) patch of their feet, −1 without contact."""
    feature: ByteArray
    """(n,) of their feet."""
    points: FloatArray
    """(n, 3)."""
    rows: IndexArray
    """(k,) the points in contact, ascending."""
    depth: FloatArray
    """(k,) how deep they were."""


def touching(detected: Detected, p_B: FloatArray, past: PreviousStep | None) -> ContactRows:
    """Collect what is known of the points in contact before forces."""
    rows, gather = detected.held, straight(carrying_nb.gather)
    if past is None:
        points = ContactRows.of(rows)
        n = len(p_B)
        nowhere = np.full(n, -1, np.int32), np.full(n, -1, np.int8)
        last = LastDepths(*nowhere, p_B, NO_ROWS, NONE)
        gather(detected.feet, p_B, last, 1.0, points)
        points.rate.fill(0.0)
        return points
    state, there = past.state, past.state.points_B
    velocity = NOWHERE if past.velocity is None else past.velocity.at(rows)
    if past.shape is not None:  # paths and velocities are those against the surface at the foot
        feet, points_B = SurfacePlaces(detected.feet.patch[rows], detected.uv[rows]), p_B[rows]
        there = there.copy()
        there[rows] += past.shape.carried(feet, points_B)
        if past.velocity is not None:
            velocity = velocity - past.shape.velocities(feet, points_B)
    last = LastDepths(state.patch, state.feature, there, *state.kept.penetration)
    points = ContactRows.of(rows, velocity)
    gather(detected.feet, p_B, last, past.dt or np.inf, points)
    return points


class Seen(NamedTuple):
    """Input of friction, of the points that carry forces."""

    points: FrictionInput
    whole: FrictionInput | None = None
    """Input of all points as one, if they carry as one."""
    ways: FloatArray = NONE
    """(k,) what each point's way counts in that of the whole."""
    present: float = 1.0
    """Part of that which is the present share of its normal force."""


class Response(NamedTuple):
    """The answers of law and friction for the points that carry."""

    normal: LawOutput
    friction: FrictionOutput | None
    seen: Seen | None
    """By friction."""


def respond(
    law: Law,
    friction: Friction | None,
    points: ContactRows,
    inp: LawInput,
    past: PreviousStep | None,
) -> Response:
    """Ask law and friction, and return their answers in arrays of their own."""
    answer = checked_answer(law, inp)
    if friction is None:
        return Response(answer, None, None)
    rows, normal = points.rows, points.normal
    if past is None:
        before, memory = np.zeros_like(normal), np.zeros((len(rows), friction.n_memory))
        velocity = np.zeros_like(normal)
    else:
        kept = past.state.kept
        before, velocity = kept.normal_B.at(rows), points.velocity
        memory = np.zeros((len(rows), friction.n_memory))
        if kept.friction_memory is not None:
            memory = kept.friction_memory.at(rows)
        if past.velocity is None:
            velocity = points.path / (past.dt or np.inf)
    # The stiffness is that of the normal force over the penetration; on a plateau of its curve it
    # is the secant.
    elastic = answer.force if answer.damping is None else answer.force - answer.damping
    secant = np.zeros(len(rows))
    np.divide(elastic, points.depth, out=secant, where=points.depth > 0.0)
    stiffness = np.where(answer.stiffness > 0.0, answer.stiffness, np.maximum(secant, 0.0))
    area = inp.area
    if type(friction) not in OWN_FRICTION:  # others cannot write to what is the contact's
        normal, area = locked(normal), locked(area)
    seen = FrictionInput(
        normal=normal,
        normal_before=before,
        force=answer.force,
        stiffness=stiffness,
        area=area,
        path=points.path * points.inside[:, None],
        velocity=velocity,
        dt=inp.dt,
        memory=memory,
    )
    if getattr(law, "acts_as_one", False) and len(rows):
        gripped, handed = _grip_as_one(friction, points, seen, past)
    else:
        gripped, handed = friction.respond(seen), Seen(seen)
    force = np.empty(normal.shape)
    force[...] = gripped.force
    return Response(answer, gripped._replace(force=force), handed)


def checked_answer(law: Law, inp: LawInput) -> LawOutput:
    """Return a law's answer, checked: one row for each point in contact.

    Without any point the law is not asked.

    A row too few or an axis too many would be spread over the points without a word. The arrays are
    copies: whoever worked them out may go on with theirs. Those of `PLAIN` laws are right, and new.
    """
    n = len(inp.penetration)
    if n == 0:
        return LawOutput(np.zeros(0), np.zeros(0), np.zeros(0), np.zeros((0, law.n_memory)))
    if type(law) in PLAIN:
        return law.respond(inp)
    answer: object = law.respond(inp)
    if not isinstance(answer, LawOutput):
        raise InputError(
            "the law must answer a LawOutput",
            where="law",
            found=type(answer).__name__,
            allowed="LawOutput(force, stiffness, stored, memory)",
        )
    checked: list[FloatArray | None] = []
    for name, values in zip(LawOutput._fields, answer._replace(tangent=None), strict=True):
        if values is None and name in LawOutput._field_defaults:
            checked.append(None)
            continue
        numbers = as_numbers(values, f"law: {name}", "the law must answer numbers")
        shape = (n, law.n_memory) if name == "memory" else (n,)
        if numbers.shape != shape:
            raise InputError(
                "the law must answer one row a point in contact",
                where=f"law: {name}",
                found=numbers.shape,
                allowed=str(shape),
            )
        checked.append(numbers)
    return LawOutput(*checked)  # type: ignore[arg-type]  # those without a default are not None


def _grip_as_one(
    friction: Friction, points: ContactRows, inp: FrictionInput, past: PreviousStep | None
) -> tuple[FrictionOutput, Seen]:
    """Return friction's answer for the whole; `inp` is its input for each point."""
    shares = _shares(inp.force)
    before, memory = np.zeros((1, 3)), np.zeros((1, friction.n_memory))
    ways, present = shares, 1.0
    if past is not None and points.old.any():
        last = past.state.kept
        rows, force = last.normal_force
        before = _unit(product(_shares(force), last.normal_B.at(rows)))
        memory[0] = inp.memory[np.argmax(points.old)]  # all that were in contact have the same
        carried = last.normal_force.at(points.rows)
        if carried.any():  # else all that carried have left
            ways, present = _shares(shares + _shares(carried)), 0.5
    seen = FrictionInput(
        normal=_unit(product(shares, inp.normal)),
        normal_before=before,
        force=inp.force.sum(keepdims=True),
        stiffness=inp.stiffness.sum(keepdims=True),
        area=inp.area.sum(keepdims=True),
        path=product(ways, inp.path)[None],
        velocity=product(shares, inp.velocity)[None],
        dt=inp.dt,
        memory=memory,
    )
    whole, column = friction.respond(seen), shares[:, None]
    each = FrictionOutput(
        column * whole.force,
        shares * whole.stiffness,
        shares * whole.stored,
        shares * whole.lost,
        np.repeat(whole.memory, len(shares), axis=0),
    )
    return each, Seen(inp, seen, ways, present)


def _shares(force: FloatArray) -> FloatArray:
    """Shares (k,) of a sum, alike where there is none."""
    whole = force.sum()
    return force / whole if whole > 0.0 else np.full(len(force), 1.0 / max(len(force), 1))


def _unit(vector: FloatArray) -> FloatArray:
    """Return (1, 3) of length one; zero stays."""
    size = length(vector)
    return (vector / size if size > 0.0 else vector)[None]


class Answer(NamedTuple):
    """The answers of law and friction for k points that carry; no rows of what is not told."""

    force: FloatArray
    """(k,) along the normals."""
    stored: FloatArray
    hysteresis: FloatArray
    damping: FloatArray
    """(k,) the part of `force` that is due to the rate."""
    friction: FloatArray
    """(k, 3) forces across the normals, with energies stored and lost by them."""
    held: FloatArray
    lost: FloatArray


class LastForces(NamedTuple):
    """The forces and feet of the last step."""

    force: Column
    normal: Column
    traction: Column
    damping: Column
    energies: FloatArray
    """(5,) as `ContactEnergy` has them."""
    points: FloatArray
    """(n, 3) `PreviousStep.points` of all."""
    none: Column
    """Forces of no points."""


class Frame(NamedTuple):
    """The pose and reference point of the body."""

    pose: FloatArray
    """(4, 4) X_WB."""
    reference_point: FloatArray
    """(3,) that moments are about, body axes."""


class Felt(NamedTuple):
    """The forces that k points that carry feel, and their sums."""

    force: FloatArray
    """(k, 3) on them, world axes."""
    viscosity: FloatArray
    """(k,) damping over the rate of penetration."""
    totals: FloatArray
    """The wrench on the body, and the energies with what the step adds; see `totals_nb`."""


def forces(
    points: ContactRows,
    response: Response,
    p_B: FloatArray,
    past: PreviousStep | None,
    frame: Frame,
) -> tuple[Felt, bool]:
    """Return forces of the points that carry, the ledger of work on the contact, and damping.

    The ledger is up to now; the last says whether any force is damped.

    `p_B` (m, 3) are all points.
    """
    (force, _, stored, _, hysteresis, damping, *_), grip, _ = response
    k = len(points.rows)
    felt = Felt(np.empty((k, 3)), np.empty(k), np.empty(totals_nb.TOTALS))
    gripped = NOWHERE, NONE, NONE
    if grip is not None:  # what is only summed may have any shape
        held, lost = np.array(grip.stored, np.float64), np.array(grip.lost, np.float64)
        gripped = grip.force, held.reshape(-1), lost.reshape(-1)
    answer = Answer(
        force,
        stored,
        NONE if hysteresis is None else hysteresis,
        NONE if damping is None else damping,
        *gripped,
    )
    if past is None:
        last = LastForces(NO_SIZES, NO_FORCES, NO_FORCES, NO_SIZES, NO_ENERGIES, p_B, NO_FORCES)
    else:
        state, kept = past.state, past.state.kept
        last = LastForces(
            kept.normal_force,
            kept.normal_B,
            NO_FORCES if kept.traction_B is None else kept.traction_B,
            NO_SIZES if kept.damping is None else kept.damping,
            state.energies,
            past.points,
            NO_FORCES,
        )
    viscous = straight(totals_nb.forces)(points, answer, last, p_B, frame, felt)
    if past is None:
        all_stored = felt.totals[totals_nb.STORED]
        felt.totals[totals_nb.WORK :] = all_stored, all_stored, 0.0, 0.0, 0.0
    return felt, viscous
