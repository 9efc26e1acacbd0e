"""Derivatives of friction's forces, of each point for itself or of all as one.

Traction follows from the normal force, the stiffness of the law, the normal, the path and the
velocity of a point; each of these changes with the places of points, and friction says how its
force changes with them.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from contiga.arrays.layout import as_numbers
from contiga.arrays.ordered import length, product, row_products
from contiga.contact.respond import ContactRows, Seen
from contiga.errors import InputError
from contiga.laws.friction import Friction, FrictionChange, FrictionInput
from contiga.records import DepthSlopes, FloatArray, FootSlopes, LawOutput, LawTangent


class Terms(NamedTuple):
    """Derivatives of forces on k points over their places or velocities: blocks, and what couples
    them.

    dF_i = blocks_i dx_i + left_i Σ_j right_jᵀ dx_j.
    """

    blocks: FloatArray
    """(k, 3, 3)."""
    left: FloatArray
    """(k, 3, r), with the next."""
    right: FloatArray

    @classmethod
    def of(cls, blocks: FloatArray) -> Terms:
        """Make terms of blocks alone."""
        none = np.zeros((len(blocks), 3, 0))
        return cls(blocks, none, none)

    def plus(self, other: Terms) -> Terms:
        """Add other terms."""
        left = np.concatenate([self.left, other.left], axis=2)
        right = np.concatenate([self.right, other.right], axis=2)
        return Terms(self.blocks + other.blocks, left, right)

    def after(self, matrix: FloatArray) -> Terms:
        """Compose with dx_i = `matrix` (3, 3) dy_i: derivatives over y."""
        right = np.einsum("kbr,ba->kar", self.right, matrix, optimize=False)
        return Terms(product(self.blocks, matrix), self.left, right)

    def applied(self, ways: FloatArray) -> FloatArray:
        """(k, 3, m) dF of points that go m ways (k, 3, m)."""
        along = np.einsum("kbr,kbm->rm", self.right, ways, optimize=False)
        own = np.einsum("kab,kbm->kam", self.blocks, ways, optimize=False)
        return np.asarray(own + product(self.left, along))

    def summed(self, factors: FloatArray | None = None) -> FloatArray:
        """(k, 3, 3) derivatives of Σ_i F_i over each point; of Σ_i factors_i F_i (k, 3, 3)."""
        own, left = self.blocks, self.left.sum(axis=0)
        if factors is not None:
            own = np.einsum("kab,kbc->kac", factors, self.blocks, optimize=False)
            left = np.einsum("kab,kbr->ar", factors, self.left, optimize=False)
        return np.asarray(own + np.einsum("ar,kbr->kab", left, self.right, optimize=False))


class Carried(NamedTuple):
    """Points that carry forces, and the derivatives of their normal forces and feet."""

    points: ContactRows
    output: LawOutput
    tangent: LawTangent
    slopes: FootSlopes
    grown: FloatArray
    """(k, 3) gradient of each normal force over its own point."""
    dt: float
    """Length of the step; infinite where it has none."""

    def pulled(self, of: DepthSlopes) -> FloatArray:
        """(k, 3, r) right sides of a coupling of depths, over the places of points."""
        assert of.right is not None
        return self.slopes.depth[:, :, None] * of.right[:, None, :]


def changes_over_places(seen: FrictionInput, carried: Carried, has_rate: bool) -> FrictionChange:
    """How each point's input changes with its own place, along the three axes; velocities follow
    where friction depends on them, `has_rate`."""
    points, slopes, output = carried.points, carried.slopes, carried.output
    k, depth = len(points.rows), points.depth
    # The path counts behind the entry: all of it, but of new points the share that is below.
    path = np.zeros((k, 3, 3))
    for c in range(3):
        path[:, c, c] = points.inside
    new = np.flatnonzero(~points.old & (points.inside > 0.0) & (points.inside < 1.0))
    if len(new):
        n, way = points.normal[new], points.path[new]
        turn = np.einsum("ki,kij->kj", way, slopes.normal[new], optimize=False)
        approach = -row_products(way, n)[:, None]
        share = (slopes.depth[new] + points.inside[new, None] * (n + turn)) / approach
        path[new] += way[:, :, None] * share[:, None, :]
    # The stiffness of a point without a slope is the secant.
    stiffness = carried.tangent.stiffness
    grown = np.zeros(k) if stiffness is None else np.where(output.stiffness > 0, stiffness.own, 0.0)
    secant = (output.stiffness <= 0.0) & (depth > 0.0) & (seen.stiffness > 0.0)
    grown[secant] = (output.stiffness - seen.stiffness)[secant] / depth[secant]
    velocity = np.zeros((0, 3, 3))
    if has_rate and len(points.velocity) == 0 and np.isfinite(carried.dt):
        velocity = np.tile(np.eye(3) / carried.dt, (k, 1, 1))
    springs = grown[:, None] * slopes.depth
    return FrictionChange(carried.grown, springs, slopes.normal, path, velocity)


def changes_over_velocities(grown: FloatArray) -> FrictionChange:
    """How each point's input changes with its own velocity, along the three axes, `grown` (k, 3)
    that of its normal force."""
    none = np.zeros((len(grown), 3, 3))
    velocity = np.tile(np.eye(3), (len(grown), 1, 1))
    return FrictionChange(grown, np.zeros(grown.shape), none, none, velocity)


def changes_over_normals(k: int) -> FrictionChange:
    """Return the change of the input of k points by rotations of their normals, by three axes."""
    stays, turns = np.zeros((k, 3, 3)), np.tile(np.eye(3), (k, 1, 1))
    return FrictionChange(np.zeros((k, 3)), np.zeros((k, 3)), turns, stays, np.zeros((0, 3, 3)))


def friction_terms(friction: Friction, seen: Seen, carried: Carried, own: FrictionChange) -> Terms:
    """Derivatives of friction's forces, where each point's input changes by its `own` way.

    Raises
    ------
    InputError
        The friction has none.
    """
    if not hasattr(friction, "changes"):
        raise InputError(
            "the friction has no derivatives",
            where="friction",
            found=type(friction).__name__,
            allowed="Coulomb, ViscousFriction, or an object with changes",
            remedy="Give it changes(FrictionInput, FrictionChange), (n, 3, m) of its forces",
        )
    if seen.whole is None:
        return _of_points(friction, seen.points, carried, own)
    return _of_whole(friction, seen, seen.whole, carried, own)


def _changes(friction: Any, seen: FrictionInput, change: FrictionChange) -> FloatArray:
    """(n, 3, m) of the forces, as friction answers, checked."""
    where = "friction: changes"
    answer = as_numbers(friction.changes(seen, change), where, "friction must answer numbers")
    n, m = change.force.shape
    if answer.shape != (n, 3, m):
        raise InputError(
            "friction must answer a vector a point and direction",
            where=where,
            found=answer.shape,
            allowed=str((n, 3, m)),
        )
    return answer


def _of_points(friction: Any, seen: FrictionInput, carried: Carried, own: FrictionChange) -> Terms:
    """Differentiate friction that sees each point for itself."""
    blocks, k = _changes(friction, seen, own), len(seen.force)
    couplings = carried.tangent.force, carried.tangent.stiffness
    terms = Terms.of(blocks)
    if all(one is None or one.left is None for one in couplings):
        return terms
    # How each force changes with the normal force and the stiffness, which other points change.
    stays, one, none = np.zeros((k, 3, 2)), np.ones(k), np.zeros(k)
    by_force, by_stiffness = np.stack([one, none], axis=1), np.stack([none, one], axis=1)
    change = FrictionChange(by_force, by_stiffness, stays, stays, stays)
    partial = _changes(friction, seen, change)
    nothing = np.zeros(blocks.shape)
    for j, slopes in enumerate(couplings):
        if slopes is not None and slopes.left is not None:
            left = partial[:, :, j, None] * slopes.left[:, None, :]
            terms = terms.plus(Terms(nothing, left, carried.pulled(slopes)))
    return terms


def _of_whole(
    friction: Any, seen: Seen, whole: FrictionInput, carried: Carried, own: FrictionChange
) -> Terms:
    """Differentiate friction that sees all points as one, and whose force is shared as the normal
    force is: d(s_i T) = T ds_i + s_i dT of the shares s_i = F_i/ΣF."""
    points, force = seen.points, carried.tangent.force
    k, total = len(points.force), float(points.force.sum())
    shares = points.force / total if total > 0.0 else np.full(k, 1.0 / k)

    def summed(weights: FloatArray, grown: FloatArray, of: DepthSlopes | None) -> FloatArray:
        """(d, k, 3) Σ_i weights_i dy_i over all points; of each y over its own it is `grown`."""
        change: FloatArray = weights.T[:, :, None] * grown
        if of is not None and of.left is not None:
            change += np.einsum("dr,jcr->djc", product(weights.T, of.left), carried.pulled(of))
        return change

    def shifted(values: FloatArray) -> FloatArray:
        """(d, k, 3) Σ_i values_i ds_i over all points."""
        if not total > 0.0:
            return np.zeros((values.shape[1], k, 3))
        return summed(values - product(shares, values), own.force, force) / total

    def weighted(weights: FloatArray, changes: FloatArray) -> FloatArray:
        """(d, k, 3) Σ_i weights_i dy_i of vectors that change with their own points alone."""
        return np.moveaxis(weights[:, None, None] * changes, 0, 1)

    one = np.ones((k, 1))
    total_grown = summed(one, own.force, force)
    springs = summed(one, own.stiffness, carried.tangent.stiffness)
    mean = product(shares, points.normal)
    size = length(mean)
    normal = shifted(points.normal) + weighted(shares, own.normal)
    if size > 0.0:
        normal = (normal - np.einsum("a,b,bkc->akc", mean, mean, normal) / size**2) / size
    path = seen.present * shifted(points.path) + weighted(seen.ways, own.path)
    velocity = shifted(points.velocity)
    if len(own.velocity):
        velocity += weighted(shares, own.velocity)
    change = FrictionChange(
        total_grown.reshape(1, -1),
        springs.reshape(1, -1),
        *(np.ascontiguousarray(v.reshape(1, 3, -1)) for v in (normal, path, velocity)),
    )
    turned = _changes(friction, whole, change)[0].reshape(3, k, 3)
    traction = np.asarray(friction.respond(whole).force)[0]
    none = np.zeros((k, 3, 3))
    terms = Terms(none, shares[:, None, None] * np.eye(3), np.moveaxis(turned, 0, 2))
    if not total > 0.0:
        return terms
    sharing = (traction / total)[:, None] * own.force[:, None, :]
    of_all = -(shares / total)[:, None, None] * traction[:, None]
    terms = terms.plus(Terms(sharing, of_all, total_grown[0][:, :, None]))
    if force.left is not None:
        left = (traction / total)[:, None] * force.left[:, None, :]
        terms = terms.plus(Terms(none, left, carried.pulled(force)))
    return terms
