"""Derivatives of friction's forces, of each point for itself or of all as one.

Traction follows from the normal force, the stiffness of the law, the normal, the path and the
velocity of a point; each of these changes with the variables of points, and friction says how its
force changes with them.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from contiga.arrays.layout import as_numbers
from contiga.arrays.ordered import length, product
from contiga.contact.respond import ContactRows, Seen
from contiga.errors import InputError
from contiga.laws.friction import Friction, FrictionChange, FrictionInput
from contiga.records import DepthSlopes, FloatArray, LawOutput, LawTangent


class Terms(NamedTuple):
    """Derivatives of forces on k points over m variables of each: blocks, and what couples them.

    dF_i = blocks_i dy_i + left_i Σ_j right_jᵀ dy_j.
    """

    blocks: FloatArray
    """(k, 3, m)."""
    left: FloatArray
    """(k, 3, r)."""
    right: FloatArray
    """(k, m, r)."""

    @classmethod
    def of(cls, blocks: FloatArray) -> Terms:
        """Make terms of blocks alone."""
        k, _, m = blocks.shape
        return cls(blocks, np.zeros((k, 3, 0)), np.zeros((k, m, 0)))

    def plus(self, other: Terms) -> Terms:
        """Add other terms."""
        left = np.concatenate([self.left, other.left], axis=2)
        right = np.concatenate([self.right, other.right], axis=2)
        return Terms(self.blocks + other.blocks, left, right)

    def over(self, variables: slice) -> Terms:
        """Return the derivatives over some of the variables."""
        blocks, right = self.blocks[:, :, variables], self.right[:, variables]
        return Terms(np.ascontiguousarray(blocks), self.left, right)

    def applied(self, ways: FloatArray) -> FloatArray:
        """Return (k, 3, n) dF of points whose variables change in n ways (k, m, n)."""
        along = np.einsum("kbr,kbm->rm", self.right, ways, optimize=False)
        own = np.einsum("kab,kbm->kam", self.blocks, ways, optimize=False)
        return np.asarray(own + product(self.left, along))

    def summed(self, factors: FloatArray | None = None) -> FloatArray:
        """Return derivatives (k, 3, m) of Σ_i F_i by each point; (k, 3, 3) of Σ_i factors_i F_i."""
        own, left = self.blocks, self.left.sum(axis=0)
        if factors is not None:
            own = np.einsum("kab,kbc->kac", factors, self.blocks, optimize=False)
            left = np.einsum("kab,kbr->ar", factors, self.left, optimize=False)
        return np.asarray(own + np.einsum("ar,kbr->kab", left, self.right, optimize=False))


class InputChange(NamedTuple):
    """Derivatives of the input of laws by m variables of each of k points; body axes."""

    depth: FloatArray
    """(k, m)."""
    normal: FloatArray
    """(k, 3, m)."""
    path: FloatArray
    """(k, 3, m); (1, 3, m) of points that are all alike."""
    velocity: FloatArray
    """(k, 3, m) of velocities that the step was given, (1, 3, m) of points that are all alike;
    (0, 3, m) where they stay, or follow from the path."""


class Carried(NamedTuple):
    """Points that carry forces, and the derivatives of their normal forces."""

    points: ContactRows
    output: LawOutput
    tangent: LawTangent
    change: InputChange
    grown: FloatArray
    """(k, m) derivatives of each normal force over the variables of its own point."""
    dt: float
    """Length of the step; infinite where it has none."""

    def pulled(self, of: DepthSlopes) -> FloatArray:
        """Return (k, m, r) right sides of a coupling of depths, over the variables of points."""
        assert of.right is not None
        return self.change.depth[:, :, None] * of.right[:, None, :]

    def friction_change(self, seen: FrictionInput, has_rate: bool) -> FrictionChange:
        """Return the change of friction's input with the variables of each point.

        Velocities change where friction depends on them, `has_rate`.
        """
        points, change, output = self.points, self.change, self.output
        k, m = change.depth.shape
        # The path counts behind the entry: all of it, but of new points the share that is below.
        path = points.inside[:, None, None] * change.path
        new = np.flatnonzero(~points.old & (points.inside > 0.0) & (points.inside < 1.0))
        if len(new):
            n, way = points.normal[new, :, None], points.path[new, :, None]
            along = np.broadcast_to(change.path, (k, 3, m))[new]
            approach = (way * change.normal[new] + n * along).sum(axis=1)
            share = change.depth[new] + points.inside[new, None] * approach
            path[new] -= way * (share / (way * n).sum(axis=1))[:, None]
        velocity = change.velocity
        if not has_rate:
            velocity = np.zeros((0, 3, m))
        elif len(points.velocity) == 0 and np.isfinite(self.dt):
            velocity = change.path / self.dt
        if len(velocity):
            velocity = np.broadcast_to(velocity, (k, 3, m))
        # The stiffness of a point without a slope is the secant.
        slopes = self.tangent.stiffness
        grown = np.zeros(k) if slopes is None else np.where(output.stiffness > 0, slopes.own, 0.0)
        secant = (output.stiffness <= 0.0) & (points.depth > 0.0) & (seen.stiffness > 0.0)
        grown[secant] = (output.stiffness - seen.stiffness)[secant] / points.depth[secant]
        springs = grown[:, None] * change.depth
        return FrictionChange(self.grown, springs, change.normal, path, velocity)


def friction_terms(friction: Friction, seen: Seen, carried: Carried) -> Terms:
    """Derivatives of friction's forces over the variables of points.

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
    own = carried.friction_change(seen.points, getattr(friction, "has_rate", True))
    if seen.whole is None:
        return _of_points(friction, seen.points, carried, own)
    return _of_whole(friction, seen, seen.whole, carried, own)


def _changes(friction: Any, seen: FrictionInput, change: FrictionChange) -> FloatArray:
    """Return the changes (n, 3, m) of friction's forces, checked."""
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
    """Differentiate friction that sees all points as one.

    Its force is shared as the normal force is: d(s_i T) = T ds_i + s_i dT of the shares s_i =
    F_i/ΣF.
    """
    points, force = seen.points, carried.tangent.force
    (k, m), total = own.force.shape, float(points.force.sum())
    shares = points.force / total if total > 0.0 else np.full(k, 1.0 / k)

    def summed(weights: FloatArray, grown: FloatArray, of: DepthSlopes | None) -> FloatArray:
        """Return Σ_i weights_i dv_i (d, k, m) over all points; over its own, v is `grown`."""
        change: FloatArray = weights.T[:, :, None] * grown
        if of is not None and of.left is not None:
            change += np.einsum("dr,jcr->djc", product(weights.T, of.left), carried.pulled(of))
        return change

    def shifted(values: FloatArray) -> FloatArray:
        """Return (d, k, m) Σ_i values_i ds_i over all points."""
        if not total > 0.0:
            return np.zeros((values.shape[1], k, m))
        return summed(values - product(shares, values), own.force, force) / total

    def weighted(weights: FloatArray, changes: FloatArray) -> FloatArray:
        """Return Σ_i weights_i dv_i (d, k, m) of vectors that change with their own points."""
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
    turned = _changes(friction, whole, change)[0].reshape(3, k, m)
    traction = np.asarray(friction.respond(whole).force)[0]
    none = np.zeros((k, 3, m))
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
