"""Derivatives of contact forces over the control points of a master that deforms.

A point x with the foot S(u), N the basis functions there and ∇N their gradients along the surface:
with D = dx − Σ N_i dP_i, the turning H = dn/dx of the normal, the gap g and W = Σ ∇N_i (n·dP_i), by
which the surface tilts,

    dλ = −n·D,    dn = H D − T W,    dS = T (D + g W) along the surface,    T = 1 − n nᵀ − g H,

on faces, edges and at vertices alike. So the force of a point changes by K (D + g W) less what it
changes as the normal turns by W, where K is its derivative over the point. A control point feels
−Σ N_i f, which changes by −N_i df − f (∇N_i·dS). Without friction and rates all are the second
derivatives of one energy, and symmetric. How the surface turns and stretches below a point within
the step changes the way that friction sees; that part is left out.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from contiga.contact.friction_tangent import Terms
from contiga.geometry.net import Dependence
from contiga.records import FloatArray, IndexArray

if TYPE_CHECKING:
    from scipy.sparse import csr_array


class AtFeet(NamedTuple):
    """What k points in contact do, world axes."""

    force: FloatArray
    """(k, 3) on them."""
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

    k = len(at.gap)
    across = np.eye(3) - at.normal[:, :, None] * at.normal[:, None, :]
    normal, gap = at.normal[net.place], at.gap[net.place, None, None]
    gradient = np.einsum("ab,eb->ea", axes, net.gradient, optimize=False)
    level = np.einsum("eab,eb->ea", across[net.place], gradient, optimize=False)
    tilt = level[:, :, None] * normal[:, None, :]
    carried = gap * tilt - net.value[:, None, None] * np.eye(3)
    own = _blocks(np.arange(k), np.arange(k), across - at.gap[:, None, None] * at.turning, (k, k))
    points, place = kron(at.shares, eye_array(3)).tocsr(), (net.place, net.control)
    world = kron(eye_array(m), axes)
    tilts = _blocks(*place, tilt, (k, m)) @ world
    moves = _blocks(*place, carried, (k, m)) @ world  # D + g W
    weights = _blocks(*place, net.value[:, None, None] * np.eye(3), (k, m))
    slides = _blocks(*place, gradient[:, :, None] * at.force[net.place, None, :], (k, m))
    stiffness = _matrix(at.places)
    by_control = stiffness @ moves - _matrix(at.turns) @ tilts
    by_points = stiffness @ points.T
    along = slides.T @ own
    return ControlSlopes(
        csr_array(points @ by_control),
        csr_array(-(weights.T @ by_points) - along @ points.T),
        csr_array(-(weights.T @ by_control) - along @ moves),
    )


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

    k, each = len(terms.blocks), np.arange(len(terms.blocks))
    matrix = _blocks(each, each, terms.blocks, (k, k))
    if terms.left.shape[2] == 0:
        return matrix
    left, right = (csr_array(side.reshape(3 * k, -1)) for side in (terms.left, terms.right))
    return csr_array(matrix + left @ right.T)
