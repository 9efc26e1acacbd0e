"""Assembly of nodes, elements and materials to matter."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from contiga.arrays.layout import as_points, not_negative, positive, real
from contiga.errors import InputError, MeshError
from contiga.matter.assembled import Assembled, Average, Group
from contiga.matter.blocks import NodeSums, block_sums, in_lanes, node_sums, nodes_in_lanes
from contiga.matter.kernels.solid_viscosity_nb import MEMORY
from contiga.matter.mass_scaling import added_to, scaled
from contiga.matter.parts import Part, shapes_of
from contiga.matter.shapes import Shapes, hourglass_modes
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
    """Assemble finite elements to matter.

    Parameters
    ----------
    nodes : (m, 3) at rest, where elements carry no stress
    parts : elements with their materials
    damping : α ≥ 0 of a force −α m v on each node, 1/time
    facets : (f, 3) the skin that contact sees; the outer faces if omitted
    lumped : (m,) masses that nodes have beside those of their elements, 0 or more
    mass_scaling : time; nodes get so much mass that the critical step at rest is no shorter
    free : (m,) bool, nodes that forces move: only these get more; all if omitted

    Raises
    ------
    InputError
        No part, a damping or mass below zero, a time that is not above zero.
    MeshError
        An element that is inside out or has no volume, a node that is in no element.

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
    points = _finite(nodes)
    if not parts:
        raise InputError("matter needs a part", where="parts", allowed="at least one")
    shapes = [shapes_of(part, points) for part in parts]
    masses = np.stack([_masses(*each, len(points)) for each in zip(parts, shapes, strict=True)])
    mass = masses.sum(axis=0)
    _check_mass(points, mass)
    if lumped is not None:
        mass = mass + _lumped(lumped, len(points))
    outer = skin([(part.kind, part.elements) for part in parts])
    given = outer if facets is None else np.ascontiguousarray(facets, dtype=np.int32)
    groups, sums = _groups(parts, shapes, points)
    matter = Assembled(points.copy(), groups, sums, mass, given, not_negative(damping, "damping"))
    if mass_scaling is not None:
        heavy = scaled(matter, positive(mass_scaling, "mass_scaling"))
        matter.mass = heavy if free is None else np.where(free, heavy, mass)
        matter.added = added_to(parts, masses, matter.mass - mass)
    return matter


def _masses(part: Part, shapes: Shapes, n: int) -> FloatArray:
    """Return the masses (n,) of a part at the nodes."""
    weights = (part.density * part.across * shapes.shares).ravel()
    shares = np.bincount(part.elements.ravel(), weights=weights, minlength=n)
    return shares.astype(np.float64)


def _lumped(given: ArrayLike, n: int) -> FloatArray:
    """Return the masses (n,) on nodes, checked."""
    lumped = np.asarray(real(given, "lumped"), dtype=np.float64)
    if lumped.shape != (n,) or not (np.isfinite(lumped) & (lumped >= 0.0)).all():
        raise InputError(
            "must be masses of the nodes, 0 or more",
            where="lumped",
            found=f"shape {lumped.shape}, from {lumped.min(initial=np.inf):g}",
            allowed=f"({n},)",
        )
    return lumped


def _finite(nodes: ArrayLike) -> FloatArray:
    points = as_points(nodes, "nodes")
    if not np.isfinite(points).all():
        row = int(np.flatnonzero(~np.isfinite(points).all(axis=1))[0])
        raise MeshError(f"node {row} is not finite", where="nodes", found=points[row].tolist())
    return points


def _groups(
    parts: Sequence[Part], shapes: Sequence[Shapes], nodes: FloatArray
) -> tuple[list[Group], NodeSums]:
    """Return all parts as kernels take them, and the sums of their rows at the nodes."""
    groups: list[Group] = []
    rows_of_nodes: list[IntArray] = []
    first = remembered = 0
    for part, at_rest in zip(parts, shapes, strict=True):
        group, nodes_of_rows = _group(part, at_rest, nodes, first, remembered)
        groups.append(group)
        rows_of_nodes.append(nodes_of_rows)
        first, remembered = group.rows.stop, group.memory.stop
    return groups, node_sums(np.concatenate(rows_of_nodes), len(nodes))


