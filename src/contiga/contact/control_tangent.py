"""Derivatives of contact forces with respect to the control points of a master that deforms.

A force f on a point is carried by the surface at its foot: it is −f on the displacement there and
−M on its gradient, where M is the lever of the couple r × f about the foot (`foot_motion`). So the
force on a control point is −(N_i f + M ∇N_i), and changes by

    −N_i df − (dM + f τᵀ − M Lᵀ) ∇N_i − M (∇∇N_i) τ,

as values and gradients change with the shift τ of the foot, and gradients with the surface. Without
friction and rates, all derivatives are second ones of one energy, and symmetric.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from contiga.contact.foot_motion import Feet, FootMotion, cross, lever
from contiga.contact.friction_tangent import Terms
from contiga.records import FloatArray, IndexArray

if TYPE_CHECKING:
    from scipy.sparse import bsr_array, csr_array


class ControlSlopes(NamedTuple):
    """The fields of `Linearisation` of the same names."""

    force_by_control: csr_array
    control_by_points: csr_array
    control_by_control: csr_array


def no_slopes(n: int) -> ControlSlopes:
    """Return empty derivatives, for a slave of n nodes and a master without control points."""
    from scipy.sparse import csr_array

    return ControlSlopes(csr_array((3 * n, 0)), csr_array((0, 3 * n)), csr_array((0, 0)))


def control_slopes(
    feet: Feet,
    motion: FootMotion,
    force: FloatArray,
    terms: Terms,
    shares: csr_array,
    axes: FloatArray,
    m: int,
) -> ControlSlopes:
    """Return derivatives of forces with respect to control points, and of the forces on these.

    Parameters
    ----------
    feet : k points in contact and their feet
    motion : changes with all variables of each point
    force : (k, 3) contact forces on the points, body axes
    terms : derivatives of these with respect to all variables
    shares : (n, k) weights of the n nodes at the points
    axes : (3, 3) rotation from body to world axes
    m : number of control points
    """
    from scipy.sparse import csr_array, eye_array, kron

    k, nu, net = len(force), feet.net.normal[:, :, None], feet.net.entries
    couple = cross(feet.arm, force[:, :, None])
    M = lever(couple, nu, nu)
    change = lever(cross(motion.arm, force[:, :, None]), nu, nu)
    change += 2.0 * lever(couple, nu, motion.frame)
    change += force[:, :, None, None] * motion.shift[:, None]
    change -= np.einsum("kac,bcm->kabm", M[..., 0], motion.gradient, optimize=False)

    def on_surface(forces: FloatArray) -> FloatArray:
        """Return forces (k, 3, m) on the surface as (k, 12, m).

        They are on its displacement and on its gradient.
        """
        on_gradient = lever(cross(feet.arm, forces), nu, nu)
        return np.concatenate([forces, on_gradient.reshape(k, 9, forces.shape[2])], axis=1)

    blocks = on_surface(terms.blocks)
    blocks[:, 3:] += change.reshape(k, 9, change.shape[3])
    surface = Terms(blocks, on_surface(terms.left), terms.right)
    values = net.value[:, None, None] * np.eye(3)
    gradients = np.einsum("ac,eb->eabc", np.eye(3), net.gradient, optimize=False).reshape(-1, 9, 3)
    jets = _blocks(net.place, net.control, np.concatenate([values, gradients], axis=1), (k, m))
    bends = np.einsum("eab,ebc->eca", M[net.place, :, :, 0], net.hessian, optimize=False)
    bent = _blocks(net.place, net.control, bends, (k, m))
    jets_back, bent_back = jets.T, bent.T
    nodes, turn = kron(shares, axes), kron(eye_array(m), axes)

    def on_control(variables: slice, chain: bsr_array) -> csr_array:
        """Return the derivatives (3 m, c) of the forces on control points by the chain rule.

        `chain` are the derivatives of the `variables` of all points with respect to c unknowns.
        """
        shift = _diagonal(motion.shift[:, :, variables])
        change = jets_back @ _matrix(surface.over(variables), chain) + bent_back @ (shift @ chain)
        return csr_array(turn @ -change)

    of_points, of_surface = slice(0, 3), slice(3, None)
    return ControlSlopes(
        csr_array(nodes @ _matrix(terms.over(of_surface), jets)),
        on_control(of_points, nodes.T),
        on_control(of_surface, jets),
    )


def _diagonal(blocks: FloatArray) -> bsr_array:
    """Return the (p k, q k) matrix of diagonal blocks (k, p, q)."""
    each = np.arange(len(blocks))
    return _blocks(each, each, blocks, (len(each), len(each)))


def _blocks(
    rows: IndexArray, columns: IndexArray, blocks: FloatArray, shape: tuple[int, int]
) -> bsr_array:
    """Return the sparse matrix of blocks (e, p, q) at block rows, ascending, and columns (e,).

    `shape` counts blocks.
    """
    from scipy.sparse import bsr_array

    p, q = blocks.shape[1:]
    ends = np.searchsorted(rows, np.arange(shape[0] + 1))
    return bsr_array((blocks, columns, ends), shape=(p * shape[0], q * shape[1]))


def _matrix(terms: Terms, chain: bsr_array) -> bsr_array:
    """Return the derivatives (p k, c) of p forces a point by the chain rule, couplings included.

    `terms` are those with respect to m variables of each of k points, `chain` (m k, c) the
    derivatives of these with respect to c unknowns.
    """
    from scipy.sparse import csr_array

    matrix = _diagonal(terms.blocks) @ chain
    if terms.left.shape[2] == 0:
        return matrix
    left, right = (
        csr_array(side.reshape(side.shape[0] * side.shape[1], side.shape[2]))
        for side in (terms.left, terms.right)
    )
    return matrix + left @ (right.T @ chain)
