"""Records passed between rooms. Their arrays have one row a point."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.display import Facts, counted, displayed
from contiga.pointer_records import pass_by_pointer
from contiga.statuses import Advised, Status

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int32]
ByteArray = NDArray[np.int8]
IndexArray = NDArray[np.integer[Any]]


class ContactStatus(Advised):
    """Contact status of a slave point after a step."""

    FREE = 0, "Not in contact."
    NEW = 1, "Came into contact in this step."
    OLD = 2, "In contact, and was already."
    RELEASED = (
        3,
        "Came back to the free side in this step, or left a closed body by another face.",
    )
    SLID_OFF = (
        4,
        "Its foot left the surface over a border or into a trimmed hole in this step; where it "
        'should stay, let the surface go on or take on_edge="hold".',
    )
    HELD = (
        5,
        'In contact at the closest point of a border, as on_edge="hold" asks; where the border is '
        "none of the real part, let the surface go on.",
    )
    LOST = 6, "Could not be solved and is left out of the forces; take smaller steps."
    NOT_FINITE = (
        7,
        "Has a NaN or infinite coordinate and is left out of the forces; look at the motion, or at "
        "the solver that moves it.",
    )
    FOUND = (
        8,
        "In contact at its closest point: it lies inside a closed body without a crossing having "
        "been seen, a fault of the search; please report the case.",
    )
    REACQUIRED = (
        9,
        "In contact at a foot found again, as the one it had vanished (its point crossed a focal "
        "surface, or it ran into the inner side of a fold) or did not continue; smaller steps show "
        "where.",
    )
    THROUGH = (
        10,
        'Tunnelled through the body and is pushed back to where it came from (through="hold"); '
        "take smaller steps or a stiffer law where it should not have come so far.",
    )


IN_CONTACT = (
    ContactStatus.NEW,
    ContactStatus.OLD,
    ContactStatus.HELD,
    ContactStatus.FOUND,
    ContactStatus.REACQUIRED,
    ContactStatus.THROUGH,
)
"""Statuses of points that a contact force may act on."""


@displayed
@pass_by_pointer
class Projection(NamedTuple):
    """Feet of n points on a body, in the frame the points came in.

    >>> import contiga as cg
    >>> feet = cg.Body([cg.shapes.sphere(radius=2.0)]).project([[5.0, 0.0, 0.0], [0.0, 1.5, 0.0]])
    >>> feet.gap.round(12).tolist(), [cg.Status(s).name for s in feet.status]
    ([3.0, -0.5], ['OK', 'OK'])
    """

    patch: IntArray
    """(n,) index of the patch, −1 without a foot."""
    uv: FloatArray
    """(n, 2) parameters on that patch."""
    point: FloatArray
    """(n, 3) the feet."""
    normal: FloatArray
    """(n, 3) unit normals at the feet, to the free side."""
    gap: FloatArray
    """(n,) signed distance along the normal, negative inside."""
    feature: ByteArray
    """(n,) `Feature`."""
    status: ByteArray
    """(n,) `Status`."""
    certified: ByteArray
    """(n,) 1 if the foot is proved, not merely converged: after a search over the whole body, that
    no other point is closer (up to tolerance); for a tracked foot, that it is on the branch of
    stationary points continued from its start along the straight motion of the point. Else 0."""

    def _facts(self) -> Facts:
        proved = int(np.count_nonzero(self.certified))
        return [("points", len(self.status)), *_statuses(self.status), ("certified", proved)]


class FootSlopes(NamedTuple):
    """Derivatives of depths and normals at feet with respect to the points, one row per point."""

    depth: FloatArray
    """(n, 3) of the depth, the negative signed distance."""
    normal: FloatArray
    """(n, 3, 3) of the unit normal, components by row."""


class SurfacePlaces(NamedTuple):
    """Places on a surface, one a row."""

    patch: IntArray
    """(n,) int32; −1 where there is none."""
    uv: FloatArray
    """(n, 2)."""


class Sides(NamedTuple):
    """Sides of points relative to a closed surface, where known."""

    side: ByteArray
    """(n,) 1 outside, −1 inside, 0 unknown."""
    reach: FloatArray
    """(n,) distance, length, within which there is no surface; for points with a known side."""

    def at(self, rows: IndexArray) -> Sides:
        """Return the sides at `rows` (k,)."""
        return Sides(self.side[rows], self.reach[rows])


class FacingLimits(NamedTuple):
    """Limits of a search for feet whose normals do not face away from a guard."""

    cosine: float
    """Lower bound of the cosine between normal and guard."""
    min_distance: FloatArray
    """(n,) lower bound of their distance, length."""
    max_distance: FloatArray
    """(n,) upper bound of their distance, length, infinite if unknown. A search ends there."""


@displayed
@pass_by_pointer
class Hit(NamedTuple):
    """First entry of n swept points into a body.

    >>> import contiga as cg
    >>> ball = cg.Body([cg.shapes.sphere(radius=1.0)])
    >>> starts = np.array([[0.0, 0.0, 3.0], [0.0, 2.0, 3.0]])
    >>> hit = ball.first_hit(starts, starts - [0.0, 0.0, 4.0])
    >>> hit.fraction.round(12).tolist(), [cg.Status(s).name for s in hit.status]
    ([0.5, nan], ['OK', 'NO_HIT'])
    """

    fraction: FloatArray
    """(n,) fraction of the path from start to end, in [0, 1]; NaN without a hit."""
    patch: IntArray
    """(n,) index of the patch, −1 without a hit."""
    uv: FloatArray
    """(n, 2) parameters on that patch."""
    point: FloatArray
    """(n, 3) point of the surface where the path enters."""
    status: ByteArray
    """(n,) `Status`."""

    def _facts(self) -> Facts:
        return [("segments", len(self.status)), *_statuses(self.status)]


@displayed
class RayHit(NamedTuple):
    """First hits of n rays, on either side of the surface.

    >>> import contiga as cg
    >>> ball = cg.Body([cg.shapes.sphere(radius=1.0)])
    >>> hit = ball.ray([[0.0, 0.0, 3.0], [0.0, 0.0, 0.0]], [0.0, 0.0, -2.0])
    >>> hit.distance.round(12).tolist(), hit.normal[:, 2].round(12).tolist()
    ([2.0, 1.0], [1.0, -1.0])
    """

    distance: FloatArray
    """(n,) from the origin, length; NaN without a hit."""
    patch: IntArray
    """(n,) index of the patch, −1 without a hit."""
    uv: FloatArray
    """(n, 2) parameters on that patch."""
    point: FloatArray
    """(n, 3) point of the surface."""
    normal: FloatArray
    """(n, 3) unit normals there, to the free side."""
    status: ByteArray
    """(n,) `Status`."""

    def _facts(self) -> Facts:
        return [("rays", len(self.status)), *_statuses(self.status)]


def _statuses(codes: ByteArray) -> Facts:
    """Return the number of rows of each status that occurs."""
    return counted((status.name for status in Status), np.bincount(codes, minlength=len(Status)))


class LawInput(NamedTuple):
    """Points in contact, the input of a force law.

    >>> one = np.array([0.1])
    >>> seen = LawInput(one, 0.0 * one, area=one, thickness=None, mass=None, dt=0.0)
    >>> import contiga as cg
    >>> cg.PenaltyLaw(50.0).respond(seen).force.tolist()
    [5.0]
    """

    penetration: FloatArray
    """(n_c,) λ ≥ 0."""
    rate: FloatArray
    """(n_c,) dλ/dt, zero for points that are new in contact."""
    area: FloatArray
    """(n_c,) nodal contact areas."""
    thickness: FloatArray | None
    """(n_c,) slave thickness, if the slave has one."""
    mass: FloatArray | None
    """(n_c,) nodal mass, if the slave has one."""
    dt: float
    """Step length, zero at the start and in statics."""
    memory: FloatArray = np.zeros((0, 0))
    """(n_c, m) state that the law returned for each point at the last step; zero for new points."""
    patch: IntArray | None = None
    """(n_c,) face of the master at each foot, for laws with `needs_patch`."""
    wants_tangent: bool = False
    """Whether to compute `LawOutput.tangent`, for `Contact.tangent`. Steps do not need it."""


class DepthSlopes(NamedTuple):
    """Derivatives of one value a point by the penetrations of n_c points.

    ∂y_i/∂λ_j = own_i δ_ij + Σ_k left_ik right_jk.

    Two points with springs of 5, where the depth of either reduces both forces by 2:

    >>> both = DepthSlopes(np.array([5.0, 5.0]), np.ones((2, 1)), np.full((2, 1), -2.0))
    >>> (np.diag(both.own) + both.left @ both.right.T).tolist()
    [[3.0, -2.0], [-2.0, 3.0]]
    """

    own: FloatArray
    """(n_c,) derivative of each value by its own penetration."""
    left: FloatArray | None = None
    """(n_c, r), and `right` of the same shape; None if no value depends on other points."""
    right: FloatArray | None = None


class LawTangent(NamedTuple):
    """Derivatives of a law's output at fixed areas and memory of the last step.

    >>> import contiga as cg
    >>> one = np.array([0.1])
    >>> seen = LawInput(one, one, one, None, None, 0.5, wants_tangent=True)
    >>> slopes = cg.PenaltyLaw(50.0, damping=2.0).respond(seen).tangent
    >>> slopes.force.own.tolist(), slopes.rate.tolist()
    ([50.0], [2.0])
    """

    force: DepthSlopes
    """Derivatives of the forces at fixed rates."""
    rate: FloatArray | None = None
    """(n_c,) derivative of each force by its own rate; None if no force depends on it."""
    stiffness: DepthSlopes | None = None
    """Derivatives of `LawOutput.stiffness`, which scales friction's springs; None if constant."""


