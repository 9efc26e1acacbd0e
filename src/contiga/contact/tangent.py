"""Compute the derivatives of the forces of a step for Newton's method in an implicit code.

The forces are a function of the positions of slave and master at the end of the step; the state
before it is constant, with the memory of laws and friction. The derivative of the force on a point
with the normal n and the force F(λ, λ̇) is n dFᵀ + F H, with H = dn/dp of the foot
(`contiga.search.slopes`), so that a spring has K = −k (n nᵀ + g H). Rates are changes over the
step: dλ̇ = dλ/Δt. A force shared by several points couples them by Σ_j L_i R_jᵀ beside the blocks.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from contiga.arrays.layout import as_numbers
from contiga.arrays.ordered import product, row_lengths, row_products
from contiga.arrays.threads import run_ranges
from contiga.contact.control_tangent import control_slopes, no_slopes
from contiga.contact.foot_motion import VARIABLES, Feet, FootMotion, foot_motion, input_change
from contiga.contact.friction_tangent import CarryingPoints, InputChange, Terms, friction_terms
from contiga.contact.kernels import tangent_nb
from contiga.contact.loads import Column
from contiga.contact.respond import ContactRows, FrictionInputs
from contiga.contact.shape import Shape
from contiga.contact.state import State
from contiga.errors import InputError
from contiga.geometry.net import dependence_of
from contiga.laws.friction import Friction
from contiga.laws.law import Law
from contiga.masters.protocol import Surface
from contiga.records import (
    DepthSlopes,
    FloatArray,
    FootSlopes,
    IntArray,
    LawInput,
    LawOutput,
    LawTangent,
    Projection,
    SurfacePlaces,
)
from contiga.rigid.frames import to_world, turn_to_world
from contiga.slaves.sampling import Sampling

if TYPE_CHECKING:
    from scipy.sparse import csr_array

# Number of points per thread from which threads pay.
POINTS_PER_THREAD = 2048
# Largest number of entries of a matrix that scipy can index.
MAX_NUMBERS = 2**31 - 1
# A foot has jumped if it moved by more than this factor times the bound by its derivative.
JUMP_FACTOR = 2.0


class StepInputs(NamedTuple):
    """Inputs of law and friction in the step that made a state."""

    points: ContactRows
    """Points that carry forces."""
    law: LawInput
    friction: FrictionInputs | None
    foot_before: Column
    """Feet before the step, body axes; none at the start."""
    twist: FloatArray | None
    """(2, 3) velocity of the body's origin and its spin, world axes, if velocities were given: they
    are then constant."""
    control_before: FloatArray | None
    """(m, 3) control points of the master before the step; None for a constant shape, as the next
    field."""
    control_velocity: FloatArray | None
    """(m, 3) velocities of the control points, if given."""


class ContactSetup(NamedTuple):
    """The parts of a contact that its derivatives need."""

    surface: Surface
    shape: Shape | None
    """Change of the master's shape in the step; None for a constant shape."""
    law: Law
    friction: Friction | None
    sampling: Sampling
    half: FloatArray | None
    """(m,) half the thickness of shells at all points."""
    reference_point: FloatArray
    """(3,) body axes."""


