"""Derivatives of contact forces over the control points of a master that deforms.

Let a point x have the foot S(u), with basis functions N_i and their surface gradients ∇N_i there,
the derivative H = dn/dx of the normal and the gap g. With the relative motion D = dx − Σ N_i dP_i
and the tilt W = Σ ∇N_i (n·dP_i) of the surface,

    dλ = −n·D,    dn = H D − T W,    dS = T (D + g W) along the surface,    T = 1 − n nᵀ − g H,

on faces, edges and at vertices. So the force f on a point changes by K (D + g W), where K is its
derivative over the point, minus its change by a rotation W of the normal. The force on a control
point is −N_i f, summed over the points; it changes by −N_i df − f (∇N_i·dS). Without friction and
rates, all of these are second derivatives of one energy, and symmetric. Two terms of friction are
neglected: the change of the slip by the rotation and stretch of the surface below a point within
the step, and the change of the friction couple about the foot with ∇N_i.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from contiga.arrays.ordered import row_products
from contiga.contact.friction_tangent import Terms
from contiga.geometry.net import Dependence
from contiga.records import FloatArray, IndexArray

if TYPE_CHECKING:
    from scipy.sparse import csr_array


class AtFeet(NamedTuple):
    """Forces and geometry of k points in contact, world axes."""

    force: FloatArray
    """(k, 3) contact forces on the points."""
    pressed: FloatArray
    """(k,) their normal parts."""
    traction: FloatArray
    """(k, 3) their friction parts."""
    normal: FloatArray
    """(k, 3) unit normals."""
    gap: FloatArray
    """(k,) signed distances to the surface itself, not to a shell's face; length."""
    turning: FloatArray
    """(k, 3, 3) derivatives H of the normals over the points, one over length."""
    places: Terms
    """Derivatives of the forces over the points."""
    turns: Terms
    """Derivatives of the forces over rotations of the normals alone."""
    shares: csr_array
    """(n, k) weights of the n nodes at the points."""


class ControlSlopes(NamedTuple):
    """The fields of `Linearisation` of the same names, world axes on the slave's side."""

    force_by_control: csr_array
    control_by_points: csr_array
    control_by_control: csr_array


def no_slopes(n: int) -> ControlSlopes:
    """Return empty derivatives, for a slave of n nodes and a master without control points."""
    from scipy.sparse import csr_array

    return ControlSlopes(csr_array((3 * n, 0)), csr_array((0, 3 * n)), csr_array((0, 0)))


def control_slopes(at: AtFeet, net: Dependence, axes: FloatArray, m: int) -> ControlSlopes:
    """Return the derivatives over m control points.

    Parameters
    ----------
    at : forces and geometry of the k points in contact
    net : dependence of their feet on the control points, body axes
    axes : (3, 3) rotation from body to world axes
    m : number of control points, whose coordinates are in body axes
    """
    from scipy.sparse import csr_array, eye_array, kron

    k, identity = len(at.gap), np.eye(3)
    normal_part = at.normal[:, :, None] * at.normal[:, None, :]
    gradient = np.einsum("ab,eb->ea", axes, net.gradient, optimize=False)
    tangential = gradient - np.einsum(
        "eab,eb->ea", normal_part[net.place], gradient, optimize=False
    )
    foot_motion = _diagonal(identity - normal_part - at.gap[:, None, None] * at.turning)
    gap, turning = _diagonal(at.gap[:, None, None] * identity), _diagonal(at.turning)
    stiffness = _matrix(at.places)

    def of_net(blocks: FloatArray) -> csr_array:
        """Return the (3 k, 3 m) matrix of blocks (e, 3, 3) at the entries of `net`."""
        return _blocks(net.place, net.control, blocks, (k, m))

    weights = of_net(net.value[:, None, None] * identity)
    tilts = of_net(tangential[:, :, None] * at.normal[net.place, None, :])
    force_gradients = of_net(gradient[:, :, None] * at.force[net.place, None, :])
    friction = row_products(tangential, at.traction[net.place])
    friction_gradients, couples = of_net(friction[:, None, None] * identity), gap @ tilts

    def control_forces(motion: csr_array, tilt: csr_array, force: csr_array) -> csr_array:
        """Return the derivatives of the forces on control points from the derivatives of D + g W,
        W and f over the same variables."""
        change = -(weights.T @ force) - force_gradients.T @ (foot_motion @ motion)
        if not at.traction.any():
            return csr_array(change)
        # Friction acts at points off the surface, so it adds a couple at their feet: g n (∇N_i·T).
        rotation = turning @ motion - tilt
        traction = force - _diagonal(at.pressed[:, None, None] * identity) @ rotation
        arm = _diagonal(normal_part) @ motion + gap @ rotation
        return csr_array(change + couples.T @ traction + friction_gradients.T @ arm)

    to_world = kron(eye_array(m), axes)
    tilt, nodes = tilts @ to_world, kron(at.shares, eye_array(3)).tocsr()
    motion = gap @ tilt - weights @ to_world
    force_by_control = stiffness @ motion - _matrix(at.turns) @ tilt
    no_tilt = csr_array((3 * k, nodes.shape[0]))
    return ControlSlopes(
        csr_array(nodes @ force_by_control),
        control_forces(nodes.T.tocsr(), no_tilt, stiffness @ nodes.T),
        control_forces(motion, tilt, force_by_control),
    )


def _diagonal(blocks: FloatArray) -> csr_array:
    """Return the (3 k, 3 k) matrix of diagonal blocks (k, 3, 3)."""
    each = np.arange(len(blocks))
    return _blocks(each, each, blocks, (len(each), len(each)))


def _blocks(
    rows: IndexArray, columns: IndexArray, blocks: FloatArray, shape: tuple[int, int]
) -> csr_array:
    """Return the sparse matrix of blocks (e, 3, 3) at block rows and columns (e,); `shape` counts
    blocks."""
    from scipy.sparse import coo_array

    a, b = np.divmod(np.arange(9), 3)
    entries = (3 * rows[:, None] + a).ravel(), (3 * columns[:, None] + b).ravel()
    return coo_array((blocks.ravel(), entries), shape=(3 * shape[0], 3 * shape[1])).tocsr()


def _matrix(terms: Terms) -> csr_array:
    """Return the (3 k, 3 k) matrix of terms at k points."""
    from scipy.sparse import csr_array

    k, matrix = len(terms.blocks), _diagonal(terms.blocks)
    if terms.left.shape[2] == 0:
        return matrix
    left, right = (csr_array(side.reshape(3 * k, -1)) for side in (terms.left, terms.right))
    return csr_array(matrix + left @ right.T)
