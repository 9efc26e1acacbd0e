"""Elements of a slave that deforms, with their materials: given parts, and all the rest."""

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

KINDS = {
    "tetra": "tet4",
    "hexahedron": "hex8",
    "triangle": "tri3",
    "quad": "tri3",
    "line": "bar2",
}
"""Elements of a material, by the kind of a cell; quadrilaterals are split."""


class Filling(NamedTuple):
    """Material and sections of elements that are in no part."""

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

    Raises
    ------
    InputError
        No elements, cells that no element is known for, an element in two parts, elements of none
        that are made of nothing.
    """
    for part in parts:
        if part.elements.max(initial=0) >= len(slave):
            raise MeshError(
                "names points that the slave does not have",
                where=f"{where}: {part.name}",
                found=int(part.elements.max()),
                allowed=f"0 to {len(slave) - 1}",
            )
    _check_once(parts, where)
    by_kind = elements_by_kind(slave, where, needed=not parts)
    left = {kind: _without(rows, kind, parts) for kind, rows in by_kind.items()}
    left = {kind: rows for kind, rows in left.items() if len(rows)}
    if left and filling is None:
        raise InputError(
            "elements are in no part, and made of nothing",
            where=f"{where}: parts",
            found=", ".join(f"{len(rows)} {kind}" for kind, rows in left.items()),
            remedy="Give the motion a material and a density for them",
        )
    if filling is None:
        return [*parts]
    return [*parts, *(_filled(kind, rows, slave, filling, where) for kind, rows in left.items())]


def elements_by_kind(slave: Slave, where: str, *, needed: bool = True) -> dict[str, IntArray]:
    """Elements of a slave by their kind; of one of facets alone these, as membranes.

    Raises
    ------
    InputError
        None, where they are `needed`; cells that no element is known for.
    """
    cells = dict(slave.elements)
    if not cells and slave.facets is not None:
        cells = {"triangle": slave.facets}
    if not cells and needed:
        raise InputError(
            "a slave that deforms needs elements",
            where=where,
            found="a cloud",
            allowed="a mesh from read_mesh, Slave(elements=…), or facets as membranes",
        )
    unknown = [kind for kind in cells if kind not in KINDS]
    if unknown:
        raise InputError(
            "no element is known for these cells",
            where=where,
            found=", ".join(f"{len(cells[kind])} {kind}" for kind in unknown),
            allowed=", ".join(KINDS),
            remedy="Mesh it by linear tetrahedra or hexahedra, shells by triangles",
        )
    by_kind: dict[str, list[IntArray]] = {}
    for kind, rows in cells.items():
        by_kind.setdefault(KINDS[kind], []).append(split(slave, kind, rows))
    return {kind: np.concatenate(rows) for kind, rows in by_kind.items()}


def nodal_thickness(parts: Sequence[Part], n: int) -> FloatArray:
    """Return the mean thickness (n,) of the membranes around each node, zero without one."""
    total, count = np.zeros(n), np.zeros(n)
    for part in parts:
        if part.thickness is not None:
            corners = part.elements.ravel()
            count += np.bincount(corners, minlength=n)
            total += part.thickness * np.bincount(corners, minlength=n)
    mean = np.zeros(n)
    np.divide(total, count, out=mean, where=count > 0.0)
    return mean


def split(slave: Slave, kind: str, rows: IntArray) -> IntArray:
    """Cells as elements: quadrilaterals in two."""
    return split_shells(slave.points, kind, rows)[0] if kind == "quad" else rows


def same_elements(rows: IntArray, others: IntArray) -> NDArray[np.bool_]:
    """Return the mask (n,) of `rows` (n, k) that are among `others`, in any order of corners."""
    among = {row.tobytes() for row in np.sort(np.asarray(others, np.int32), axis=1)}
    ordered = np.sort(np.asarray(rows, np.int32), axis=1)
    return np.fromiter((row.tobytes() in among for row in ordered), np.bool_, len(rows))


def _check_once(parts: Sequence[Part], where: str) -> None:
    taken: dict[bytes, Part] = {}
    for part in parts:
        for k, row in enumerate(np.sort(part.elements, axis=1)):
            before = taken.setdefault(row.tobytes(), part)
            if before is not part:
                raise InputError(
                    f"element {k} of {part.name} is in {before.name}, too",
                    where=f"{where}: parts",
                    found=part.elements[k].tolist(),
                    allowed="each element in one part",
                )


def _without(rows: IntArray, kind: str, parts: Sequence[Part]) -> IntArray:
    """Elements that are in no part."""
    given = [part.elements for part in parts if part.kind == kind]
    if not given:
        return rows
    return np.asarray(rows[~same_elements(rows, np.concatenate(given))])


def _filled(kind: str, elements: IntArray, slave: Slave, filling: Filling, where: str) -> Part:
    if filling.density is None:
        raise InputError(
            "is missing: elements need it", where=f"{where}: density", allowed="mass / volume"
        )
    dimension = DIMENSION[kind]
    return Part(
        kind=kind,
        elements=elements,
        material=filling.material,
        density=filling.density,
        thickness=one_thickness(where, slave, filling.thickness) if dimension == 2 else None,
        section=filling.section if dimension == 1 else None,
        hourglass=filling.hourglass,
        bulk_viscosity=filling.bulk_viscosity if dimension == 3 else (0.0, 0.0),
        name=f"{where}: {kind}",
    )


def one_thickness(where: str, slave: Slave, given: float | None) -> float | None:
    """The thickness that was given, or that of the slave; None where there is none.

    Raises
    ------
    InputError
        That of the slave is not the same everywhere.
    """
    if given is not None or slave.thickness is None:
        return given
    known = slave.thickness[slave.thickness > 0.0]
    if len(known) == 0:
        return None
    if np.ptp(known) > 1e-9 * known.max():
        raise InputError(
            "the slave's thickness is not the same everywhere",
            where=f"{where}: thickness",
            found=f"{known.min():g} to {known.max():g}",
            allowed="one thickness for all, as Deforming(thickness=…)",
        )
    return float(known[0])