class Linearisation(NamedTuple):
    """Derivatives of the forces of a step on a slave's n points, and of the wrench on the master.

    All derivatives are in world axes; rows and columns are x, y, z of point after point. A small
    motion of the master has six components: the displacement of its frame's origin, and the
    rotation about it, in radians.

    A ball that moves up reduces the force on a point below, which points down, by 100 per length:

    >>> import contiga as cg
    >>> ball = cg.Body([cg.shapes.sphere(radius=1.0)])
    >>> pad = cg.Slave([[0.0, 0.0, -1.1]], area=[0.5])
    >>> contact = cg.Contact(ball, pad, law=cg.PenaltyLaw(100.0))
    >>> state = contact.step(contact.start(pad.points), pad.points + [0.0, 0.0, 0.2])
    >>> whole = contact.linearise(state)
    >>> round(float(whole.force_by_pose[2, 2]), 9), whole.wrench_by_pose.shape
    (100.0, (6, 6))
    """

    force_by_points: csr_array
    """(3 n, 3 n)."""
    force_by_pose: FloatArray
    """(3 n, 6)."""
    wrench_by_points: FloatArray
    """(6, 3 n)."""
    wrench_by_pose: FloatArray
    """(6, 6)."""
    force_by_velocity: csr_array
    """(3 n, 3 n) with respect to velocities given to the step; without entries if none are given,
    as rates then follow from the points."""
    force_by_control: csr_array
    """(3 n, 3 m) with respect to the master's m control points, body axes; m = 0 if none are given.
    Velocities of control points, if given, are constant."""
    control_by_points: csr_array
    """(3 m, 3 n) derivatives of `State.control_force` with respect to the slave's points."""
    control_by_control: csr_array
    """(3 m, 3 m) derivatives of `State.control_force` with respect to control points, body axes."""


class _NormalTangent(NamedTuple):
    """Forces of k points and their slopes for the kernel."""

    force: FloatArray
    """(k,)."""
    slope: FloatArray
    """(k,) ∂F/∂λ."""
    rate: FloatArray
    """(k,) ∂F/∂λ̇."""
    dt: float
    """Length of the step; infinite in statics, without rates."""
    force_change: FloatArray
    """(k, m) derivatives of each force with respect to its own point's variables, filled in."""


class _DeformedFeet(NamedTuple):
    """Points in contact with a master that deforms."""

    feet: Feet
    motion: FootMotion


class _Tangents(NamedTuple):
    """Derivatives of the forces on the points that carry, body axes."""

    terms: Terms
    """Derivatives with respect to the variables of points: their positions and, on a master that
    deforms, the variables of the surface below. Given velocities are constant in world axes."""
    velocities: Terms
    """Derivatives with respect to given velocities; zero if none are given."""
    deformed: _DeformedFeet | None
    """None for a master of constant shape."""


def tangent_of(contact: ContactSetup, state: State, inputs: StepInputs) -> csr_array:
    """Return ∂F/∂x of the nodes of a slave (3 n, 3 n), world axes; raises as `_tangents` does."""
    places = _in_world(_tangents(contact, state, inputs, 3).terms, state.pose)
    return _matrix_of(inputs.points.rows, places, contact.sampling)


