"""Derivatives of the forces of a step: what Newton's method in an implicit code asks for.

A step is a function of where the slave's points and the master are at its end; the state before it
stays as it is, with all that laws and friction remember. Of a point with the normal n and the force
F(λ, λ̇) the derivative is n dFᵀ + F H, with H = dn/dp of the foot (`contiga.search.slopes`), and so
K = −k (n nᵀ + g H) of a spring. Rates are changes over the step: dλ̇ = dλ/Δt. What is common to
several points, as one force that they share, couples them: Σ_j L_i R_jᵀ beside the blocks.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from contiga.arrays.layout import as_numbers
from contiga.arrays.ordered import product, row_lengths, row_products
from contiga.arrays.threads import run_ranges
from contiga.contact.control_tangent import control_slopes, no_slopes
from contiga.contact.foot_motion import VARIABLES, Feet, FootMotion, foot_motion, input_change
from contiga.contact.friction_tangent import Carried, InputChange, Terms, friction_terms
from contiga.contact.kernels import tangent_nb
from contiga.contact.loads import Column
from contiga.contact.respond import ContactRows, Seen
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

# Points below which a second thread does not pay.
POINTS = 2048
# Of a matrix that is full between points: what scipy's indices reach.
MOST_NUMBERS = 2**31 - 1
# Factor on the movement that its derivative allows, beyond which a foot has jumped.
JUMP = 2.0


class StepInputs(NamedTuple):
    """Inputs that laws were handed in the step that has made a state."""

    points: ContactRows
    """Points that carry forces."""
    law: LawInput
    friction: Seen | None
    foot_before: Column
    """Feet at the state before, body axes; none at the start."""
    twist: FloatArray | None
    """(2, 3) velocity of the body's origin and its spin, world axes, where velocities were given:
    then they stay as they are."""
    control_before: FloatArray | None
    """(m, 3) control points of the master before the step; None, with the next, of one that keeps
    its shape."""
    control_velocity: FloatArray | None
    """(m, 3) of them where velocities were given."""


class Asked(NamedTuple):
    """A contact that is asked for the derivatives of its forces."""

    surface: Surface
    shape: Shape | None
    """Change of the master's shape in the step, if its control points were given."""
    law: Law
    friction: Friction | None
    sampling: Sampling
    half: FloatArray | None
    """(m,) half the thickness of shells at all points."""
    reference_point: FloatArray
    """(3,) body axes."""


class Linearisation(NamedTuple):
    """Derivatives of the forces of a step on a slave's n points, and of the wrench on the master.

    In world axes; rows and columns of points are x, y, z of point after point. A small motion of
    the master is six numbers: how its frame's origin goes, and the angle by which it turns about
    that, in radians.

    A ball that goes up takes 100 a length off the force on a point below, which points down:

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
    """(3 n, 3 n) over velocities that a step was given; without entries where it was given none, as
    rates then follow from the points."""
    force_by_control: csr_array
    """(3 n, 3 m) over the master's m control points, body axes; m = 0 if the step was given none.
    Velocities of control points that the step was given stay as they are."""
    control_by_points: csr_array
    """(3 m, 3 n) derivatives of `State.control_force` over the slave's points."""
    control_by_control: csr_array
    """(3 m, 3 m) derivatives of `State.control_force` over the control points, body axes."""


class _NormalTangent(NamedTuple):
    """The forces of k points and their slopes, as the kernel reads them."""

    force: FloatArray
    """(k,)."""
    own: FloatArray
    """(k,) ∂F/∂λ."""
    rate: FloatArray
    """(k,) ∂F/∂λ̇."""
    dt: float
    """Length of the step; infinite where it has none, and no rates."""
    grown: FloatArray
    """(k, m) the derivatives of each force over the variables of its own point, filled in."""


class _Deformed(NamedTuple):
    """Points in contact with a master that deforms."""

    feet: Feet
    motion: FootMotion


class _Tangents(NamedTuple):
    """Derivatives of the forces on the points that carry, body axes."""

    terms: Terms
    """Over the variables of points: their places and, on a master that deforms, those of the
    surface below, where asked for; velocities that were given stay, world axes."""
    velocities: Terms
    """Over velocities that were given; zero without."""
    deformed: _Deformed | None
    """None of a master that keeps its shape."""