class LawOutput(NamedTuple):
    """Output of a force law for n_c points in contact."""

    force: FloatArray
    """(n_c,) magnitudes along the master's normal, zero or positive."""
    stiffness: FloatArray
    """(n_c,) elastic force over penetration, its slope for more of it."""
    stored: FloatArray
    """(n_c,) elastic energy that unloading returns."""
    memory: FloatArray
    """(n_c, m) state of each point for the next step, where it is `LawInput.memory`."""
    hysteresis: FloatArray | None = None
    """(n_c,) energy lost in the step because unloading differs from loading; None for elastic
    laws."""
    damping: FloatArray | None = None
    """(n_c,) the part of `force` due to the rate; None for laws without damping."""
    stiffness_bound: FloatArray | None = None
    """(n_c,) upper bound of the elastic stiffness, coupling included, for the critical step:
    vᵀ (∂F_i/∂λ_j) v ≤ Σ bound_i v_i² for all v. None for laws whose force on a point depends on its
    own penetration alone: then it is `stiffness`."""
    tangent: FloatArray | LawTangent | None = None
    """Derivatives of the forces for `Contact.tangent`: a `LawTangent`, or (n_c,) slopes for laws
    whose force depends on its own penetration alone, and not on the rate."""


@displayed
class MassProperties(NamedTuple):
    """Mass, centre of mass and inertia of a rigid body.

    >>> import contiga as cg
    >>> ball = cg.Body([cg.shapes.sphere(radius=1.0, centre=(1, 2, 3))]).mass_properties(3.0)
    >>> round(ball.mass / np.pi, 9), ball.centre.round(9).tolist()
    (4.0, [1.0, 2.0, 3.0])
    """

    mass: float
    """Mass."""
    centre: FloatArray
    """(3,) centre of mass, body axes and origin, length."""
    inertia: FloatArray
    """(3, 3) inertia tensor about the centre, body axes, mass times length²; off the diagonal
    I_xy = −∫ x y dm."""

    def _facts(self) -> Facts:
        I = self.inertia
        return [
            ("mass", float(self.mass)),
            ("centre", tuple(map(float, self.centre))),
            ("Ixx Iyy Izz", (float(I[0, 0]), float(I[1, 1]), float(I[2, 2]))),
            ("Ixy Iyz Ixz", (float(I[0, 1]), float(I[1, 2]), float(I[0, 2]))),
        ]


def empty_projection(n: int) -> Projection:
    """Return a projection of n rows to be filled: arbitrary values, but `certified` is zero."""
    return Projection(
        np.empty(n, np.int32),
        np.empty((n, 2)),
        np.empty((n, 3)),
        np.empty((n, 3)),
        np.empty(n),
        np.empty(n, np.int8),
        np.empty(n, np.int8),
        np.zeros(n, np.int8),
    )


def rows_of(feet: Projection, rows: IndexArray) -> Projection:
    """Return a copy of some rows of a projection, in the order of `rows`."""
    return Projection._make(values.take(rows, axis=0) for values in feet)


def stacked(first: Projection, second: Projection) -> Projection:
    """Return the rows of two projections in one, those of `first` before those of `second`."""
    fields = Projection._fields
    return Projection(*(np.concatenate([getattr(first, f), getattr(second, f)]) for f in fields))


def empty_hit(n: int) -> Hit:
    """Return a record of n hits to be filled: its values are arbitrary."""
    return Hit(
        np.empty(n), np.empty(n, np.int32), np.empty((n, 2)), np.empty((n, 3)), np.empty(n, np.int8)
    )
