"""Assembly of nodes, elements and materials to matter."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from contiga.arrays.layout import as_points, not_negative, positive
from contiga.errors import InputError, MeshError
from contiga.matter.assembled import Assembled, Average, Group
from contiga.matter.blocks import block_sums, in_lanes, node_sums, nodes_in_lanes
from contiga.matter.kernels.solid_viscosity_nb import MEMORY
from contiga.matter.mass_scaling import added_to, lumped_masses, scaled
from contiga.matter.parts import Part, shapes_of
from contiga.matter.shapes import Shapes, hourglass_springs
from contiga.matter.skin import skin
from contiga.matter.tables import ElementTables
from contiga.records import FloatArray, IntArray


def assemble(
    nodes: ArrayLike,
    parts: Sequence[Part],
    *,
    damping: float = 0.0,
    facets: ArrayLike | None = None,
    lumped: ArrayLike | None = None,
    mass_scaling: float | None = None,
    free: ArrayLike | None = None,
) -> Assembled:
    """Return finite elements assembled as matter, at rest at `nodes`.

    Parameters
    ----------
    nodes : (m, 3) at rest, where elements carry no stress
    parts : elements with their materials
    damping : α ≥ 0 of a force −α m v on each node, 1/time
    facets : (f, 3) the skin for contact; the outer faces if omitted
    lumped : (m,) masses of nodes in addition to those of their elements, 0 or more
    mass_scaling : time; nodes get the mass with which the critical step at rest is not shorter
    free : (m,) bool, nodes that forces move: only these get added mass; all if omitted

    Raises
    ------
    InputError
        No part, a damping or mass below zero, a time that is not above zero.
    MeshError
        An element that is inside out or has no volume, a node that is in no element or not finite.

    Examples
    --------
    >>> from contiga.matter import Part, assemble
    >>> from contiga.materials import NeoHooke
    >>> rubber = NeoHooke(young=3.0, poisson=0.4)
    >>> nodes = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    >>> one = Part(kind="tet4", elements=np.array([[0, 1, 2, 3]]), material=rubber, density=6.0)
    >>> matter = assemble(nodes, [one])
    >>> matter.mass.tolist(), len(matter.facets)
    ([0.25, 0.25, 0.25, 0.25], 4)
    >>> longer = nodes * [1.0, 1.0, 1.1]
    >>> answer = matter.forces(matter.start(), longer, np.zeros((4, 3)), 0.0)
    >>> round(float(answer.force[3, 2]), 6), round(answer.energy.strain, 6)
    (-0.105519, 0.005302)
    """
    points = as_points(nodes, "nodes")
    n = len(points)
    is_finite = np.isfinite(points).all(axis=1)
    if not is_finite.all():
        row = int(np.argmin(is_finite))
        raise MeshError(f"node {row} is not finite", where="nodes", found=points[row].tolist())
    if not parts:
        raise InputError("matter needs a part", where="parts", allowed="at least one")
    shapes = [shapes_of(part, points) for part in parts]
    masses = np.empty((len(parts), n))
    for p, (part, at_rest) in enumerate(zip(parts, shapes, strict=True)):
        weights = (part.density * part.across * at_rest.shares).ravel()
        masses[p] = np.bincount(part.elements.ravel(), weights=weights, minlength=n)
    mass = masses.sum(axis=0)
    bare = np.flatnonzero(mass <= 0.0)
    if bare.size:
        row = int(bare[0])
        more = f", and {len(bare) - 1} more" if len(bare) > 1 else ""
        raise MeshError(
            f"node {row} is in no element and has no mass{more}",
            where="nodes",
            found=points[row].tolist(),
            remedy="Leave it out, or give it to a part",
        )
    if lumped is not None:
        mass = mass + lumped_masses(lumped, n)
    if facets is None:
        facets = skin([(part.kind, part.elements) for part in parts])
    facets = np.ascontiguousarray(facets, dtype=np.int32)
    groups: list[Group] = []
    nodes_of_rows: list[IntArray] = []
    first_row = first_memory = 0
    for part, at_rest in zip(parts, shapes, strict=True):
        group, nodes_of_group = _group(part, at_rest, points, first_row, first_memory)
        groups.append(group)
        nodes_of_rows.append(nodes_of_group)
        first_row, first_memory = group.rows.stop, group.memory.stop
    sums = node_sums(np.concatenate(nodes_of_rows), n)
    matter = Assembled(points.copy(), groups, sums, mass, facets, not_negative(damping, "damping"))
    if mass_scaling is not None:
        scaled_mass = scaled(matter, positive(mass_scaling, "mass_scaling"))
        matter.mass = scaled_mass if free is None else np.where(free, scaled_mass, mass)
        matter.added = added_to(parts, masses, matter.mass - mass)
    return matter


def _group(
    part: Part, shapes: Shapes, nodes: FloatArray, first_row: int, first_memory: int
) -> tuple[Group, IntArray]:
    """Return the group of a part, with its tables for kernels, and the node (r,) of each row.

    Rows and memory of the part begin at `first_row` and `first_memory`. With a change of volume
    that is averaged at nodes, `tables` have no λ of their own; `bound` keeps it.
    """
    sums, nodes_of_rows = block_sums(part.elements, len(nodes))
    coefficients = part.material.coefficients(part.kind, part.across)
    viscosity = np.zeros(0)
    if any(part.bulk_viscosity):
        linear, quadratic = part.bulk_viscosity
        wave_speed = np.sqrt(coefficients.wave_modulus / part.density)
        viscosity = np.array([linear * wave_speed, quadratic, part.density])
    springs = np.zeros((0, 0))
    if part.kind == "hex8":
        modulus = part.hourglass * coefficients.modulus
        rows_of_springs = hourglass_springs(nodes[part.elements], shapes, modulus)
        springs = in_lanes(rows_of_springs, np.zeros(24))
    tables = ElementTables(
        nodes_in_lanes(part.elements),
        in_lanes(shapes.gradients),
        in_lanes(shapes.measures[:, None], np.zeros(1)),
        coefficients.material,
        coefficients.numbers,
        coefficients.curves,
        coefficients.tangent,
        springs,
        viscosity,
        in_lanes(np.cbrt(shapes.measures)[:, None]),
        0,
        sums,
    )
    rows = slice(first_row, first_row + len(nodes_of_rows))
    n_memory = coefficients.memory + (MEMORY if viscosity.size else 0)
    memory = slice(first_memory, first_memory + tables.measures.size * n_memory)
    bound, average = tables, None
    if coefficients.averaged:
        tables = tables._replace(numbers=coefficients.numbers * [1.0, 0.0], averaged=1)
        corners, weights = part.elements.ravel(), shapes.shares.ravel()
        volumes = np.bincount(corners, weights=weights, minlength=len(nodes)).astype(np.float64)
        average = Average(coefficients.averaged, volumes, node_sums(nodes_of_rows, len(nodes)))
    group = Group(
        part.name,
        part.kind,
        part.elements,
        tables,
        bound,
        average,
        rows,
        memory,
        part.across,
        coefficients.reaches,
    )
    return group, nodes_of_rows