def tangent_of(asked: Asked, state: State, inputs: StepInputs) -> csr_array:
    """Return ∂F/∂x of the nodes of a slave (3 n, 3 n)."""
    places = _in_world(_tangents(asked, state, inputs, 3).terms, state.pose)
    return _matrix_of(inputs.points.rows, places, asked.sampling)


def linearisation_of(asked: Asked, state: State, inputs: StepInputs) -> Linearisation:
    """Return all derivatives of the forces of a step."""
    rows, sampling, pose = inputs.points.rows, asked.sampling, state.pose
    terms, velocities, deformed = _tangents(asked, state, inputs, VARIABLES)
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
    at_W, reference = p_W - pose[:3, 3], product(pose[:3, :3], asked.reference_point)
    force_x, at_x, arm_x = (_cross_matrices(v) for v in (force_W, at_W, at_W - reference))
    # Seen from a body that turns by θ the slave turns the other way; forces turn along with it.
    by_pose = np.empty((len(rows), 3, 6))
    by_pose[:, :, :3] = -places.applied(np.broadcast_to(np.eye(3), at_x.shape))
    by_pose[:, :, 3:] = places.applied(at_x) - force_x
    if inputs.twist is not None:
        moving = inputs.points.velocity
        if asked.shape is not None:
            places_on = SurfacePlaces(state.patch[rows], state.uv[rows])
            moving = moving + asked.shape.velocities(places_on, state.points_B[rows])
        turned = _cross_matrices(turn_to_world(pose, moving))
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
    across = np.stack([sampling.nodal(rows, by_points[:, q]) for q in range(6)])
    told = rows if inputs.twist is not None else rows[:0]
    return Linearisation(
        _matrix_of(rows, places, sampling),
        nodal.reshape(3 * n, 6),
        across.reshape(6, 3 * n),
        wrench_by_pose,
        _matrix_of(told, velocities, sampling),
        *control,
    )


def kinks_of(asked: Asked, state: State, inputs: StepInputs) -> IntArray:
    """Return points in contact before and now whose derivative may not hold.

    Another piece of the master pushes them, or the foot has gone farther than its derivative says.
    """
    points = inputs.points
    normal, moved = points.normal, points.foot - inputs.foot_before.at(points.rows)
    slopes = _foot_slopes(asked, state, points)
    stretch = np.eye(3) - normal[:, :, None] * normal[:, None, :]
    stretch += points.depth[:, None, None] * slopes.normal
    allowed = JUMP * np.sqrt(np.square(stretch).sum(axis=(1, 2))) * row_lengths(points.path)
    kinked: IntArray = points.rows[points.old & (points.switched | (row_lengths(moved) > allowed))]
    return kinked


def _tangents(asked: Asked, state: State, inputs: StepInputs, m: int) -> _Tangents:
    """Return the derivatives of the forces on the points that carry, over their places.

    On a master that deforms they are over the first m of their variables.

    Raises
    ------
    InputError
        Law or friction has no derivatives, or not one row a point.
    """
    points, friction, seen = inputs.points, asked.friction, inputs.friction
    k, dt = len(points.rows), inputs.law.dt or np.inf
    output, tangent = _law_tangent(asked.law, inputs.law)
    rate = np.zeros(k) if tangent.rate is None else tangent.rate
    force = state.kept.normal_force.at(points.rows)

    def terms_over(change: InputChange) -> Terms:
        """Return the derivatives of the forces by the chain rule."""
        normal = _NormalTangent(force, tangent.force.own, rate, dt, np.empty(change.depth.shape))
        blocks = np.empty(change.normal.shape)
        run_ranges(tangent_nb.normal_blocks, k, POINTS, points, change, normal, blocks)
        terms = Terms.of(blocks)
        carried = Carried(points, output, tangent, change, normal.grown, dt)
        if tangent.force.left is not None:
            left = points.normal[:, :, None] * tangent.force.left[:, None, :]
            terms = Terms(blocks, left, carried.pulled(tangent.force))
        if friction is not None and seen is not None and k:
            terms = terms.plus(friction_terms(friction, seen, carried))
        return terms

    slopes, one = _foot_slopes(asked, state, points), np.eye(3)[None]
    deformed, velocities = None, Terms.of(np.zeros((k, 3, 3)))
    change = InputChange(slopes.depth, slopes.normal, one, np.zeros((0, 3, 3)))
    # How the surface carries points along matters to friction and to rates alone.
    if asked.shape is not None and (m == VARIABLES or friction is not None or rate.any()):
        feet = _feet_on(asked, asked.shape, state, points, slopes)
        deformed = _Deformed(feet, foot_motion(feet, m))
        change = input_change(*deformed, asked.shape)
    if inputs.twist is not None:
        # Points go by −ω × dx against a body that turns by the spin ω.
        turning = np.zeros((1, 3, change.depth.shape[1]))
        turning[0, :, :3] = -_cross_matrices(product(inputs.twist[1:], state.pose[:3, :3]))[0]
        if deformed is not None:
            turning = turning + change.velocity
        change = change._replace(velocity=turning)
        velocities = terms_over(InputChange(np.zeros((k, 3)), np.zeros((k, 3, 3)), 0.0 * one, one))
    return _Tangents(terms_over(change), velocities, deformed)


