"""Stresses of elements, from the forces on their corners.

What stress does in an element of volume v is Σ_a f_a ⊗ x_a = −v σ over its corners, for linear
elements exactly and for hexahedra of their mean stress. So every material has them without a kernel
of its own: the same kernels are asked for the same elements taken apart.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contiga.matter.blocks import block_sums, nodes_in_lanes
from contiga.matter.shapes import measures
from contiga.matter.tables import ElementTables
from contiga.records import FloatArray, IntArray

COMPONENTS = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))
"""xx, yy, zz, xy, yz, xz: the order of ParaView."""


class Apart(NamedTuple):
    """Elements that share no node: each has corners of its own."""

    corners: IntArray
    """(e · k,) node of each corner."""
    tables: ElementTables
    rows: IntArray
    """(r,) corner of each row of sums."""
    gradients: FloatArray
    """(e, k, 3) of the corners' shape functions at rest."""
    still: FloatArray
    """(e, 3, 3) their `metric` at rest."""


def apart(
    elements: IntArray, tables: ElementTables, gradients: FloatArray, still: FloatArray
) -> Apart:
    """Return the elements of a group, taken apart."""
    corners = np.arange(elements.size, dtype=np.int32).reshape(elements.shape)
    sums, rows = block_sums(corners, elements.size)
    tables_apart = tables._replace(nodes=nodes_in_lanes(corners), sums=sums)
    return Apart(elements.ravel(), tables_apart, rows, gradients, still)


def cauchy(kind: str, corners: FloatArray, forces: FloatArray, across: float) -> FloatArray:
    """Return the stresses (e, 6) of elements with corners (e, k, 3) and forces (e, k, 3) on them.

    Of membranes and bars by the thickness or section `across` that they have at rest; zero of those
    that have no area or length left.
    """
    middle = corners.mean(axis=1, keepdims=True)
    moments = -np.einsum("eai,eaj->eij", forces, corners - middle)
    volumes = measures(kind, corners) * across
    left = (volumes > 0.0)[:, None, None]
    whole = np.divide(moments, volumes[:, None, None], out=np.zeros_like(moments), where=left)
    return np.stack([0.5 * (whole[:, i, j] + whole[:, j, i]) for i, j in COMPONENTS], axis=1)


def von_mises(stress: FloatArray) -> FloatArray:
    """Return von Mises' stress (n,) of stresses (n, 6).

    >>> von_mises(np.array([[2.0, 0, 0, 0, 0, 0], [0, 0, 0, 1.0, 0, 0]])).round(6).tolist()
    [2.0, 1.732051]
    """
    x, y, z, xy, yz, xz = stress.T
    shear = xy * xy + yz * yz + xz * xz
    return np.asarray(np.sqrt(0.5 * ((x - y) ** 2 + (y - z) ** 2 + (z - x) ** 2) + 3.0 * shear))