def linearisation_of(contact: ContactSetup, state: State, inputs: StepInputs) -> Linearisation:
    """Return all derivatives of the forces of a step; raises as `_tangents` does."""
    rows, sampling, pose = inputs.points.rows, contact.sampling, state.pose
    terms, velocities, deformed = _tangents(contact, state, inputs, VARIABLES)
    force = inputs.points.normal * state.normal_force[rows, None]
    if len(state.traction_B):
        force = force + state.traction_B[rows]
    n = sampling.n_nodes
    control = no_slopes(n)
    if deformed is not None:
        weights, m = sampling.shares(rows), len(state.control_points)
        control = control_slopes(*deformed, force, terms, weights, pose[:3, :3], m)
    places, velocities = (_in_world(each, pose) for each in (terms.over(slice(0, 3)), velocities))
    force_W, p_W = turn_to_world(pose, force), to_world(pose, state.points_B[rows])
    at_W, reference = p_W - pose[:3, 3], product(pose[:3, :3], contact.reference_point)
    force_x, at_x, arm_x = (_cross_matrices(v) for v in (force_W, at_W, at_W - reference))
    # Relative to a body that rotates by θ the slave rotates by −θ; forces rotate with the body.
    by_pose = np.empty((len(rows), 3, 6))
    by_pose[:, :, :3] = -places.applied(np.broadcast_to(np.eye(3), at_x.shape))
    by_pose[:, :, 3:] = places.applied(at_x) - force_x
    if inputs.twist is not None:
        velocity = inputs.points.velocity
        if contact.shape is not None:
            places_on = SurfacePlaces(state.patch[rows], state.uv[rows])
            velocity = velocity + contact.shape.velocities(places_on, state.points_B[rows])
        turned = _cross_matrices(turn_to_world(pose, velocity))
        turned += np.einsum(
            "ab,kbc->kac", _cross_matrices(inputs.twist[1:])[0], at_x, optimize=False
        )
        by_pose[:, :, 3:] += velocities.applied(turned)
    by_points = np.concatenate([-places.summed(), force_x - places.summed(arm_x)], axis=1)
    whole, lever = _cross_matrices(np.stack([force_W.sum(axis=0), reference]))
    wrench_by_pose = np.empty((6, 6))
    wrench_by_pose[:3] = -by_pose.sum(axis=0)
    wrench_by_pose[3:] = -np.einsum("kab,kbq->aq", arm_x, by_pose, optimize=False)
    wrench_by_pose[3:] += product(whole, np.concatenate([-np.eye(3), lever], axis=1))
    nodal = np.stack([sampling.nodal(rows, by_pose[:, :, q]) for q in range(6)], axis=2)
    by_nodes = np.stack([sampling.nodal(rows, by_points[:, q]) for q in range(6)])
    velocity_rows = rows if inputs.twist is not None else rows[:0]
    return Linearisation(
        _matrix_of(rows, places, sampling),
        nodal.reshape(3 * n, 6),
        by_nodes.reshape(6, 3 * n),
        wrench_by_pose,
        _matrix_of(velocity_rows, velocities, sampling),
        *control,
    )


def kinks_of(contact: ContactSetup, state: State, inputs: StepInputs) -> IntArray:
    """Return points (k,), ascending, in contact before and now whose derivative may be invalid.

    Another patch or feature of the master pushes them, or the foot has moved farther than
    `JUMP_FACTOR` times the path and the norm of its derivative.
    """
    points = inputs.points
    normal, moved = points.normal, points.foot - inputs.foot_before.at(points.rows)
    slopes = _foot_slopes(contact, state, points)
    stretch = np.eye(3) - normal[:, :, None] * normal[:, None, :]
    stretch += points.depth[:, None, None] * slopes.normal
    allowed = JUMP_FACTOR * np.sqrt(np.square(stretch).sum(axis=(1, 2))) * row_lengths(points.path)
    kinked: IntArray = points.rows[points.old & (points.switched | (row_lengths(moved) > allowed))]
    return kinked


