"""The records that rooms hand to each other. Arrays inside are one row a point."""

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
    """Standing of a slave point after a step."""

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
    """(n,) index of the patch, −1 where there is no foot."""
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
    """(n,) 1 where the foot is proved, not merely converged: of a search over the whole body, that
    no other point is closer (up to tolerance); of a tracked foot, that it is on the branch of
    stationary points continued from its start along the straight motion of the point. 0 where that
    could not be shown."""

    def _facts(self) -> Facts:
        proved = int(np.count_nonzero(self.certified))
        return [("points", len(self.status)), *_statuses(self.status), ("certified", proved)]


class FootSlopes(NamedTuple):
    """Derivatives of depths and normals at feet by their points, one row a point."""

    depth: FloatArray
    """(n, 3) of the depth, which is minus the signed distance."""
    normal: FloatArray
    """(n, 3, 3) of the unit normal; its components by row."""


class SurfacePlaces(NamedTuple):
    """Places on a surface, one row each."""

    patch: IntArray
    """(n,) int32; −1 where there is none."""
    uv: FloatArray
    """(n, 2)."""


class KnownSides(NamedTuple):
    """On which side of a closed surface points lie, as far as it is known."""

    side: ByteArray
    """(n,) 1 outside, −1 inside, 0 not known."""
    reach: FloatArray
    """(n,) length greater than rounding that leads to no surface, where the side is known."""

    def at(self, rows: IndexArray) -> KnownSides:
        """Return the rows of some of the points."""
        return KnownSides(self.side[rows], self.reach[rows])


class FacingLimits(NamedTuple):
    """Limits on feet that do not face away from a guard."""

    cosine: float
    """Of their normals and the guard, at least."""
    near: FloatArray
    """(n,) how near they may be, length."""
    far: FloatArray
    """(n,) how far they may be, length; infinite where that is not known. A search ends there."""


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
    """(n,) of the way from start to end, in [0, 1]; NaN where there is no hit."""
    patch: IntArray
    """(n,) index of the patch, −1 where there is no hit."""
    uv: FloatArray
    """(n, 2) parameters on that patch."""
    point: FloatArray
    """(n, 3) on the surface, where the path enters."""
    status: ByteArray
    """(n,) `Status`."""

    def _facts(self) -> Facts:
        return [("segments", len(self.status)), *_statuses(self.status)]


@displayed
class RayHit(NamedTuple):
    """First hits of n rays, on whichever side.

    >>> import contiga as cg
    >>> ball = cg.Body([cg.shapes.sphere(radius=1.0)])
    >>> hit = ball.ray([[0.0, 0.0, 3.0], [0.0, 0.0, 0.0]], [0.0, 0.0, -2.0])
    >>> hit.distance.round(12).tolist(), hit.normal[:, 2].round(12).tolist()
    ([2.0, 1.0], [1.0, -1.0])
    """

    distance: FloatArray
    """(n,) from the origin, NaN where there is no hit."""
    patch: IntArray
    """(n,) index of the patch, −1 where there is no hit."""
    uv: FloatArray
    """(n, 2) parameters on that patch."""
    point: FloatArray
    """(n, 3) on the surface."""
    normal: FloatArray
    """(n, 3) unit normals there, to the free side."""
    status: ByteArray
    """(n,) `Status`."""

    def _facts(self) -> Facts:
        return [("rays", len(self.status)), *_statuses(self.status)]


def _statuses(codes: ByteArray) -> Facts:
    """How many rows have each status that occurs."""
    return counted((status.name for status in Status), np.bincount(codes, minlength=len(Status)))


class LawInput(NamedTuple):
    """Points in contact as a force law sees them.

    >>> one = np.array([0.1])
    >>> seen = LawInput(one, 0.0 * one, area=one, thickness=None, mass=None, dt=0.0)
    >>> import contiga as cg
    >>> cg.PenaltyLaw(50.0).respond(seen).force.tolist()
    [5.0]
    """

    penetration: FloatArray
    """(n_c,) λ ≥ 0."""
    rate: FloatArray
    """(n_c,) dλ/dt, zero for points without a past."""
    area: FloatArray
    """(n_c,) nodal contact areas."""
    thickness: FloatArray | None
    """(n_c,) slave thickness where the slave has one."""
    mass: FloatArray | None
    """(n_c,) nodal mass where the slave has one."""
    dt: float
    """Step length, zero at the start and in statics."""
    memory: FloatArray = np.zeros((0, 0))
    """(n_c, m) what the law left of each point at the last step, zero of a point without a past."""
    patch: IntArray | None = None
    """(n_c,) face of the master that each foot is on, for laws with `needs_patch`."""
    wants_tangent: bool = False
    """Whether `LawOutput.tangent` is asked for, as by `Contact.tangent`. Steps do not need it."""


