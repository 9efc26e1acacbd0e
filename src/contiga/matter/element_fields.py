"""Stress, strain and stored energy of elements, and their means at nodes.

Materials need no kernels of their own for these fields: the kernels of a step compute the corner
forces and the energies of elements that share no nodes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from contiga.matter.strain import largest_principal
from contiga.matter.stress import von_mises
from contiga.records import FloatArray, IntArray


class ElementFields(NamedTuple):
    """Stress, strain and stored energy of n elements of one kind, or of n nodes."""

    stress: FloatArray
    """(n, 6) Cauchy stress xx, yy, zz, xy, yz, xz, with rates of foam, without bulk viscosity."""
    strain: FloatArray
    """(n, 6) Green strain in the same order, in the axes of the undeformed matter."""
    energy_density: FloatArray
    """(n,) stored energy by volume at rest, including that of hourglass springs."""


FIELDS: dict[str, Callable[[ElementFields], FloatArray]] = {
    "stress": lambda fields: fields.stress,
    "von_mises": lambda fields: von_mises(fields.stress),
    "strain": lambda fields: fields.strain,
    "principal_strain": lambda fields: largest_principal(fields.strain),
    "energy_density": lambda fields: fields.energy_density,
}
"""Fields that files may have, by name."""
TENSORS = ("stress", "strain")


class KindFields(NamedTuple):
    """Elements of one kind and their fields."""

    elements: IntArray
    """(e, k) rows of the nodes."""
    volumes: FloatArray
    """(e,) at rest; area × thickness for membranes, length × section for bars."""
    fields: ElementFields


class LargestStrain(NamedTuple):
    """The largest strain of a table of a part since the start."""

    part: str
    what: str
    """Name of its strain for messages."""
    strain: float
    end: float
    """Strain of the table's last row."""


def at_nodes(groups: Sequence[KindFields], count: int) -> ElementFields:
    """Return the mean fields of the elements at each of `count` nodes, weighted by rest volume.

    They are NaN at nodes without elements.
    """
    weight = np.zeros(count)
    sums = np.zeros((count, 13))
    for group in groups:
        corners, k = group.elements.ravel(), group.elements.shape[1]
        volumes = np.repeat(group.volumes, k)
        weight += np.bincount(corners, volumes, minlength=count)
        columns = np.column_stack(group.fields)
        for c in range(sums.shape[1]):
            share = np.repeat(columns[:, c], k) * volumes
            sums[:, c] += np.bincount(corners, share, minlength=count)
    with np.errstate(invalid="ignore"):
        means = sums / weight[:, None]
    return ElementFields(means[:, :6], means[:, 6:12], means[:, 12])


def at_facets(groups: Sequence[KindFields], facets: IntArray) -> ElementFields:
    """Return for each of the facets (f, 3) the fields of the first element with all its corners.

    They are NaN without such an element. Groups come in their order, elements of a group by number.
    """
    values = np.full((len(facets), 13), np.nan)
    count = 1 + int(facets.max(initial=-1))
    is_missing = np.ones(len(facets), np.bool_)
    for group in groups:
        count = max(count, 1 + int(group.elements.max(initial=-1)))
        shared = _incidence(facets, count) @ _incidence(group.elements, count).T
        shared = shared.tocoo()
        matches = (shared.data == 3) & is_missing[shared.row]
        rows, first = np.unique(shared.row[matches], return_index=True)
        values[rows] = np.column_stack(group.fields)[shared.col[matches][first]]
        is_missing[rows] = False
    return ElementFields(values[:, :6], values[:, 6:12], values[:, 12])


def _incidence(rows: IntArray, count: int) -> Any:
    """Return the sparse matrix (n, count) that is 1 at the nodes of each row (n, k)."""
    from scipy.sparse import csr_array

    n, k = rows.shape
    data = np.ones(rows.size, np.int32)
    return csr_array((data, rows.ravel(), np.arange(0, rows.size + 1, k)), shape=(n, count))