def _tangents(contact: ContactSetup, state: State, inputs: StepInputs, m: int) -> _Tangents:
    """Return the derivatives of the forces with respect to the positions of points.

    On a master that deforms they are with respect to the first m variables of each point.

    Raises
    ------
    InputError
        Law or friction has no derivatives, or not one row a point.
    """
    points, friction, friction_inputs = inputs.points, contact.friction, inputs.friction
    k, dt = len(points.rows), inputs.law.dt or np.inf
    output, tangent = _checked_law_tangent(contact.law, inputs.law)
    rate = np.zeros(k) if tangent.rate is None else tangent.rate
    force = state.kept.normal_force.at(points.rows)

    def terms_over(change: InputChange) -> Terms:
        """Return the derivatives of all forces, friction included, by the chain rule."""
        normal = _NormalTangent(force, tangent.force.own, rate, dt, np.empty(change.depth.shape))
        blocks = np.empty(change.normal.shape)
        run_ranges(tangent_nb.normal_blocks, k, POINTS_PER_THREAD, points, change, normal, blocks)
        terms = Terms.of(blocks)
        carrying = CarryingPoints(points, output, tangent, change, normal.force_change, dt)
        if tangent.force.left is not None:
            left = points.normal[:, :, None] * tangent.force.left[:, None, :]
            terms = Terms(blocks, left, carrying.right_sides(tangent.force))
        if friction is not None and friction_inputs is not None and k:
            terms = terms.plus(friction_terms(friction, friction_inputs, carrying))
        return terms

    slopes, identity = _foot_slopes(contact, state, points), np.eye(3)[None]
    deformed, velocities = None, Terms.of(np.zeros((k, 3, 3)))
    change = InputChange(slopes.depth, slopes.normal, identity, np.zeros((0, 3, 3)))
    # The motion of the surface matters only for friction and for rates.
    if contact.shape is not None and (m == VARIABLES or friction is not None or rate.any()):
        rows, shape = points.rows, contact.shape
        net = dependence_of(shape.body, shape.now, SurfacePlaces(state.patch[rows], state.uv[rows]))
        gap = _gaps(state, points)
        if contact.half is not None:
            gap = gap + contact.half[rows]
        hessian = net.jet(shape.now).hessian
        curvature = np.einsum("ka,kabc->kbc", net.normal, hessian, optimize=False)
        feet = Feet(points.normal, gap, slopes, net, curvature)
        deformed = _DeformedFeet(feet, foot_motion(feet, m))
        change = input_change(*deformed, contact.shape)
    if inputs.twist is not None:
        # A displacement dx changes the velocity relative to a body with the spin ω by −ω × dx.
        turning = np.zeros((1, 3, change.depth.shape[1]))
        turning[0, :, :3] = -_cross_matrices(product(inputs.twist[1:], state.pose[:3, :3]))[0]
        if deformed is not None:
            turning = turning + change.velocity
        change = change._replace(velocity=turning)
        velocities = terms_over(
            InputChange(np.zeros((k, 3)), np.zeros((k, 3, 3)), 0.0 * identity, identity)
        )
    return _Tangents(terms_over(change), velocities, deformed)


def _in_world(terms: Terms, pose: FloatArray) -> Terms:
    """Return the terms in world axes; blocks are rotated in place."""
    turn = pose[:3, :3]
    run_ranges(tangent_nb.to_world, len(terms.blocks), POINTS_PER_THREAD, terms.blocks, pose)
    left, right = (
        np.einsum("ab,kbr->kar", turn, side, optimize=False) for side in (terms.left, terms.right)
    )
    return Terms(terms.blocks, left, right)


def _cross_matrices(v: FloatArray) -> FloatArray:
    """Return the matrices (k, 3, 3) of v × …, of v (k, 3)."""
    out = np.zeros((len(v), 3, 3))
    for a, b, c in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        out[:, b, a], out[:, a, b] = v[:, c], -v[:, c]
    return out


def _matrix_of(rows: IntArray, terms: Terms, sampling: Sampling) -> csr_array:
    """Return the matrix (3 n, 3 n) over the n nodes of a slave from terms at points `rows`.

    Raises
    ------
    InputError
        Too many points share a force: the matrix is full between them.
    """
    from scipy.sparse import csr_array

    matrix = sampling.matrix(rows, terms.blocks[: len(rows)])
    if terms.left.shape[2] == 0 or len(rows) == 0:
        return matrix
    n_acting, n_affected = (int(side.any(axis=(1, 2)).sum()) for side in (terms.left, terms.right))
    if 9 * n_acting * n_affected > MAX_NUMBERS:
        raise InputError(
            "the derivatives are full between points that share a force",
            where="law",
            found=f"{n_affected} points, {9 * n_acting * n_affected:.2g} numbers",
            allowed=f"up to {MAX_NUMBERS:.2g}",
            remedy='Take ForceLaw with share = "deepest", which few points share, or a StressLaw',
        )
    left, right = (
        csr_array(
            np.column_stack(
                [sampling.nodal(rows, side[:, :, r]).ravel() for r in range(side.shape[2])]
            )
        )
        for side in (terms.left, terms.right)
    )
    return csr_array(matrix + left @ right.T)


