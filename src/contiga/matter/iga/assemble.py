"""Assembly of a shell, as matter, from spline surfaces and a material."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from contiga.arrays.layout import not_negative, positive
from contiga.errors import InputError
from contiga.matter.blocks import block_sums, in_lanes, node_sums, nodes_in_lanes
from contiga.matter.coefficients import Coefficients, Material
from contiga.matter.iga.elements import at_rest, contact_points, gauss, grid_of
from contiga.matter.iga.shell import Shell, ShellGroup
from contiga.matter.iga.slopes import Bending, Symmetry, slope_tables
from contiga.matter.kernels.lanes_nb import LANES
from contiga.matter.tables import ShellTables
from contiga.patches.basis import VALUE, Patch
from contiga.patches.checks import whole_number
from contiga.patches.net import Net, join
from contiga.records import FloatArray, IntArray

N_LAYERS = 3
"""Gauss points through the thickness, for materials that are integrated layer by layer."""


def assemble_shell(
    surfaces: Sequence[Patch] | Net,
    *,
    material: Material,
    density: float,
    thickness: float,
    bending: float = 1.0,
    layers: int | None = None,
    rule: int | None = None,
    contact: str = "nodes",
    points: int | None = None,
    tolerance: float | None = None,
    symmetry: Sequence[Symmetry] = (),
    slope_stiffness: float | None = None,
    rest: FloatArray | None = None,
) -> Shell:
    """Return a shell, or a membrane, on spline surfaces as matter.

    Parameters
    ----------
    surfaces : patches of degrees 1 to 5 that share the control points of their joints, or their
        `Net`; the shell at the start
    material : one of `contiga.materials` that is for membranes
    density : mass / volume
    thickness : length
    bending : bending stiffness over that of a solid sheet; 0 is a membrane
    layers : Gauss points through the thickness; None for as many as the material needs: none if
        forces and moments follow from the middle surface (`Elastic`, `Fabric`), else 3
    rule : Gauss points of an element in each direction; its degrees plus 1 if omitted. With 2
        at degree 2 thin shells lock less, and take less than half the time
    contact : kind of `Shell.points`, the nodes of a slave: "nodes", which elements and patches
        share (`contiga.patches.nodes`); points of Gauss's rule ("gauss") or the middles of equal
        parts of the parameters ("grid"), none of which is on an edge
    points : number of these points of an element in each direction; its degrees plus 1 if omitted,
        2 for nodes
    tolerance : length within which control points of joints are the same
    symmetry : edges whose angle to a plane is held
    slope_stiffness : stiffness of the springs that hold slopes there and across joints, over that
        of an element: a spring turns as a strip of 1/slope_stiffness of an element does. If omitted
        the largest that does not shorten the step, 2 (width/thickness)², but at least 10
    rest : (m, 3) control points, in the order of the net, at which no element is strained; those
        of the surfaces if omitted

    Raises
    ------
    InputError
        A number outside its range, a material that is not for membranes, a patch of degree 1 with
        bending, and all that `join` refuses.

    Notes
    -----
    A patch is cut along knots whose multiplicity is its degree; springs hold its slope there, too.
    Masses are lumped, which makes checkerboard modes of control points slow, more so at higher
    degrees. Use degree 2 for vibrations.

    Examples
    --------
    >>> import contiga as cg
    >>> from contiga.matter.iga import assemble_shell
    >>> plate = cg.shapes.plane(width=2.0, length=1.0).k_refined((1, 1), [0.5], [0.5])
    >>> steel = cg.materials.Elastic(young=210.0, poisson=0.3)
    >>> shell = assemble_shell([plate], material=steel, density=3.0, thickness=0.1)
    >>> round(float(shell.mass.sum()), 9), len(shell.net.edge("u0"))
    (0.6, 4)
    """
    if "tri3" not in material.kinds:
        raise InputError(
            f"{type(material).__name__} is no material of shells",
            where="material",
            allowed="one for membranes: Elastic, NeoHooke, Fabric",
        )
    density, thickness = positive(density, "density"), positive(thickness, "thickness")
    share = not_negative(bending, "bending")
    net = surfaces if isinstance(surfaces, Net) else join(surfaces, tolerance)
    straight_patches = [piece.patch for piece in net.pieces if min(piece.degrees) < 2]
    if share > 0.0 and straight_patches:
        raise InputError(
            "what is of degree 1 in a direction does not bend",
            where=f"surfaces[{straight_patches[0]}]",
            allowed="degrees 2 to 5, or bending = 0 for a membrane",
            remedy="Raise its degrees: NurbsSurface.elevate",
        )
    coefficients = material.coefficients("tri3", thickness)
    if layers is None:
        layers = 0 if len(coefficients.bending) else N_LAYERS
    section = _section(coefficients, thickness, share, whole_number(layers, "layers", 0))
    direction = getattr(material, "direction", None)
    if direction is not None and direction.shape != (3,):
        raise InputError(
            "of a shell is one", where="direction", found=direction.shape, allowed="(3,)"
        )
    n_gauss = None if rule is None else whole_number(rule, "rule", 1)
    unstrained = net if rest is None else net._replace(points=rest)
    elements_by_degrees, areas = _elements(unstrained, n_gauss, direction)
    groups: list[ShellGroup] = []
    nodes_of_rows: list[IntArray] = []
    first_row = first_memory = 0
    for elements in elements_by_degrees:
        group, nodes = _group(section, elements, len(net.points), first_row, first_memory)
        groups.append(group)
        nodes_of_rows.append(nodes)
        first_row, first_memory = group.rows.stop, group.memory.stop
    rigidity = coefficients.modulus * share * thickness**3 / 12.0
    if slope_stiffness is not None:
        slope_stiffness = positive(slope_stiffness, "slope_stiffness")
    slopes = None
    if share > 0.0:
        slopes = slope_tables(unstrained, symmetry, Bending(rigidity, thickness, slope_stiffness))
    if slopes is not None:
        nodes_of_rows.append(slopes.nodes.ravel())
    sums = node_sums(np.concatenate(nodes_of_rows), len(net.points))
    mass, places = density * thickness * areas, contact_points(net, contact, points)
    return Shell(net, thickness, groups, sums, mass, slopes, places)


class _Section(NamedTuple):
    """A shell across its thickness."""

    coefficients: Coefficients
    bending: FloatArray
    """(4,) D of the moments, if they follow from the middle surface."""
    layers: FloatArray
    """(l, 2) heights and shares of the thickness."""


class _Elements(NamedTuple):
    """e elements of one pair of degrees at their g Gauss points."""

    control: IntArray
    """(e, k) control points."""
    values: FloatArray
    """(e, g, k) their basis functions."""
    basis: FloatArray
    """(e, g, k, 5) derivatives of these along the axes at rest."""
    curvature: FloatArray
    """(e, g, 3) at rest."""
    weights: FloatArray
    """(e, g) area at rest."""


def _section(coefficients: Coefficients, thickness: float, share: float, layers: int) -> _Section:
    """Return the section of a shell with a `share` of the bending stiffness of a solid sheet.

    Layers are Gauss points of the thickness times √share; a membrane, `share` 0, has none. With 0
    `layers` moments follow from the middle surface; `InputError` is raised if the material does
    not allow that.
    """
    if share == 0.0:
        return _Section(coefficients, np.zeros(4), np.zeros((0, 2)))
    if layers == 0:
        if not len(coefficients.bending):
            raise InputError(
                "the material is asked layer by layer",
                where="layers",
                found=layers,
                allowed="2 or more",
            )
        bending = coefficients.bending * (share * thickness**2 / 12.0)
        return _Section(coefficients, bending, np.zeros((0, 2)))
    rule = gauss(layers)
    # Heights times √share give that share of the bending stiffness.
    heights = (rule.points - 0.5) * (thickness * np.sqrt(share))
    return _Section(coefficients, np.zeros(4), np.stack([heights, rule.weights], axis=1))


def _elements(
    net: Net, n_gauss: int | None, direction: FloatArray | None
) -> tuple[list[_Elements], FloatArray]:
    """Return all elements by pairs of degrees, and the areas (m,) of the control points.

    Elements have `n_gauss` points each way, or degree plus one if it is None. The area of a control
    point is the integral of its basis function.
    """
    areas = np.zeros(len(net.points))
    by_degrees: dict[tuple[int, int], list[_Elements]] = {}
    for piece in net.pieces:
        p, q = piece.degrees
        grid = grid_of(piece, (gauss(n_gauss or p + 1), gauss(n_gauss or q + 1)))
        rest = at_rest(net, grid.at, direction)
        weights = grid.weights * rest.area
        shares = (grid.at.values[:, VALUE] * weights[:, None]).ravel()
        areas += np.bincount(grid.at.control.ravel(), weights=shares, minlength=len(areas))
        elements = _Elements(
            grid.by_element(grid.at.control)[:, 0],
            grid.by_element(grid.at.values[:, VALUE]),
            grid.by_element(rest.basis),
            grid.by_element(rest.curvature),
            grid.by_element(weights),
        )
        by_degrees.setdefault((p, q), []).append(elements)
    joined = [
        _Elements(*(np.concatenate(arrays) for arrays in zip(*parts, strict=True)))
        for parts in by_degrees.values()
    ]
    return joined, areas


def _group(
    section: _Section,
    elements: _Elements,
    n_nodes: int,
    first_row: int,
    first_memory: int,
) -> tuple[ShellGroup, IntArray]:
    """Return a group with the tables of elements for kernels, and the control points of its rows.

    Rows (r,) and memory begin at `first_row` and `first_memory`.
    """
    count, points = elements.weights.shape
    sums, nodes_of_rows = block_sums(elements.control, n_nodes)
    coefficients = section.coefficients
    tables = ShellTables(
        nodes_in_lanes(elements.control),
        points,
        in_lanes(elements.basis.reshape(count, -1)),
        in_lanes(elements.curvature.reshape(count, -1)),
        in_lanes(elements.weights, np.zeros(points)),
        coefficients.material,
        coefficients.numbers,
        coefficients.curves,
        coefficients.tangent,
        section.bending,
        section.layers,
        sums,
    )
    size = len(tables.nodes) * LANES * points * max(len(section.layers), 1) * coefficients.memory
    rows = slice(first_row, first_row + len(nodes_of_rows))
    memory = slice(first_memory, first_memory + size)
    return ShellGroup(elements.control, elements.values, tables, rows, memory), nodes_of_rows
