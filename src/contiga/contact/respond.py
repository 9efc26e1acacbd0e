"""Compute forces from the results of the search: rates, laws, friction, and energies.

Some laws give one common force for all points. The points that carry it change from node to node as
bodies slide and roll, so that friction must not remember single nodes. It then acts on one
fictitious point with the sum of the normal forces, their mean normal, and the mean path of the
points, weighted by their shares at both ends of the step: its work is the work of its forces on the
points, to second order.
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
from contiga.contact.loads import (
    NO_FORCES,
    NO_POINTS,
    NO_ROWS,
    NO_SIZES,
    NONE,
    UNGUARDED,
    Column,
    KeptColumns,
)
from contiga.contact.search_records import BoolArray, Detection
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

TRUSTED_LAWS = frozenset({PenaltyLaw, AdaptiveLaw})
"""Laws of this package without user curves, not derived ones: their output needs no checks."""
TRUSTED_FRICTION = frozenset({Coulomb, ViscousFriction})
"""Frictions of this package, not derived ones: they do not write to their input."""
NO_ENERGIES = np.zeros(5)

Velocities: TypeAlias = tuple[ArrayLike, ArrayLike]
"""(v, w): velocity of a frame's origin and its spin, world axes."""


class RelativeVelocity(NamedTuple):
    """Velocities of points relative to a body, computed for given rows."""

    sampling: Sampling
    nodes: FloatArray
    """(n, 3) velocities of the slave's nodes, world axes."""
    points: FloatArray
    """(m, 3) places of all points, world axes."""
    pose: FloatArray
    twist: FloatArray
    """(2, 3) velocity of the body's origin and its spin, world axes."""

    def at(self, rows: IndexArray) -> FloatArray:
        """Return the velocities (k, 3) of points `rows`, ascending, body axes."""
        p_W, v_W = self.points.take(rows, axis=0), self.nodes
        v_W = self.sampling.points_at(rows, v_W) if self.sampling.first else v_W.take(rows, axis=0)
        v_B = np.empty(v_W.shape)
        args = v_W, p_W, self.pose, self.twist, v_B
        run_ranges(straight(relative_nb.relative), len(rows), POINTS, *args)
        return v_B