def _gaps(state: State, points: ContactRows) -> FloatArray:
    """Return the signed distances (k,) from the surface of contact, negative inside.

    A point of depth zero has its height above the tangent plane at its foot.
    """
    if points.depth.all():
        return -points.depth
    beside = row_products(state.points_B[points.rows] - points.foot, points.normal)
    return np.where(points.depth > 0.0, -points.depth, beside)


def _foot_slopes(contact: ContactSetup, state: State, points: ContactRows) -> FootSlopes:
    """Return the derivatives of depths and normals; for shells at feet on the body itself.

    The depth of a point in front of the surface does not change.
    """
    rows = points.rows
    k = len(rows)
    p_B, foot, normal, gap = state.points_B[rows], points.foot, points.normal, _gaps(state, points)
    in_front = gap > 0.0
    if contact.half is not None:
        off = contact.half[rows]
        foot, gap = foot - off[:, None] * normal, gap + off
    feet = Projection(
        state.patch[rows],
        state.uv[rows],
        foot,
        normal,
        gap,
        state.feature[rows],
        np.zeros(k, np.int8),
        np.zeros(k, np.int8),
    )
    slopes = FootSlopes(np.empty((k, 3)), np.empty((k, 3, 3)))
    if k:
        contact.surface.slopes(p_B, feet, slopes)
    slopes.depth[in_front] = 0.0
    return slopes


def _checked_law_tangent(law: Law, inp: LawInput) -> tuple[LawOutput, LawTangent]:
    """Return the output of a law, and its derivatives, checked.

    Without points the law is not evaluated.

    Raises
    ------
    InputError
        There are no derivatives, or not one row per point.
    """
    n = len(inp.penetration)
    if n == 0:
        none = np.zeros(0)
        return LawOutput(none, none, none, np.zeros((0, 0))), LawTangent(DepthSlopes(none))
    output = law.respond(inp._replace(wants_tangent=True))
    tangent = output.tangent
    if tangent is None:
        raise InputError(
            "the law has no tangent",
            where="law",
            found=type(law).__name__,
            allowed="a law whose LawOutput has one where LawInput.wants_tangent is true",
            remedy="Answer LawOutput(…, tangent=slopes), (n,) of each force over its penetration, "
            "or a LawTangent where forces depend on rates or on other points",
        )
    if not isinstance(tangent, LawTangent):
        tangent = LawTangent(DepthSlopes(tangent))
    return output, LawTangent(
        _checked_slopes(tangent.force, n, "force"),
        None if tangent.rate is None else _checked(tangent.rate, (n,), "rate"),
        None if tangent.stiffness is None else _checked_slopes(tangent.stiffness, n, "stiffness"),
    )


def _checked_slopes(values: Any, n: int, name: str) -> DepthSlopes:
    """Return checked slopes of n points; a plain array has slopes over each point's penetration.

    Raises `InputError` for other shapes, and for one side of a coupling without the other.
    """
    slopes = values if isinstance(values, DepthSlopes) else DepthSlopes(values)
    own = _checked(slopes.own, (n,), f"{name}.own")
    left_given: Any = slopes.left
    if left_given is None and slopes.right is None:
        return DepthSlopes(own)
    r = np.shape(left_given)[1] if np.ndim(left_given) == 2 else 1
    left, right = (
        _checked(side, (n, r), f"{name}.{at}")
        for at, side in (("left", left_given), ("right", slopes.right))
    )
    return DepthSlopes(own, left, right)


def _checked(values: object, shape: tuple[int, ...], name: str) -> FloatArray:
    """Return values of the tangent of a law as an array; raise `InputError` for another shape."""
    where = f"law: tangent.{name}"
    numbers = as_numbers(values, where, "the law must answer numbers")
    if numbers.shape != shape:
        raise InputError(
            "the law must answer one row a point in contact",
            where=where,
            found=numbers.shape,
            allowed=str(shape),
        )
    return numbers