def _feet_on(
    asked: Asked, shape: Shape, state: State, points: ContactRows, slopes: FootSlopes
) -> Feet:
    """Return the feet of points on a master that deforms."""
    rows = points.rows
    net = dependence_of(shape.body, shape.now, SurfacePlaces(state.patch[rows], state.uv[rows]))
    gap = _gaps(state, points)
    if asked.half is not None:
        gap = gap + asked.half[rows]
    curvature = np.einsum("ka,kabc->kbc", net.normal, net.jet(shape.now).hessian, optimize=False)
    return Feet(points.normal, gap, slopes, net, curvature)


def _in_world(terms: Terms, pose: FloatArray) -> Terms:
    """Return the blocks in world axes; they are turned in place."""
    turn = pose[:3, :3]
    run_ranges(tangent_nb.to_world, len(terms.blocks), POINTS, terms.blocks, pose)
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
    """Return (3 n, 3 n) of the n nodes of a slave, three rows each, of points `rows`.

    Raises
    ------
    InputError
        So many points share a force that the matrix, full between them, cannot be held.
    """
    from scipy.sparse import csr_array

    matrix = sampling.matrix(rows, terms.blocks[: len(rows)])
    if terms.left.shape[2] == 0 or len(rows) == 0:
        return matrix
    acting, felt = (int(side.any(axis=(1, 2)).sum()) for side in (terms.left, terms.right))
    if 9 * acting * felt > MOST_NUMBERS:
        raise InputError(
            "the derivatives are full between points that share a force",
            where="law",
            found=f"{felt} points, {9 * acting * felt:.2g} numbers",
            allowed=f"up to {MOST_NUMBERS:.2g}",
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
    """Return (k,) signed distances to where contact begins."""
    if points.depth.all():
        return -points.depth
    beside = row_products(state.points_B[points.rows] - points.foot, points.normal)
    return np.where(points.depth > 0.0, -points.depth, beside)


def _foot_slopes(asked: Asked, state: State, points: ContactRows) -> FootSlopes:
    """Derivatives of depth and normal of the points; of shells at feet on the body itself."""
    rows = points.rows
    k = len(rows)
    p_B, foot, normal, gap = state.points_B[rows], points.foot, points.normal, _gaps(state, points)
    in_front = gap > 0.0
    if asked.half is not None:
        off = asked.half[rows]
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
        asked.surface.slopes(p_B, feet, slopes)
    slopes.depth[in_front] = 0.0
    return slopes


def _law_tangent(law: Law, inp: LawInput) -> tuple[LawOutput, LawTangent]:
    """Return a law's answer with its derivatives, checked.

    Raises
    ------
    InputError
        It answers none, or not one row a point.
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


def _checked_slopes(given: Any, n: int, name: str) -> DepthSlopes:
    """Slopes of n points; what is no `DepthSlopes` are those over a point's own penetration."""
    slopes = given if isinstance(given, DepthSlopes) else DepthSlopes(given)
    own = _checked(slopes.own, (n,), f"{name}.own")
    one: Any = slopes.left
    if one is None and slopes.right is None:
        return DepthSlopes(own)
    r = np.shape(one)[1] if np.ndim(one) == 2 else 1
    left, right = (
        _checked(side, (n, r), f"{name}.{at}")
        for at, side in (("left", one), ("right", slopes.right))
    )
    return DepthSlopes(own, left, right)


def _checked(values: object, shape: tuple[int, ...], name: str) -> FloatArray:
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
