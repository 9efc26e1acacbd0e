"""Stresses of elements, from the forces on their corners.

In an element of volume v, Σ_a f_a ⊗ x_a = −v σ over its corners: exactly for linear elements, and
with the mean stress for hexahedra. So materials need no kernel for stresses: the kernels of forces
are called with elements that share no nodes.
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
    """Elements that share no nodes: each has corners of its own."""

    corners: IntArray
    """(e · k,) node of each corner."""
    tables: ElementTables
    rows: IntArray
    """(r,) corner of each row of sums."""
    gradients: FloatArray
    """(e, k, 3) of the corners' shape functions at rest."""
    rest_metric: FloatArray
    """(e, 3, 3) `metric` of the corners at rest."""


def apart(
    elements: IntArray, tables: ElementTables, gradients: FloatArray, rest_metric: FloatArray
) -> Apart:
    """Return the elements of a group with separate corners."""
    corners = np.arange(elements.size, dtype=np.int32).reshape(elements.shape)
    sums, rows = block_sums(corners, elements.size)
    tables_apart = tables._replace(nodes=nodes_in_lanes(corners), sums=sums)
    return Apart(elements.ravel(), tables_apart, rows, gradients, rest_metric)


def cauchy(kind: str, corners: FloatArray, forces: FloatArray, across: float) -> FloatArray:
    """Return the stresses (e, 6) of elements with corners (e, k, 3) and forces (e, k, 3) on them.

    The antisymmetric part, which is rounding, is left out.
    Stresses of membranes and bars are by the thickness or section `across` at rest; elements
    without area or length have zero stress.
    """
    centre = corners.mean(axis=1, keepdims=True)
    moments = -np.einsum("eai,eaj->eij", forces, corners - centre)
    volumes = (measures(kind, corners) * across)[:, None, None]
    stress = np.divide(moments, volumes, out=np.zeros_like(moments), where=volumes > 0.0)
    return np.stack([0.5 * (stress[:, i, j] + stress[:, j, i]) for i, j in COMPONENTS], axis=1)


def von_mises(stress: FloatArray) -> FloatArray:
    """Return von Mises' stress (n,) of stresses (n, 6).

    >>> von_mises(np.array([[2.0, 0, 0, 0, 0, 0], [0, 0, 0, 1.0, 0, 0]])).round(6).tolist()
    [2.0, 1.732051]
    """
    x, y, z, xy, yz, xz = stress.T
    shear = xy * xy + yz * yz + xz * xz
    return np.asarray(np.sqrt(0.5 * ((x - y) ** 2 + (y - z) ** 2 + (z - x) ** 2) + 3.0 * shear))
