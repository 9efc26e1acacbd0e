"""Describe a master whose control points move in a step."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from contiga.arrays.ordered import length, product, row_lengths
from contiga.errors import InputError
from contiga.geometry.faces import Faces
from contiga.geometry.net import NetMotion, net_of, spread
from contiga.masters.protocol import Master
from contiga.records import ByteArray, FloatArray, Hit, SurfacePlaces
from contiga.rigid import transform
from contiga.rigid.frames import cross, to_world
from contiga.search.deformable import Deformable, DeformedSurface, deformable_of

CARRY_ITERATIONS = 5
"""Fixed-point iterations that carry points; each reduces the error by a factor of half the angle
that the surface rotates by in the step."""
REGULAR = 1e-12
"""Relative regularisation of the moments of inertia, for points on a line."""


@dataclass(frozen=True, eq=False)
class Shape:
    """The shape of a master at the end of a step, and its change in the step; body axes."""

    body: Faces
    deformable: Deformable
    before: FloatArray
    """(m, 3) control points before the step; the present ones at the start."""
    now: FloatArray
    velocity: FloatArray | None = None
    """(m, 3) velocities of the control points; None if not given."""

    @cached_property
    def surface(self) -> DeformedSurface:
        """The search on the present surface."""
        return self.deformable.at(self.now)

    @cached_property
    def surface_before(self) -> DeformedSurface:
        """The search on the shape before the step, which few steps need."""
        return self.deformable.at(self.before)

    @property
    def change(self) -> FloatArray:
        """Displacements (m, 3) of the control points in the step."""
        return self.now - self.before

    @cached_property
    def rigid(self) -> FloatArray:
        """A rigid motion (4, 4) near that of the control points in the step, by 90° at most."""
        return rigid_part(self.before, self.now)

    @property
    def travel(self) -> float:
        """Upper bound of the distance of a surface point from its place by `rigid` alone, length.

        It is the largest distance of a control point, as their weights are positive.
        """
        return float(row_lengths(self.now - to_world(self.rigid, self.before)).max())

    def carried(self, feet: SurfacePlaces, points: FloatArray) -> FloatArray:
        """Return displacements of points (k, 3) carried along in the step, by present feet."""
        return NetMotion(self.body, self.now, self.change).carry(feet, points)

    def carried_before(self, feet: SurfacePlaces, points: FloatArray) -> FloatArray:
        """Return displacements of points carried along, by their feet before the step."""
        return NetMotion(self.body, self.before, self.change).carry(feet, points)

    def moved(self, feet: SurfacePlaces, points: FloatArray) -> FloatArray:
        """Return points (k, 3), given before the step, carried along rigidly with their feet.

        The distances from the feet stay the same.
        """
        half_way = NetMotion(self.body, 0.5 * (self.before + self.now), self.change)
        # x₁ − x₀ = δS + ω × (½ (x₀ + x₁) − S) is an exact rotation (Cayley), solved by iteration.
        out = points
        for _ in range(CARRY_ITERATIONS):
            out = points + half_way.carry(feet, 0.5 * (points + out))
        return out

    def turned(self, feet: SurfacePlaces, points: FloatArray, directions: FloatArray) -> FloatArray:
        """Return unit vectors `directions` (k, 3) at `points` (k, 3), turned with the surface.

        Both are given before the step; the surface turns at their feet.
        """
        rotated = self.moved(feet, points + directions) - self.moved(feet, points)
        return np.asarray(rotated / row_lengths(rotated)[:, None])

    def last_crossings(self, a_B: FloatArray, b_B: FloatArray) -> tuple[Hit, ByteArray]:
        """Return the last crossings of points from `a_B` to `b_B` as the surface changes."""
        return self.surface.last_crossings_from(self.surface_before, a_B, b_B)

    def velocities(self, feet: SurfacePlaces, points: FloatArray) -> FloatArray:
        """Return velocities (k, 3) of points (k, 3) carried along."""
        assert self.velocity is not None
        return NetMotion(self.body, self.now, self.velocity).carry(feet, points)

    def spread(self, feet: SurfacePlaces, points: FloatArray, forces: FloatArray) -> FloatArray:
        """Return forces (m, 3) on control points that replace `forces` (k, 3) at `points`."""
        return spread(self.body, self.now, feet, points, forces)


def rigid_part(before: FloatArray, now: FloatArray) -> FloatArray:
    """Return a rigid motion (4, 4) near that of points from `before` to `now` (m, 3).

    The motion of their centre, and the rotation of least squares to first order in its angle:
    Σ (r² − r rᵀ) ω = Σ r × δ. For a rotation about a principal axis |ω| is the sine of its angle.
    """
    arm, change = before.T.copy(), (now - before).T.copy()
    centre, shift = arm.mean(axis=1), change.mean(axis=1)
    arm -= centre[:, None]
    square, mixed = (np.einsum("im,jm->ij", arm, other) for other in (arm, change))
    x, y, z = (1.0 + REGULAR) * np.trace(square) * np.eye(3) - square
    adjugate = np.array([cross(y, z), cross(z, x), cross(x, y)])
    twice = mixed - mixed.T
    moment = [twice[1, 2], twice[2, 0], twice[0, 1]]
    turn = product(adjugate, moment) / product(x, adjugate[0])
    sine = length(turn)
    if sine == 0.0:
        return transform.translation(shift)
    about = transform.rotation(turn / sine, math.asin(min(sine, 1.0)), centre)
    return product(transform.translation(shift), about)


def shape_of(
    master: Master,
    follows_feet: bool,
    control_points: ArrayLike,
    before: FloatArray | None = None,
    velocity: ArrayLike | None = None,
) -> Shape:
    """Return the shape of a master with these control points, checked and copied.

    `before` are the control points before the step: an empty array stands for the master's own net,
    None, at the start, for `control_points`. `velocity` (m, 3) are the velocities of the control
    points, None if not given.

    Raises
    ------
    InputError
        A master without control points, a contact that follows feet, arrays of another shape than
        the master's net, `before` included, numbers that are not finite.
    GeometryError
        Patches that would not stay together.
    """
    body = master.faces
    if body is None:
        raise InputError(
            "a mesh has no control points",
            where="control_points",
            found=type(master).__name__,
            allowed="a master of NURBS patches",
        )
    if follows_feet:
        raise InputError(
            "feet are not followed over a surface that changes its shape",
            where="control_points",
            found='a contact with foot="tracked" or through="hold"',
            allowed='foot="nearest" and through="release", which are taken if nothing is said',
        )
    net, deformable = net_of(body), deformable_of(body)
    now = np.array(net.checked(control_points))
    rates = None if velocity is None else net.checked(velocity, "control_velocity")
    if before is None:
        before = now
    elif len(before) == 0:
        before = net.points
    elif len(before) != len(now):
        raise InputError(
            "the state belongs to another master",
            where="state.control_points",
            found=before.shape,
            allowed=str(now.shape),
        )
    return Shape(body, deformable, before, now, rates)