class DepthSlopes(NamedTuple):
    """Derivatives of a value of n_c points by their penetrations.

    ∂y_i/∂λ_j = own_i δ_ij + Σ_k left_ik right_jk.

    Two points with springs of 5, whose forces both fall by 2 for the depth of either:

    >>> both = DepthSlopes(np.array([5.0, 5.0]), np.ones((2, 1)), np.full((2, 1), -2.0))
    >>> (np.diag(both.own) + both.left @ both.right.T).tolist()
    [[3.0, -2.0], [-2.0, 3.0]]
    """

    own: FloatArray
    """(n_c,) of each value over its own penetration."""
    left: FloatArray | None = None
    """(n_c, r), with `right` of the same shape; None where no value depends on other points."""
    right: FloatArray | None = None


class LawTangent(NamedTuple):
    """Derivatives of a law's answer, areas and memory of the last step held.

    >>> import contiga as cg
    >>> one = np.array([0.1])
    >>> seen = LawInput(one, one, one, None, None, 0.5, wants_tangent=True)
    >>> slopes = cg.PenaltyLaw(50.0, damping=2.0).respond(seen).tangent
    >>> slopes.force.own.tolist(), slopes.rate.tolist()
    ([50.0], [2.0])
    """

    force: DepthSlopes
    """Of the forces, at fixed rates."""
    rate: FloatArray | None = None
    """(n_c,) of each force over its own rate; None where no force depends on it."""
    stiffness: DepthSlopes | None = None
    """Of `LawOutput.stiffness`, by which friction's springs grow; None where it is constant."""


class LawOutput(NamedTuple):
    """Answer of a force law for n_c points in contact."""

    force: FloatArray
    """(n_c,) magnitudes along the master's normal, never negative."""
    stiffness: FloatArray
    """(n_c,) elastic force over penetration, its slope for more of it."""
    stored: FloatArray
    """(n_c,) elastic energy that the force would give back."""
    memory: FloatArray
    """(n_c, m) what the law wants to see of each point at the next step."""
    hysteresis: FloatArray | None = None
    """(n_c,) energy lost in the step since the law's unloading differs from its loading; None of
    laws that are elastic."""
    damping: FloatArray | None = None
    """(n_c,) the part of `force` that is due to the rate; None of laws without."""
    stiffness_bound: FloatArray | None = None
    """(n_c,) springs at least as stiff as the slope of all elastic forces over all penetrations,
    whatever way points go: vᵀ (∂F_i/∂λ_j) v ≤ Σ bound_i v_i². The critical step goes by it. None
    of laws whose force on a point depends on its own penetration alone: that is `stiffness`."""
    tangent: FloatArray | LawTangent | None = None
    """Derivatives of the forces, which `Contact.tangent` needs: a `LawTangent`, or (n_c,) slopes of
    laws whose force depends on its own penetration alone, and not on the rate."""


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
    """(3, 3) inertia about the centre, body axes, mass times length². Entries off the diagonal are
    those of the tensor: I_xy = −∫ x y dm."""

    def _facts(self) -> Facts:
        I = self.inertia
        return [
            ("mass", float(self.mass)),
            ("centre", tuple(map(float, self.centre))),
            ("Ixx Iyy Izz", (float(I[0, 0]), float(I[1, 1]), float(I[2, 2]))),
            ("Ixy Iyz Ixz", (float(I[0, 1]), float(I[1, 2]), float(I[0, 2]))),
        ]


def empty_projection(n: int) -> Projection:
    """A projection of n rows to be filled."""
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
    """Some rows of a projection."""
    return Projection._make(values.take(rows, axis=0) for values in feet)


def stacked(one: Projection, other: Projection) -> Projection:
    """The rows of one projection, and after them those of another."""
    fields = Projection._fields
    return Projection(*(np.concatenate([getattr(one, f), getattr(other, f)]) for f in fields))


def empty_hit(n: int) -> Hit:
    """A record of n hits to be filled."""
    return Hit(
        np.empty(n), np.empty(n, np.int32), np.empty((n, 2)), np.empty((n, 3)), np.empty(n, np.int8)
    )
