"""Elements of a slave that deforms, with their materials: given parts, and all other elements."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.errors import InputError, MeshError
from contiga.matter.coefficients import Material
from contiga.matter.parts import DIMENSION, Part
from contiga.records import FloatArray, IntArray
from contiga.slaves.cells import split_shells
from contiga.slaves.slave import Slave

ELEMENT_OF_CELL = {
    "tetra": "tet4",
    "hexahedron": "hex8",
    "triangle": "tri3",
    "quad": "tri3",
    "line": "bar2",
}
"""Kind of element for each kind of cell; quadrilaterals are split."""


class Filling(NamedTuple):
    """Material and sections of the elements that are in no part."""

    material: Material
    density: float | None
    thickness: float | None
    section: float | None
    hourglass: float
    bulk_viscosity: tuple[float, float]


def parts_of(
    slave: Slave, parts: Sequence[Part], filling: Filling | None, where: str
) -> list[Part]:
    """Return all parts of a slave, their elements as rows of its points.

    The given parts come first, then one a kind for the elements in no part, of the `filling`.

    Raises
    ------
    InputError
        No elements, cells of a kind without an element, an element in two parts, elements in no
        part without a `filling` or its density.
    MeshError
        A part with points that the slave does not have.
    """
    for part in parts:
        if part.elements.max(initial=0) >= len(slave):
            raise MeshError(
                "names points that the slave does not have",
                where=f"{where}: {part.name}",
                found=int(part.elements.max()),
                allowed=f"0 to {len(slave) - 1}",
            )
    part_of_element: dict[bytes, Part] = {}
    for part in parts:
        for k, row in enumerate(np.sort(part.elements, axis=1)):
            before = part_of_element.setdefault(row.tobytes(), part)
            if before is not part:
                raise InputError(
                    f"element {k} of {part.name} is in {before.name}, too",
                    where=f"{where}: parts",
                    found=part.elements[k].tolist(),
                    allowed="each element in one part",
                )
    by_kind = elements_by_kind(slave, where, required=not parts)
    for kind, elements in by_kind.items():
        in_parts = [part.elements for part in parts if part.kind == kind]
        if in_parts:
            by_kind[kind] = elements[~same_elements(elements, np.concatenate(in_parts))]
    by_kind = {kind: elements for kind, elements in by_kind.items() if len(elements)}
    if not by_kind:
        return [*parts]
    if filling is None:
        raise InputError(
            "elements are in no part, and made of nothing",
            where=f"{where}: parts",
            found=", ".join(f"{len(elements)} {kind}" for kind, elements in by_kind.items()),
            remedy="Give the motion a material and a density for them",
        )
    if filling.density is None:
        raise InputError(
            "is missing: elements need it", where=f"{where}: density", allowed="mass / volume"
        )
    filled = []
    for kind, elements in by_kind.items():
        dimension = DIMENSION[kind]
        thickness = uniform_thickness(where, slave, filling.thickness) if dimension == 2 else None
        filled.append(
            Part(
                kind=kind,
                elements=elements,
                material=filling.material,
                density=filling.density,
                thickness=thickness,
                section=filling.section if dimension == 1 else None,
                hourglass=filling.hourglass,
                bulk_viscosity=filling.bulk_viscosity if dimension == 3 else (0.0, 0.0),
                name=f"{where}: {kind}",
            )
        )
    return [*parts, *filled]


def elements_by_kind(slave: Slave, where: str, *, required: bool = True) -> dict[str, IntArray]:
    """Return the elements of a slave by their kind; without cells its facets, as membranes.

    Quadrilaterals are split into two triangles, which follow the triangles or precede them in the
    order of the cells.

    Raises
    ------
    InputError
        No elements though they are `required`; cells of a kind without an element.
    """
    cells = dict(slave.elements)
    if not cells and slave.facets is not None:
        cells = {"triangle": slave.facets}
    if not cells and required:
        raise InputError(
            "a slave that deforms needs elements",
            where=where,
            found="a cloud",
            allowed="a mesh from read_mesh, Slave(elements=…), or facets as membranes",
        )
    unknown = [kind for kind in cells if kind not in ELEMENT_OF_CELL]
    if unknown:
        raise InputError(
            "no element is known for these cells",
            where=where,
            found=", ".join(f"{len(cells[kind])} {kind}" for kind in unknown),
            allowed=", ".join(ELEMENT_OF_CELL),
            remedy="Mesh it by linear tetrahedra or hexahedra, shells by triangles",
        )
    by_kind: dict[str, list[IntArray]] = {}
    for kind, rows in cells.items():
        by_kind.setdefault(ELEMENT_OF_CELL[kind], []).append(split(slave, kind, rows))
    return {kind: np.concatenate(rows) for kind, rows in by_kind.items()}


def nodal_thickness(parts: Sequence[Part], n: int) -> FloatArray:
    """Return the mean thickness (n,) of the membranes around each node, zero without one."""
    total, count = np.zeros(n), np.zeros(n)
    for part in parts:
        if part.thickness is not None:
            elements_at_nodes = np.bincount(part.elements.ravel(), minlength=n)
            count += elements_at_nodes
            total += part.thickness * elements_at_nodes
    mean = np.zeros(n)
    np.divide(total, count, out=mean, where=count > 0.0)
    return mean


def split(slave: Slave, kind: str, rows: IntArray) -> IntArray:
    """Return cells as elements: quadrilaterals as two triangles each."""
    return split_shells(slave.points, kind, rows)[0] if kind == "quad" else rows


def same_elements(rows: IntArray, others: IntArray) -> NDArray[np.bool_]:
    """Return the mask (n,) of `rows` (n, k) that are in `others`, in any order of corners."""
    keys = {row.tobytes() for row in np.sort(np.asarray(others, np.int32), axis=1)}
    ordered = np.sort(np.asarray(rows, np.int32), axis=1)
    return np.fromiter((row.tobytes() in keys for row in ordered), np.bool_, len(rows))


def uniform_thickness(where: str, slave: Slave, thickness: float | None) -> float | None:
    """Return `thickness`, or the slave's if it is None; None if neither has one.

    Raises
    ------
    InputError
        The thickness of the slave differs by more than 1e-9 of itself between points; those
        without one, 0, do not count.
    """
    if thickness is not None or slave.thickness is None:
        return thickness
    positive = slave.thickness[slave.thickness > 0.0]
    if len(positive) == 0:
        return None
    if np.ptp(positive) > 1e-9 * positive.max():
        raise InputError(
            "the slave's thickness is not the same everywhere",
            where=f"{where}: thickness",
            found=f"{positive.min():g} to {positive.max():g}",
            allowed="one thickness for all, as Deforming(thickness=…)",
        )
    return float(positive[0])