def relative_velocity(
    sampling: Sampling,
    p_W: FloatArray,
    poses: tuple[FloatArray, FloatArray],
    velocity: ArrayLike | None,
    twist: Velocities | FloatArray | None,
) -> RelativeVelocity | None:
    """Return velocities of points p_W (m, 3) relative to the body; None if `velocity` is None.

    The record computes them for the rows that are asked for. `poses` are those of the body before
    and now. A body whose pose stays the same needs no `twist`.

    Raises
    ------
    InputError
        One of `velocity` and `twist` without the other, wrong shapes, a place without a velocity.
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
    first = straight(relative_nb.first_without_velocity)(v_W, p_W)
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
    """The previous step of a contact, with the velocities and the shape of this one."""

    state: State
    """State after the last step."""
    dt: float
    """Length of this step; zero in statics, where there are no rates."""
    velocity: RelativeVelocity | None
    """Given velocities relative to the body; None without."""
    shape: Shape | None = None
    """Change of the body in this step; None for a constant shape."""

    @cached_property
    def points(self) -> FloatArray:
        """Points (n, 3) before, body axes; points in contact are carried along with their feet."""
        state = self.state
        if self.shape is None:
            return state.points_B
        rows, points = np.flatnonzero(state.patch >= 0), state.points_B.copy()
        feet = SurfacePlaces(state.patch[rows], state.uv[rows])
        points[rows] += self.shape.carried_before(feet, points[rows])
        return points


def carried_feet(past: PreviousStep) -> Column:
    """Return the feet (k, 3) of the last step, carried along with the surface; body axes."""
    rows, feet = past.state.kept.foot_B
    if past.shape is not None:
        feet = feet + (past.points[rows] - past.state.points_B[rows])
    return Column(rows, feet)


class ContactRows(NamedTuple):
    """Points in contact, one row each, body axes."""

    rows: IntArray
    depth: FloatArray
    """(k,) penetration λ ≥ 0, length."""
    normal: FloatArray
    """(k, 3) unit normals at the feet, towards the free side."""
    foot: FloatArray
    """(k, 3)."""
    path: FloatArray
    """(k, 3) path relative to the surface in the step; zero at the start or without a past."""
    inside: FloatArray
    """(k,) share of that path in contact: for a new point the share below the tangent plane at its
    foot, zero for a path away from there."""
    old: BoolArray
    """(k,) whether each was in contact before."""
    switched: BoolArray
    """(k,) whether its foot was on another patch or another feature, or did not exist."""
    rate: FloatArray
    """(k,) dλ/dt: exact if velocities are given, else the change of λ over the step for old
    contacts and the speed of approach for new ones; zero at the start."""
    velocity: FloatArray
    """(k, 3) relative to the body; (0, 3) if velocities are not given."""

    @classmethod
    def of(cls, rows: IntArray, velocity: FloatArray = NO_POINTS) -> ContactRows:
        """Return a record for these rows with uninitialised columns."""
        k = len(rows)
        normal, foot, path = np.empty((k, 3)), np.empty((k, 3)), np.empty((k, 3))
        depth, inside, rate = np.empty(k), np.empty(k), np.empty(k)
        old, switched = np.empty((2, k), np.bool_)
        return cls(rows, depth, normal, foot, path, inside, old, switched, rate, velocity)

    def from_point(self, first: int) -> ContactRows:
        """Return the rows from the point `first` on, which carry forces."""
        k = int(np.searchsorted(self.rows, first))
        return ContactRows._make(values[k:] for values in self)


class LastDepths(NamedTuple):
    """Feet, positions and depths of points at the last step."""

    patch: IntArray
    """(n,) patch of their feet, −1 without contact."""
    feature: ByteArray
    """(n,) of their feet."""
    points: FloatArray
    """(n, 3)."""
    rows: IndexArray
    """(k,) the points in contact, ascending."""
    depth: FloatArray
    """(k,) their penetrations."""


def contact_rows(detected: Detection, p_B: FloatArray, past: PreviousStep | None) -> ContactRows:
    """Return the points in contact with depths, normals, feet, paths and rates; see the record.

    `p_B` (n, 3) are all points; `past` is None at the start, where paths and rates are zero.
    """
    rows, gather = detected.touching, straight(carrying_nb.gather)
    if past is None:
        points = ContactRows.of(rows)
        n = len(p_B)
        nowhere = np.full(n, -1, np.int32), np.full(n, -1, np.int8)
        last = LastDepths(*nowhere, p_B, NO_ROWS, NONE)
        gather(detected.feet, p_B, last, 1.0, points)
        points.rate.fill(0.0)
        return points
    state, last_points = past.state, past.state.points_B
    velocity = NO_POINTS if past.velocity is None else past.velocity.at(rows)
    if past.shape is not None:  # paths and velocities are relative to the surface at the foot
        feet, points_B = SurfacePlaces(detected.feet.patch[rows], detected.uv[rows]), p_B[rows]
        last_points = last_points.copy()
        last_points[rows] += past.shape.carried(feet, points_B)
        if past.velocity is not None:
            velocity = velocity - past.shape.velocities(feet, points_B)
    last = LastDepths(state.patch, state.feature, last_points, *state.kept.penetration)
    points = ContactRows.of(rows, velocity)
    gather(detected.feet, p_B, last, past.dt or np.inf, points)
    return points


class FrictionInputs(NamedTuple):
    """Input of friction, for single points and for all points as one."""

    points: FrictionInput
    common: FrictionInput | None = None
    """Input of one point for all, if the law gives a common force."""
    path_weights: FloatArray = NONE
    """(k,) weights of the paths of points in the common path."""
    present: float = 1.0
    """Part of these weights that is the present share of the normal force."""


class Responses(NamedTuple):
    """Output of law and friction for the points that carry forces."""

    normal: LawOutput
    friction: FrictionOutput | None
    inputs: FrictionInputs | None
    """Input of friction."""


def respond(
    law: Law,
    friction: Friction | None,
    points: ContactRows,
    inp: LawInput,
    past: PreviousStep | None,
) -> Responses:
    """Return the output of law and friction for `points`, and the input of friction.

    Those of friction are None without one. Velocities that are not given are paths over the step,
    zero at the start, where `past` is None. If the law acts as one force, friction acts on all
    points as one. Raises `InputError` for a law's output of another shape.
    """
    output = checked_output(law, inp)
    if friction is None:
        return Responses(output, None, None)
    rows, normal = points.rows, points.normal
    if past is None:
        normal_before, memory = np.zeros_like(normal), np.zeros((len(rows), friction.n_memory))
        velocity = np.zeros_like(normal)
    else:
        kept = past.state.kept
        normal_before, velocity = kept.normal_B.at(rows), points.velocity
        memory = np.zeros((len(rows), friction.n_memory))
        if kept.friction_memory is not None:
            memory = kept.friction_memory.at(rows)
        if past.velocity is None:
            velocity = points.path / (past.dt or np.inf)
    # Stiffness of the normal force over the penetration; the secant on a plateau of its curve.
    elastic = output.force if output.damping is None else output.force - output.damping
    secant = np.zeros(len(rows))
    np.divide(elastic, points.depth, out=secant, where=points.depth > 0.0)
    stiffness = np.where(output.stiffness > 0.0, output.stiffness, np.maximum(secant, 0.0))
    area = inp.area
    if type(friction) not in TRUSTED_FRICTION:  # it must not write to arrays of the contact
        normal, area = locked(normal), locked(area)
    inputs = FrictionInput(
        normal=normal,
        normal_before=normal_before,
        force=output.force,
        stiffness=stiffness,
        area=area,
        path=points.path * points.inside[:, None],
        velocity=velocity,
        dt=inp.dt,
        memory=memory,
    )
    if getattr(law, "acts_as_one", False) and len(rows):
        friction_output, friction_inputs = _common_friction(friction, points, inputs, past)
    else:
        friction_output, friction_inputs = friction.respond(inputs), FrictionInputs(inputs)
    force = np.empty(normal.shape)
    force[...] = friction_output.force
    return Responses(output, friction_output._replace(force=force), friction_inputs)


def checked_output(law: Law, inp: LawInput) -> LawOutput:
    """Return the output of a law, checked: one row per point in contact.

    Without points the law is not evaluated. The arrays are copied, as the law may reuse them, and a
    tangent is dropped; output of `TRUSTED_LAWS` is returned unchecked.

    Raises
    ------
    InputError
        The output is no `LawOutput`, or has another shape, which would be broadcast silently.
    """
    n = len(inp.penetration)
    if n == 0:
        return LawOutput(np.zeros(0), np.zeros(0), np.zeros(0), np.zeros((0, law.n_memory)))
    if type(law) in TRUSTED_LAWS:
        return law.respond(inp)
    output: object = law.respond(inp)
    if not isinstance(output, LawOutput):
        raise InputError(
            "the law must answer a LawOutput",
            where="law",
            found=type(output).__name__,
            allowed="LawOutput(force, stiffness, stored, memory)",
        )
    checked: list[FloatArray | None] = []
    for name, values in zip(LawOutput._fields, output._replace(tangent=None), strict=True):
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


def _common_friction(
    friction: Friction, points: ContactRows, inp: FrictionInput, past: PreviousStep | None
) -> tuple[FrictionOutput, FrictionInputs]:
    """Return friction of all points as one, shared as the normal forces are, and its inputs.

    `inp` is the input of single points. In the output, energies and stiffness are shared as well,
    and each point has the common memory, which old points must have in `inp` already. See the
    module's head for the mean path.
    """
    shares = _shares(inp.force)
    before, memory = np.zeros((1, 3)), np.zeros((1, friction.n_memory))
    path_weights, present = shares, 1.0
    if past is not None and points.old.any():
        last = past.state.kept
        rows, force = last.normal_force
        before = _unit(product(_shares(force), last.normal_B.at(rows)))
        memory[0] = inp.memory[np.argmax(points.old)]  # the same for all old points
        last_force = last.normal_force.at(points.rows)
        if last_force.any():  # else all of these have left
            path_weights, present = _shares(shares + _shares(last_force)), 0.5
    common_input = FrictionInput(
        normal=_unit(product(shares, inp.normal)),
        normal_before=before,
        force=inp.force.sum(keepdims=True),
        stiffness=inp.stiffness.sum(keepdims=True),
        area=inp.area.sum(keepdims=True),
        path=product(path_weights, inp.path)[None],
        velocity=product(shares, inp.velocity)[None],
        dt=inp.dt,
        memory=memory,
    )
    common, column = friction.respond(common_input), shares[:, None]
    of_points = FrictionOutput(
        column * common.force,
        shares * common.stiffness,
        shares * common.stored,
        shares * common.lost,
        np.repeat(common.memory, len(shares), axis=0),
    )
    return of_points, FrictionInputs(inp, common_input, path_weights, present)


def _shares(force: FloatArray) -> FloatArray:
    """Return the shares (k,) of a sum; equal shares if it is zero."""
    total = force.sum()
    return force / total if total > 0.0 else np.full(len(force), 1.0 / max(len(force), 1))


def _unit(vector: FloatArray) -> FloatArray:
    """Return a unit vector (1, 3); zero stays zero."""
    size = length(vector)
    return (vector / size if size > 0.0 else vector)[None]


class LawForces(NamedTuple):
    """Output of law and friction for k points; optional arrays are empty without."""

    force: FloatArray
    """(k,) along the normals."""
    stored: FloatArray
    """(k,) energies that the law stores."""
    hysteresis: FloatArray
    """(k,) losses of the step."""
    damping: FloatArray
    """(k,) the part of `force` that is due to the rate."""
    friction: FloatArray
    """(k, 3) forces across the normals."""
    spring_energy: FloatArray
    """(k,) energies stored in friction's springs."""
    lost: FloatArray
    """(k,) energies lost by friction."""


