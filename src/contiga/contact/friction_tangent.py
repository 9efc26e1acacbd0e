"""Compute the derivatives of friction forces, of single points or of all points as one.

Traction depends on the normal force, the stiffness of the law, the normal, the path and the
velocity of a point. Each of these depends on the variables of points, and friction gives the change
of its force with them.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from contiga.arrays.layout import as_numbers
from contiga.arrays.ordered import length, product
from contiga.contact.respond import ContactRows, FrictionInputs
from contiga.errors import InputError
from contiga.laws.friction import Friction, FrictionChange, FrictionInput
from contiga.records import DepthSlopes, FloatArray, LawOutput, LawTangent


class Terms(NamedTuple):
    """Derivatives of forces on k points with respect to m variables of each: blocks and couplings.

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
        """Return the sum with other terms."""
        left = np.concatenate([self.left, other.left], axis=2)
        right = np.concatenate([self.right, other.right], axis=2)
        return Terms(self.blocks + other.blocks, left, right)

    def over(self, variables: slice) -> Terms:
        """Return the derivatives with respect to some of the variables."""
        blocks, right = self.blocks[:, :, variables], self.right[:, variables]
        return Terms(np.ascontiguousarray(blocks), self.left, right)

    def applied(self, changes: FloatArray) -> FloatArray:
        """Return dF (k, 3, n) for n changes (k, m, n) of the variables of points."""
        coupled = np.einsum("kbr,kbm->rm", self.right, changes, optimize=False)
        direct = np.einsum("kab,kbm->kam", self.blocks, changes, optimize=False)
        return np.asarray(direct + product(self.left, coupled))

    def summed(self, factors: FloatArray | None = None) -> FloatArray:
        """Return derivatives (k, 3, m) of Σ_i F_i with respect to the variables of each point.

        With `factors` (k, 3, 3) they are those of Σ_i factors_i F_i.
        """
        direct, left = self.blocks, self.left.sum(axis=0)
        if factors is not None:
            direct = np.einsum("kab,kbc->kac", factors, self.blocks, optimize=False)
            left = np.einsum("kab,kbr->ar", factors, self.left, optimize=False)
        return np.asarray(direct + np.einsum("ar,kbr->kab", left, self.right, optimize=False))


class InputChange(NamedTuple):
    """Derivatives of the input of laws with respect to m variables of each of k points, body axes.

    A change is with respect to the variables of its own point.
    """

    depth: FloatArray
    """(k, m)."""
    normal: FloatArray
    """(k, 3, m)."""
    path: FloatArray
    """(k, 3, m); (1, 3, m) if the same for all points."""
    velocity: FloatArray
    """(k, 3, m) of given velocities, (1, 3, m) if the same for all points; (0, 3, m) if constant,
    or derived from the path."""


class CarryingPoints(NamedTuple):
    """Points that carry forces, and the derivatives of their normal forces."""

    points: ContactRows
    output: LawOutput
    tangent: LawTangent
    change: InputChange
    force_change: FloatArray
    """(k, m) derivatives of each normal force with respect to its own point's variables."""
    dt: float
    """Length of the step; infinite in statics."""

    def right_sides(self, of: DepthSlopes) -> FloatArray:
        """Return the right sides (k, m, r) of a coupling of depths over the variables."""
        assert of.right is not None
        return self.change.depth[:, :, None] * of.right[:, None, :]

    def friction_change(self, inputs: FrictionInput, has_rate: bool) -> FrictionChange:
        """Return the change of friction's input with the variables of each point.

        Paths of new points count from their entry. Velocities change where friction depends on
        them, `has_rate`. Points on a plateau of the law have its secant as stiffness, as in a step.
        """
        points, change, output = self.points, self.change, self.output
        k, m = change.depth.shape
        # The path counts from the entry: for new points only the share below the surface.
        path = points.inside[:, None, None] * change.path
        new_rows = np.flatnonzero(~points.old & (points.inside > 0.0) & (points.inside < 1.0))
        if len(new_rows):
            n, path_now = points.normal[new_rows, :, None], points.path[new_rows, :, None]
            path_change = np.broadcast_to(change.path, (k, 3, m))[new_rows]
            approach = (path_now * change.normal[new_rows] + n * path_change).sum(axis=1)
            share = change.depth[new_rows] + points.inside[new_rows, None] * approach
            path[new_rows] -= path_now * (share / (path_now * n).sum(axis=1))[:, None]
        velocity = change.velocity
        if not has_rate:
            velocity = np.zeros((0, 3, m))
        elif len(points.velocity) == 0 and np.isfinite(self.dt):
            velocity = change.path / self.dt
        if len(velocity):
            velocity = np.broadcast_to(velocity, (k, 3, m))
        slopes = self.tangent.stiffness
        slope = np.zeros(k) if slopes is None else np.where(output.stiffness > 0, slopes.own, 0.0)
        secant = (output.stiffness <= 0.0) & (points.depth > 0.0) & (inputs.stiffness > 0.0)
        slope[secant] = (output.stiffness - inputs.stiffness)[secant] / points.depth[secant]
        springs = slope[:, None] * change.depth
        return FrictionChange(self.force_change, springs, change.normal, path, velocity)