def _group(
    part: Part, shapes: Shapes, nodes: FloatArray, first: int, remembered: int
) -> tuple[Group, IntArray]:
    """Return a part as kernels take it, and the nodes of its rows.

    Its rows and memory begin at `first` and `remembered`.
    """
    sums, nodes_of_rows = block_sums(part.elements, len(nodes))
    material = part.material.coefficients(part.kind, part.across)
    viscosity = _viscosity(part, material.wave_modulus)
    tables = ElementTables(
        nodes_in_lanes(part.elements),
        in_lanes(shapes.gradients),
        in_lanes(shapes.measures[:, None], np.zeros(1)),
        material.stage,
        material.numbers,
        material.curves,
        material.tangent,
        _hourglass(part, shapes, nodes, material.modulus),
        viscosity,
        in_lanes(np.cbrt(shapes.measures)[:, None]),
        0,
        sums,
    )
    rows = slice(first, first + len(nodes_of_rows))
    kept = material.memory + (MEMORY if viscosity.size else 0)
    memory = slice(remembered, remembered + tables.measures.size * kept)
    bound, average = tables, None
    if material.averaged:
        tables = tables._replace(numbers=material.numbers * [1.0, 0.0], averaged=1)
        average = _average(part, shapes, nodes, material.averaged, nodes_of_rows)
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
        material.reaches,
    )
    return group, nodes_of_rows


def _average(
    part: Part, shapes: Shapes, nodes: FloatArray, modulus: float, nodes_of_rows: IntArray
) -> Average:
    """Return the average of the change of volume of a part at its nodes."""
    corners, weights = part.elements.ravel(), shapes.shares.ravel()
    volumes = np.bincount(corners, weights=weights, minlength=len(nodes))
    return Average(modulus, volumes.astype(np.float64), node_sums(nodes_of_rows, len(nodes)))


def _viscosity(part: Part, modulus: float) -> FloatArray:
    """Return the coefficients (3,) of the bulk viscosity; (0,) without one."""
    if not any(part.bulk_viscosity):
        return np.zeros(0)
    linear, quadratic = part.bulk_viscosity
    return np.array([linear * np.sqrt(modulus / part.density), quadratic, part.density])


def _hourglass(part: Part, shapes: Shapes, nodes: FloatArray, modulus: float) -> FloatArray:
    """Return the table of hourglass springs, rows by `solid_hex_nb`; empty for other elements.

    A brick of side a that is bent along it by its mode ξη stores E V (2 q)²/(6 a²), its springs
    c V (8 q)²/2: they are as stiff as the material with c = E/(48 a²). To be the same whichever way
    an element turns c has no direction; with the longer of both sides none is too stiff.
    """
    if part.kind != "hex8":
        return np.zeros((0, 0))
    modes = hourglass_modes(nodes[part.elements], shapes.gradients)
    stiff = part.hourglass * modulus / (48.0 * modes.lengths**2)
    weighted = stiff[:, :, None] * modes.vectors
    rows = np.abs(np.einsum("ema,emb->eab", weighted, modes.vectors)).sum(axis=2)
    rows *= shapes.measures[:, None]
    seen = modes.seen.reshape(len(stiff), 12)
    return in_lanes(np.concatenate([seen, stiff, rows], axis=1), np.zeros(24))


def _check_mass(nodes: FloatArray, mass: FloatArray) -> None:
    lone = np.flatnonzero(mass <= 0.0)
    if lone.size:
        row = int(lone[0])
        more = f", and {len(lone) - 1} more" if len(lone) > 1 else ""
        raise MeshError(
            f"node {row} is in no element and has no mass{more}",
            where="nodes",
            found=nodes[row].tolist(),
            remedy="Leave it out, or give it to a part",
        )