class LastForces(NamedTuple):
    """The forces and feet of the last step."""

    force: Column
    """Normal forces."""
    normal: Column
    """Unit normals (…, 3), body axes, of all points that were in contact."""
    traction: Column
    """Friction forces (…, 3), body axes."""
    damping: Column
    """Parts of the normal forces due to the rate."""
    energies: FloatArray
    """(5,) energies, as in `ContactEnergy`."""
    points: FloatArray
    """(n, 3) all `PreviousStep.points`."""
    none: Column
    """Forces of no points."""


class Frame(NamedTuple):
    """The pose and reference point of the body."""

    pose: FloatArray
    """(4, 4) X_WB."""
    reference_point: FloatArray
    """(3,) reference point of moments, body axes."""


class PointForces(NamedTuple):
    """Forces on k points, and their sums."""

    force: FloatArray
    """(k, 3) forces, world axes."""
    viscosity: FloatArray
    """(k,) damping over the rate of penetration."""
    totals: FloatArray
    """Wrench on the body, and energies after the step; see `totals_nb`."""


def forces(
    points: ContactRows,
    response: Responses,
    p_B: FloatArray,
    past: PreviousStep | None,
    frame: Frame,
) -> tuple[PointForces, bool]:
    """Return world forces and totals of the points, and whether any damping force is not zero.

    `p_B` (m, 3) are all points. At the start, without a `past`, the work is the stored energy, and
    nothing is lost.
    """
    (force, _, stored, _, hysteresis, damping, *_), friction_output, _ = response
    k = len(points.rows)
    out = PointForces(np.empty((k, 3)), np.empty(k), np.empty(totals_nb.TOTALS))
    friction_arrays = NO_POINTS, NONE, NONE
    if friction_output is not None:  # energies are only summed: they may have any shape
        stored_by_friction, lost_by_friction = (
            np.array(friction_output.stored, np.float64),
            np.array(friction_output.lost, np.float64),
        )
        friction_arrays = (
            friction_output.force,
            stored_by_friction.reshape(-1),
            lost_by_friction.reshape(-1),
        )
    answer = LawForces(
        force,
        stored,
        NONE if hysteresis is None else hysteresis,
        NONE if damping is None else damping,
        *friction_arrays,
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
    is_damped = straight(totals_nb.forces)(points, answer, last, p_B, frame, out)
    if past is None:
        all_stored = out.totals[totals_nb.STORED]
        out.totals[totals_nb.WORK :] = all_stored, all_stored, 0.0, 0.0, 0.0
    return out, is_damped


def kept_columns(
    touching: ContactRows, rows: IntArray, response: Responses, out: PointForces, is_damped: bool
) -> KeptColumns:
    """Return the columns of a state for the points in contact; forces are those on `rows`.

    Guards are empty; columns are None without friction, damping or a bound of the stiffness.
    """
    normal, friction, _ = response
    bound, damping = normal.stiffness_bound, normal.damping if is_damped else None
    # Friction's memory and stiffness are copied, as it may reuse its arrays.
    return KeptColumns(
        penetration=Column(touching.rows, touching.depth),
        normal_B=Column(touching.rows, touching.normal),
        foot_B=Column(touching.rows, touching.foot),
        guard_B=UNGUARDED,
        normal_force=Column(rows, normal.force),
        stiffness=Column(rows, normal.stiffness),
        memory=Column(rows, normal.memory),
        force=Column(rows, out.force),
        stiffness_bound=None if bound is None else Column(rows, bound),
        damping=None if damping is None else Column(rows, damping),
        viscosity=None if damping is None else Column(rows, out.viscosity),
        friction_memory=None
        if friction is None
        else Column(rows, np.array(friction.memory, np.float64)),
        traction_B=None if friction is None else Column(rows, friction.force),
        tangential=None
        if friction is None
        else Column(rows, np.array(friction.stiffness, np.float64)),
    )
