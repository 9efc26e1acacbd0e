"""Derivatives of contact forces over the control points of a master that deforms.

A point x with the foot S(u), N the basis functions there and ∇N their gradients along the surface:
with D = dx − Σ N_i dP_i, the turning H = dn/dx of the normal, the gap g and W = Σ ∇N_i (n·dP_i), by
which the surface tilts,

    dλ = −n·D,    dn = H D − T W,    dS = T (D + g W) along the surface,    T = 1 − n nᵀ − g H,

on faces, edges and at vertices alike. So the force of a point changes by K (D + g W) less what it
changes as the normal turns by W, where K is its derivative over the point. A control point feels
−Σ N_i f, which changes by −N_i df − f (∇N_i·dS). Without friction and rates all are the second
derivatives of one energy, and symmetric. Two parts are left out, both of friction: the way that it
sees, over what the surface turns and stretches below a point within the step, and how its couple
about the foot changes as ∇N does.
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
    """What k points in contact do, world axes."""

    force: FloatArray
    """(k, 3) on them."""
    pressed: FloatArray
    """(k,) the part of it along the normals."""
    traction: FloatArray
    """(k, 3) and that of friction."""
    normal: FloatArray
    """(k, 3)."""
    gap: FloatArray
    """(k,) to the surface itself, which shells with a thickness do not reach."""
    turning: FloatArray
    """(k, 3, 3) of the normals over the points, H."""
    places: Terms
    """Derivatives of the forces over the points."""
    turns: Terms
    """And as normals alone turn."""
    shares: csr_array
    """(n, k) of nodes at the points."""


class ControlSlopes(NamedTuple):
    """As of `Linearisation`, by the same names."""

    force_by_control: csr_array
    control_by_points: csr_array
    control_by_control: csr_array


def no_slopes(n: int) -> ControlSlopes:
    """Of a slave of n points and a master without control points."""
    from scipy.sparse import csr_array

    return ControlSlopes(csr_array((3 * n, 0)), csr_array((0, 3 * n)), csr_array((0, 0)))


def control_slopes(at: AtFeet, net: Dependence, axes: FloatArray, m: int) -> ControlSlopes:
    """Return the derivatives over m control points in body axes, which stand in the world as the
    columns of `axes` (3, 3)."""
    from scipy.sparse import csr_array, eye_array, kron

    k, one = len(at.gap), np.eye(3)
    upright = at.normal[:, :, None] * at.normal[:, None, :]
    gradient = np.einsum("ab,eb->ea", axes, net.gradient, optimize=False)
    level = gradient - np.einsum("eab,eb->ea", upright[net.place], gradient, optimize=False)
    slide = _diagonal(one - upright - at.gap[:, None, None] * at.turning)
    gap, turning = _diagonal(at.gap[:, None, None] * one), _diagonal(at.turning)
    stiffness = _matrix(at.places)

    def of_net(blocks: FloatArray) -> csr_array:
        """(3 k, 3 m) of blocks (e, 3, 3)."""
        return _blocks(net.place, net.control, blocks, (k, m))

    weights = of_net(net.value[:, None, None] * one)
    tilts = of_net(level[:, :, None] * at.normal[net.place, None, :])
    slides = of_net(gradient[:, :, None] * at.force[net.place, None, :])
    pulls = row_products(level, at.traction[net.place])
    pulled, couples = of_net(pulls[:, None, None] * one), gap @ tilts

    def felt(moves: csr_array, tilt: csr_array, force: csr_array) -> csr_array:
        """Derivatives of the forces on control points, where D + g W, W and forces on points have
        these."""
        change = -(weights.T @ force) - slides.T @ (slide @ moves)
        if not at.traction.any():
            return csr_array(change)
        # Friction acts at points beside the surface, by a couple at their feet: g n (∇N_i·T).
        turn = turning @ moves - tilt
        traction = force - _diagonal(at.pressed[:, None, None] * one) @ turn
        heights = _diagonal(upright) @ moves + gap @ turn
        return csr_array(change + couples.T @ traction + pulled.T @ heights)

    world = kron(eye_array(m), axes)
    tilt, points = tilts @ world, kron(at.shares, eye_array(3)).tocsr()
    moves = gap @ tilt - weights @ world
    by_control = stiffness @ moves - _matrix(at.turns) @ tilt
    still = csr_array((3 * k, points.shape[0]))
    return ControlSlopes(
        csr_array(points @ by_control),
        felt(points.T.tocsr(), still, stiffness @ points.T),
        felt(moves, tilt, by_control),
    )


def _diagonal(blocks: FloatArray) -> csr_array:
    """(3 k, 3 k) of blocks (k, 3, 3)."""
    each = np.arange(len(blocks))
    return _blocks(each, each, blocks, (len(each), len(each)))


def _blocks(
    rows: IndexArray, columns: IndexArray, blocks: FloatArray, shape: tuple[int, int]
) -> csr_array:
    """Sparse, of blocks (e, 3, 3) at places of a matrix of so many blocks."""
    from scipy.sparse import coo_array

    a, b = np.divmod(np.arange(9), 3)
    at = (3 * rows[:, None] + a).ravel(), (3 * columns[:, None] + b).ravel()
    return coo_array((blocks.ravel(), at), shape=(3 * shape[0], 3 * shape[1])).tocsr()


def _matrix(terms: Terms) -> csr_array:
    """(3 k, 3 k) of the points."""
    from scipy.sparse import csr_array

    k, matrix = len(terms.blocks), _diagonal(terms.blocks)
    if terms.left.shape[2] == 0:
        return matrix
    left, right = (csr_array(side.reshape(3 * k, -1)) for side in (terms.left, terms.right))
    return csr_array(matrix + left @ right.T)
