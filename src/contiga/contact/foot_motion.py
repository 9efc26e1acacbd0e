"""Derive the motion of a point's foot on a master that deforms: the chain rule for derivatives.

A point sees of the master no more than the motion of its surface at the foot S: the displacement
s = Σ N_i dP_i and its gradient L = Σ dP_i ⊗ ∇N_i, with the basis functions N_i of the control
points P_i and their gradients ∇N_i along the surface. So all changes are linear in the 15 variables
(dx, s, L) of a point x. With the normal n of contact, its derivative H = dn/dx, the gap g and
T = 1 − n nᵀ − g H,

    D = dx − s,    dn = H D − T Lᵀn,    τ = T (D + g Lᵀn),    dr = D − τ

on faces, edges and at vertices, where τ is the shift of the foot along the surface and r = x − S.
The normal ν of the surface, which is n on faces, changes by −Lᵀν − B τ, with the shape operator B.

The surface carries a point along (`contiga.geometry.kernels.net_nb`) by δ = Σ N_i ΔP_i + ω × r,
where the spin ω(E) is linear in the gradient E = Σ ΔP_i ⊗ ∇N_i of the change ΔP and quadratic in ν.
Gradients change by d∇N_i = (∇∇N_i) τ − Lᵀ∇N_i, but for a part along ν, which no spin depends on.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contiga.contact.friction_tangent import InputChange
from contiga.contact.shape import Shape
from contiga.geometry.net import Dependence, Jet
from contiga.records import FloatArray, FootSlopes

VARIABLES = 15
"""Variables of a point: dx (3), s (3) and the rows of L (3, 3)."""


class Feet(NamedTuple):
    """k points in contact and their feet on the surface of a master that deforms, body axes."""

    normal: FloatArray
    """(k, 3) unit normals of contact."""
    gap: FloatArray
    """(k,) signed distances to the surface itself, not to a shell's face; length."""
    slopes: FootSlopes
    """Derivatives of depths and normals with respect to the points."""
    net: Dependence
    """Dependence of the feet on the control points."""
    curvature: FloatArray
    """(k, 3, 3) shape operators of the surface, one over length."""

    @property
    def arm(self) -> FloatArray:
        """Arms (k, 3, 1) from the feet to the points."""
        return (self.gap[:, None] * self.normal)[:, :, None]


class FootMotion(NamedTuple):
    """Changes at k feet with the first m of the variables of each point; body axes."""

    displacement: FloatArray
    """(3, m) of the surface below the point."""
    gradient: FloatArray
    """(3, 3, m) of that displacement."""
    depth: FloatArray
    """(k, m) of the penetration."""
    normal: FloatArray
    """(k, 3, m) of the unit normal of contact."""
    shift: FloatArray
    """(k, 3, m) of the foot along the surface."""
    arm: FloatArray
    """(k, 3, m) of the arm from the foot to the point."""
    frame: FloatArray
    """(k, 3, m) of the unit normal of the surface."""


def foot_motion(feet: Feet, m: int) -> FootMotion:
    """Return the changes with the first m variables: 3, of points alone, or all 15."""
    variables = np.eye(VARIABLES, m)
    s, L = variables[3:6], variables[6:].reshape(3, 3, m)
    D, n, H, gap = variables[:3] - s, feet.normal, feet.slopes.normal, feet.gap[:, None, None]
    T = np.eye(3) - n[:, :, None] * n[:, None, :] - gap * H
    tilt = np.einsum("ka,abm->kbm", n, L, optimize=False)
    shift = multiplied(T, D + gap * tilt)
    tilted = np.einsum("ka,abm->kbm", feet.net.normal, L, optimize=False)
    return FootMotion(
        displacement=s,
        gradient=L,
        depth=np.einsum("ka,am->km", feet.slopes.depth, D, optimize=False),
        normal=np.einsum("kab,bm->kam", H, D, optimize=False) - multiplied(T, tilt),
        shift=shift,
        arm=D - shift,
        frame=-tilted - multiplied(feet.curvature, shift),
    )


def input_change(feet: Feet, motion: FootMotion, shape: Shape) -> InputChange:
    """Return the changes of the input of laws and friction with the variables of `motion`.

    Velocities have no rows if the velocities of the control points are not given.
    """
    m = motion.depth.shape[1]
    path = np.eye(3, m) - _carried(feet, motion, feet.net.jet(shape.change), follows=True)
    velocity = np.zeros((0, 3, m))
    if shape.velocity is not None:
        velocity = -_carried(feet, motion, feet.net.jet(shape.velocity), follows=False)
    changes = motion.depth, motion.normal, path, velocity
    return InputChange(*map(np.ascontiguousarray, changes))  # einsum may choose another order


def _carried(feet: Feet, motion: FootMotion, jet: Jet, *, follows: bool) -> FloatArray:
    """Return the changes (k, 3, m) of the displacements or velocities of points carried along.

    `jet` is that of the displacements of the control points in the step, or of their velocities.
    The displacements change with the control points, hence `follows`; given velocities do not.
    """
    E, factor, nu = jet.gradient, float(follows), feet.net.normal[:, :, None]
    turned = factor * motion.gradient - np.einsum(
        "kab,bcm->kacm", E, motion.gradient, optimize=False
    )
    turned += np.einsum("kabc,kcm->kabm", jet.hessian, motion.shift, optimize=False)
    turning = spin(E[..., None], nu, nu)
    change = spin(turned, nu, nu) + 2.0 * spin(E[..., None], nu, motion.frame)
    carried = factor * motion.displacement + multiplied(E, motion.shift)
    return np.asarray(carried + cross(change, feet.arm) + cross(turning, motion.arm))


def spin(E: FloatArray, a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the bilinear map (k, 3, m) of a and b (k, 3, m), symmetric in both.

    With the unit normal ν for both it is the spin (Eᵀν) × ν + ½ ν (ν·curl E) of a surface whose
    displacement has the gradients E (k, 3, 3, m).
    """
    curl = np.stack([E[:, c - 1, c - 2] - E[:, c - 2, c - 1] for c in range(3)], axis=1)
    along_a, along_b = (np.einsum("kabm,kam->kbm", E, v, optimize=False) for v in (a, b))
    tilt = cross(along_a, b) + cross(along_b, a)
    return np.asarray(0.5 * tilt + 0.25 * (a * _dot(b, curl) + b * _dot(a, curl)))


def lever(c: FloatArray, a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the transpose (k, 3, 3, m) of `spin`.

    The result does the same work on the gradients E as a couple c (k, 3, m) on their spin.
    """
    parts = []
    for first, second in ((a, b), (b, a)):
        parts.append(first[:, :, None] * cross(second, c)[:, None])
        x, y, z = np.moveaxis(0.5 * _dot(first, c) * second, 1, 0)
        zero = np.zeros(x.shape)
        parts.append(np.stack([[zero, -z, y], [z, zero, -x], [-y, x, zero]]).transpose(2, 0, 1, 3))
    return np.asarray(0.5 * sum(parts))


def multiplied(matrices: FloatArray, vectors: FloatArray) -> FloatArray:
    """Return the products (k, 3, m) of matrices (k, 3, 3) and vectors (k, 3, m)."""
    return np.asarray(np.einsum("kab,kbm->kam", matrices, vectors, optimize=False))


def cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the cross products (k, 3, m) of vectors."""
    return np.asarray(np.cross(a, b, axis=1))


def _dot(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the scalar products (k, 1, m) of vectors (k, 3, m)."""
    return a[:, :1] * b[:, :1] + a[:, 1:2] * b[:, 1:2] + a[:, 2:] * b[:, 2:]