def friction_terms(friction: Friction, inputs: FrictionInputs, points: CarryingPoints) -> Terms:
    """Return the derivatives of friction forces with respect to the variables of points.

    Law forces that depend on other points couple the friction of these as well.

    Raises
    ------
    InputError
        The friction has no derivatives, or some of another shape.
    """
    if not hasattr(friction, "changes"):
        raise InputError(
            "the friction has no derivatives",
            where="friction",
            found=type(friction).__name__,
            allowed="Coulomb, ViscousFriction, or an object with changes",
            remedy="Give it changes(FrictionInput, FrictionChange), (n, 3, m) of its forces",
        )
    change = points.friction_change(inputs.points, getattr(friction, "has_rate", False))
    if inputs.common is not None:
        return _terms_of_common_friction(friction, inputs, inputs.common, points, change)
    blocks, k = _checked_changes(friction, inputs.points, change), len(inputs.points.force)
    terms = Terms.of(blocks)
    couplings = points.tangent.force, points.tangent.stiffness
    if all(slopes is None or slopes.left is None for slopes in couplings):
        return terms
    # Derivatives of each force with respect to normal force and stiffness, which depend on others.
    constant, ones, zeros = np.zeros((k, 3, 2)), np.ones(k), np.zeros(k)
    by_force, by_stiffness = np.stack([ones, zeros], axis=1), np.stack([zeros, ones], axis=1)
    change = FrictionChange(by_force, by_stiffness, constant, constant, constant)
    partial = _checked_changes(friction, inputs.points, change)
    no_blocks = np.zeros(blocks.shape)
    for j, slopes in enumerate(couplings):
        if slopes is not None and slopes.left is not None:
            left = partial[:, :, j, None] * slopes.left[:, None, :]
            terms = terms.plus(Terms(no_blocks, left, points.right_sides(slopes)))
    return terms


def _checked_changes(friction: Any, inputs: FrictionInput, change: FrictionChange) -> FloatArray:
    """Return the changes (n, 3, m) of friction forces; raise `InputError` for another shape."""
    where = "friction: changes"
    answer = as_numbers(friction.changes(inputs, change), where, "friction must answer numbers")
    n, m = change.force.shape
    if answer.shape != (n, 3, m):
        raise InputError(
            "friction must answer a vector a point and direction",
            where=where,
            found=answer.shape,
            allowed=str((n, 3, m)),
        )
    return answer


def _terms_of_common_friction(
    friction: Any,
    inputs: FrictionInputs,
    common: FrictionInput,
    carrying: CarryingPoints,
    point_change: FrictionChange,
) -> Terms:
    """Return the derivatives of friction that acts on all points as one.

    Its force T is shared as the normal force: d(s_i T) = T ds_i + s_i dT with shares s_i = F_i/ΣF.
    """
    points, force = inputs.points, carrying.tangent.force
    (k, m), total = point_change.force.shape, float(points.force.sum())
    shares = points.force / total if total > 0.0 else np.full(k, 1.0 / k)

    def summed(weights: FloatArray, changes: FloatArray, of: DepthSlopes | None) -> FloatArray:
        """Return Σ_i weights_i dv_i (d, k, m), with respect to the variables of all points.

        `weights` are (k, d), `changes` (k, m) the derivatives of each v_i with respect to its own
        point's variables, and `of` its couplings with other points.
        """
        change: FloatArray = weights.T[:, :, None] * changes
        if of is not None and of.left is not None:
            change += np.einsum(
                "dr,jcr->djc", product(weights.T, of.left), carrying.right_sides(of)
            )
        return change

    def shifted(values: FloatArray) -> FloatArray:
        """Return Σ_i values_i ds_i (d, k, m) for `values` (k, d); zero without a normal force."""
        if not total > 0.0:
            return np.zeros((values.shape[1], k, m))
        return summed(values - product(shares, values), point_change.force, force) / total

    def weighted(weights: FloatArray, changes: FloatArray) -> FloatArray:
        """Return Σ_i weights_i dv_i (d, k, m) of vectors that change with their own points."""
        return np.moveaxis(weights[:, None, None] * changes, 0, 1)

    ones = np.ones((k, 1))
    total_change = summed(ones, point_change.force, force)
    springs = summed(ones, point_change.stiffness, carrying.tangent.stiffness)
    mean = product(shares, points.normal)
    size = length(mean)
    normal = shifted(points.normal) + weighted(shares, point_change.normal)
    if size > 0.0:
        normal = (normal - np.einsum("a,b,bkc->akc", mean, mean, normal) / size**2) / size
    path = inputs.present * shifted(points.path) + weighted(inputs.path_weights, point_change.path)
    velocity = shifted(points.velocity)
    if len(point_change.velocity):
        velocity += weighted(shares, point_change.velocity)
    change = FrictionChange(
        total_change.reshape(1, -1),
        springs.reshape(1, -1),
        *(np.ascontiguousarray(v.reshape(1, 3, -1)) for v in (normal, path, velocity)),
    )
    turned = _checked_changes(friction, common, change)[0].reshape(3, k, m)
    traction = np.asarray(friction.respond(common).force)[0]
    none = np.zeros((k, 3, m))
    terms = Terms(none, shares[:, None, None] * np.eye(3), np.moveaxis(turned, 0, 2))
    if not total > 0.0:
        return terms
    sharing = (traction / total)[:, None] * point_change.force[:, None, :]
    of_all = -(shares / total)[:, None, None] * traction[:, None]
    terms = terms.plus(Terms(sharing, of_all, total_change[0][:, :, None]))
    if force.left is not None:
        left = (traction / total)[:, None] * force.left[:, None, :]
        terms = terms.plus(Terms(none, left, carrying.right_sides(force)))
    return terms
