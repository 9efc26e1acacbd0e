"""Shells and membranes of splines behind the protocol of matter."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array

from contiga.arrays.layout import locked, one_of, positive
from contiga.arrays.threads import run_ranges
from contiga.arrays.workspace import Workspace
from contiga.errors import ElementError, InputError
from contiga.jit import straight
from contiga.matter.blocks import NodeSums, block_sums, in_lanes, node_sums, nodes_in_lanes
from contiga.matter.coefficients import Coefficients, Material
from contiga.matter.element_fields import ElementFields, Inside
from contiga.matter.iga.basis import VALUE, Patch
from contiga.matter.iga.elements import (
    at_rest,
    drawn_points,
    gauss,
    grid_of,
    midpoints,
    points_of,
)
from contiga.matter.iga.inside import GaussPoints, as_fields, fields_at, gauss_points
from contiga.matter.iga.net import Net, join
from contiga.matter.iga.points import SplinePoints
from contiga.matter.iga.slopes import Bending, Symmetry, slope_tables
from contiga.matter.kernels import lanes_nb, shell_elements_nb, shell_slope_nb, shell_tangent_nb
from contiga.matter.kernels.lanes_nb import KINDS, LANES
from contiga.matter.kernels.shell_nb import INSIDE
from contiga.matter.protocol import MatterEnergy, MatterForces, MatterState
from contiga.matter.tables import (
    ElementOutput,
    Memory,
    Motion,
    ShellTables,
    SlopeOutput,
    SlopeTables,
)
from contiga.records import FloatArray, IntArray

BLOCKS, NODES, EDGE_POINTS = 1, 2000, 200
"""Grains of threads."""
LAYERS = 3
"""Gauss points through the thickness, of materials that are asked layer by layer."""

RULES = {"gauss": gauss, "grid": midpoints}
"""Where contact is asked for."""

_workspace = Workspace()


class ShellGroup(NamedTuple):
    """The elements of all patches of one pair of degrees, as kernels take them."""

    elements: IntArray
    """(e, k) control points."""
    values: FloatArray
    """(e, g, k) their basis functions at Gauss points."""
    tables: ShellTables
    rows: slice
    """Of the table that all groups write sums of blocks to."""
    memory: slice
    """Of what all groups remember."""


def assemble_shell(
    surfaces: Sequence[Patch] | Net,
    *,
    material: Material,
    density: float,
    thickness: float,
    bending: float = 1.0,
    layers: int | None = None,
    rule: int | None = None,
    contact: str = "gauss",
    points: int | None = None,
    tolerance: float | None = None,
    symmetry: Sequence[Symmetry] = (),
    slope_stiffness: float | None = None,
) -> Shell:
    """A shell, or a membrane, on spline surfaces as matter.

    Parameters
    ----------
    surfaces : patches of degrees 1 to 5 that share the control points of their joints, or their
        `Net`; where no element is strained
    material : one of `contiga.materials` that is for membranes
    density : mass / volume
    thickness : length
    bending : share of the bending stiffness of a solid sheet; 0 is a membrane
    layers : Gauss points through the thickness; None for as many as the material needs: none where
        forces and moments follow from the middle surface (`Elastic`, `Fabric`), else 3
    rule : Gauss points of an element in each direction; its degrees and 1 if omitted
    contact : where contact is asked for: at points of Gauss's rule ("gauss") or at the middles of
        equal parts of the parameters ("grid")
    points : of contact of an element in each direction; its degrees and 1 if omitted
    tolerance : length within which control points of joints are the same
    symmetry : edges that keep their angle to a plane
    slope_stiffness : of the springs that keep slopes there and across joints, in parts of what an
        element resists by: a spring turns as a strip of 1/slope_stiffness of an element does. If
        omitted as much as shortens no step, 2 (width/thickness)², and 10 at least

    Raises
    ------
    InputError
        A number outside its range, a material that is not for membranes, a patch of degree 1 that
        is to bend, and what `join` refuses.

    Notes
    -----
    A patch is cut along knots that stand as often as its degree; there its slope is kept by springs
    as well. Masses are lumped, and so checkerboards of control points are slow: the more so the
    higher the degree. Degree 2 is the one for what swings.

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
    share = _not_negative(bending, "bending")
    net = surfaces if isinstance(surfaces, Net) else join(surfaces, tolerance)
    straight_lines = [piece.patch for piece in net.pieces if min(piece.degrees) < 2]
    if share > 0.0 and straight_lines:
        raise InputError(
            "what is of degree 1 in a direction does not bend",
            where=f"surfaces[{straight_lines[0]}]",
            allowed="degrees 2 to 5, or bending = 0 for a membrane",
            remedy="Raise its degrees: NurbsSurface.elevate",
        )
    coefficients = material.coefficients("tri3", thickness)
    if layers is None:
        layers = 0 if len(coefficients.bending) else LAYERS
    section = _section(coefficients, thickness, share, _count(layers, "layers", 0))
    along = getattr(material, "direction", None)
    if along is not None and along.shape != (3,):
        raise InputError("of a shell is one", where="direction", found=along.shape, allowed="(3,)")
    counts = None if rule is None else _count(rule, "rule", 1)
    groups, mass, nodes_of_rows = _groups(net, section, counts, along)
    rigidity = coefficients.modulus * share * thickness**3 / 12.0
    if slope_stiffness is not None:
        slope_stiffness = positive(slope_stiffness, "slope_stiffness")
    slopes = None
    if share > 0.0:
        slopes = slope_tables(net, symmetry, Bending(rigidity, thickness, slope_stiffness))
    one_of("contact", contact, tuple(RULES))
    each = None if points is None else _count(points, "points", 1)
    of_contact = points_of(net, RULES[contact], each)
    if slopes is not None:
        nodes_of_rows.append(slopes.nodes.ravel())
    sums = node_sums(np.concatenate(nodes_of_rows), len(net.points))
    masses = density * thickness * mass
    return Shell(net, thickness, groups, sums, masses, slopes, of_contact)


class _Section(NamedTuple):
    """A shell across its thickness."""

    coefficients: Coefficients
    bending: FloatArray
    """(4,) D of the moments, where they follow from the middle surface."""
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
    heights = gauss(layers)
    # A lever shorter by √share bends by that share of the stiffness.
    levers = (heights.points - 0.5) * (thickness * np.sqrt(share))
    return _Section(coefficients, np.zeros(4), np.stack([levers, heights.weights], axis=1))


def _groups(
    net: Net, section: _Section, rule: int | None, along: FloatArray | None
) -> tuple[list[ShellGroup], FloatArray, list[IntArray]]:
    """All elements as kernels take them, areas of control points, and the nodes of their rows."""
    area = np.zeros(len(net.points))
    kinds: dict[tuple[int, int], list[_Elements]] = {}
    for piece in net.pieces:
        p, q = piece.degrees
        grid = grid_of(piece, (gauss(rule or p + 1), gauss(rule or q + 1)))
        rest = at_rest(net, grid.at, along)
        weights = grid.weights * rest.area
        shares = (grid.at.values[:, VALUE] * weights[:, None]).ravel()
        area += np.bincount(grid.at.control.ravel(), weights=shares, minlength=len(area))
        of_elements = _Elements(
            grid.by_element(grid.at.control)[:, 0],
            grid.by_element(grid.at.values[:, VALUE]),
            grid.by_element(rest.basis),
            grid.by_element(rest.curvature),
            grid.by_element(weights),
        )
        kinds.setdefault((p, q), []).append(of_elements)
    groups: list[ShellGroup] = []
    nodes_of_rows: list[IntArray] = []
    first = remembered = 0
    for parts in kinds.values():
        whole = _Elements(*(np.concatenate(arrays) for arrays in zip(*parts, strict=True)))
        group, nodes = _group(section, whole, len(net.points), first, remembered)
        groups.append(group)
        nodes_of_rows.append(nodes)
        first, remembered = group.rows.stop, group.memory.stop
    return groups, area, nodes_of_rows


def _group(
    section: _Section,
    elements: _Elements,
    n_nodes: int,
    first: int,
    remembered: int,
) -> tuple[ShellGroup, IntArray]:
    """Elements as kernels take them, rows and memory from `first` and `remembered` on, and the
    control points of their rows."""
    count, points = elements.weights.shape
    sums, nodes_of_rows = block_sums(elements.control, n_nodes)
    material = section.coefficients
    tables = ShellTables(
        nodes_in_lanes(elements.control),
        points,
        in_lanes(elements.basis.reshape(count, -1)),
        in_lanes(elements.curvature.reshape(count, -1)),
        in_lanes(elements.weights, np.zeros(points)),
        material.stage,
        material.numbers,
        material.tangent,
        section.bending,
        section.layers,
        sums,
    )
    kept = len(tables.nodes) * LANES * points * max(len(section.layers), 1) * material.memory
    rows = slice(first, first + len(nodes_of_rows))
    memory = slice(remembered, remembered + kept)
    return ShellGroup(elements.control, elements.values, tables, rows, memory), nodes_of_rows


class Shell:
    """A Kirchhoff-Love shell, or a membrane, of splines as `Matter`. Made by `assemble_shell`.

    Its degrees of freedom are control points; `points` are those of `contact`.
    """

    def __init__(
        self,
        net: Net,
        thickness: float,
        groups: list[ShellGroup],
        sums: NodeSums,
        mass: FloatArray,
        slopes: SlopeTables | None,
        contact: SplinePoints,
    ) -> None:
        self.net, self.thickness, self.groups = net, thickness, groups
        self.mass, self.contact = mass, contact
        self._sums, self._slopes = sums, slopes
        self._remembered = max(group.memory.stop for group in groups)

    @property
    def nodes(self) -> FloatArray:
        """(m, 3) control points at rest."""
        return self.net.points

    @property
    def facets(self) -> IntArray:
        """(f, 3) triangles between the points of contact of each patch."""
        return self.contact.facets

    def points(self, q: FloatArray) -> FloatArray:
        """See `Matter`: the points of contact."""
        return self.contact.points(q)

    def velocities(self, v: FloatArray) -> FloatArray:
        """See `Matter`."""
        return self.contact.points(v)

    def spread(self, f: FloatArray) -> FloatArray:
        """See `Matter`."""
        return self.contact.spread(f)

    def drawn(self, parts: int) -> SplinePoints:
        """A mesh to draw, each element in so many parts in u and in v."""
        return drawn_points(self.net, _count(parts, "parts", 1))

    def start(self) -> MatterState:
        """See `Matter`: control points at rest."""
        return MatterState(self.net.points.copy(), np.zeros(self._remembered))

    def forces(self, state: MatterState, q: FloatArray, v: FloatArray, dt: float) -> MatterForces:
        """See `Matter`: nothing of it resists a rate.

        Raises
        ------
        ElementError
            An element that bends and is pressed to a line, or whose points are not finite.
        """
        q = np.ascontiguousarray(q, np.float64)
        motion = Motion(locked(q), locked(q), float(dt), np.zeros(0))
        partial = _workspace.rows(len(self._sums.rows), 3)
        energy, memory = np.zeros(KINDS), np.empty(self._remembered)
        for group in self.groups:
            blocks = len(group.tables.nodes)
            out = ElementOutput(
                partial[group.rows], np.empty((blocks, KINDS)), np.empty(blocks, np.int32)
            )
            kept = _memory(group, state, memory)
            run_ranges(
                straight(shell_elements_nb.shells), blocks, BLOCKS, motion, group.tables, kept, out
            )
            if out.inverted.any():
                raise _flat(group, self._inside(group, state._replace(points=q)), q)
            energy += out.energy.sum(axis=0)
        if self._slopes is not None:
            count = len(self._slopes.nodes)
            springs = SlopeOutput(partial[self.groups[-1].rows.stop :], np.empty(count))
            run_ranges(
                straight(shell_slope_nb.slopes),
                count,
                EDGE_POINTS,
                locked(q),
                self._slopes,
                springs,
            )
            energy[0] += springs.energy.sum()
        energies = MatterEnergy(*energy.tolist())
        return MatterForces(self._at_nodes(partial), energies, MatterState(locked(q), memory))

    def stiffness(self, state: MatterState) -> FloatArray:
        """See `Matter`: at the state's points."""
        partial = _workspace.rows(len(self._sums.rows), 3)
        motion = Motion(locked(state.points), locked(state.points), 0.0, np.zeros(0))
        for group in self.groups:
            blocks = len(group.tables.nodes)
            out = ElementOutput(partial[group.rows], np.empty((0, KINDS)), np.empty(0, np.int32))
            kept = _memory(group, state, np.empty(self._remembered))
            kernel = shell_tangent_nb.shell_row_sums
            run_ranges(kernel, blocks, BLOCKS, motion, group.tables, kept, out)
        if self._slopes is not None:
            sums = np.abs(self._slope_stiffness(state)).sum(axis=2)
            partial[self.groups[-1].rows.stop :] = sums.reshape(-1, 3)
        return np.asarray(self._at_nodes(partial).max(axis=1))

    def tangent(self, state: MatterState) -> csr_array:
        """(3 m, 3 m) stiffness −∂f/∂q at the state's points, x, y and z of each control point.

        Of materials that have no tangent of their own (cloth that carries no compression, fabric)
        it is one that no state of theirs is stiffer than: Newton's method then takes more steps.
        """
        blocks = [_block_entries(group, self._stiffness_of(group, state)) for group in self.groups]
        if self._slopes is not None:
            nodes = self._slopes.nodes
            blocks.append(_Entries(nodes, self._slope_stiffness(state)))
        rows, columns, values = (
            np.concatenate(part) for part in zip(*map(_flattened, blocks), strict=True)
        )
        size = 3 * len(self.mass)
        return coo_array((values, (rows, columns)), shape=(size, size)).tocsr()

    def element_fields(self, state: MatterState, height: float = 0.0) -> list[Inside]:
        """Stress, strain and stored energy of all elements at a state, one entry a pair of degrees:
        means over their Gauss points, at a height of −1 … 1 of half the thickness along a₃."""
        found = []
        for group in self.groups:
            columns, weights = self._columns(group, state, height)
            areas = weights.sum(axis=1)
            means = (weights[:, :, None] * columns).sum(axis=1) / areas[:, None]
            found.append(Inside(group.elements, areas * self.thickness, as_fields(means)))
        return found

    def nodal_fields(self, state: MatterState, height: float = 0.0) -> ElementFields:
        """The same at control points, means by their basis functions: `points` and `drawn` take
        them to the surface."""
        weight, sums = np.zeros(len(self.mass)), np.zeros((len(self.mass), 13))
        for group in self.groups:
            columns, weights = self._columns(group, state, height)
            shares = group.values * weights[:, :, None]
            control = np.broadcast_to(group.elements[:, None], shares.shape).ravel()
            weight += np.bincount(control, shares.ravel(), minlength=len(weight))
            for c in range(13):
                share = (shares * columns[:, :, None, c]).ravel()
                sums[:, c] += np.bincount(control, share, minlength=len(weight))
        return as_fields(sums / weight[:, None])

    def gauss_points(self, state: MatterState) -> list[GaussPoints]:
        """Strains, forces and moments at Gauss points at a state, one entry a pair of degrees."""
        return [self._inside(group, state) for group in self.groups]

    def pressure(self, q: FloatArray) -> FloatArray:
        """(m, 3) forces of a pressure of one along S_u × S_v at the points of contact, which
        follows the surface."""
        return self.spread(self.contact.measure[:, None] * self.contact.normals(q))

    def _inside(self, group: ShellGroup, state: MatterState) -> GaussPoints:
        blocks = len(group.tables.nodes)
        motion = Motion(locked(state.points), locked(state.points), 0.0, np.zeros(0))
        out = np.empty((blocks, group.tables.points * INSIDE * LANES))
        kept = _memory(group, state, np.empty(self._remembered))
        run_ranges(shell_elements_nb.shell_inside, blocks, BLOCKS, motion, group.tables, kept, out)
        return gauss_points(out, len(group.elements))

    def _columns(
        self, group: ShellGroup, state: MatterState, height: float
    ) -> tuple[FloatArray, FloatArray]:
        """(e, g, 13) fields at Gauss points, and (e, g) the areas of these at rest."""
        now, rest = self._inside(group, state), self._inside(group, self.start())
        lanes = group.tables.weights.reshape(-1, group.tables.points, LANES)
        weights = lanes.transpose(0, 2, 1).reshape(-1, group.tables.points)
        columns = fields_at(now, rest, self.thickness, height)
        return columns, weights[: len(group.elements)]

    def _stiffness_of(self, group: ShellGroup, state: MatterState) -> FloatArray:
        """(b, pairs · 9 · LANES) of a group."""
        blocks, count = len(group.tables.nodes), group.elements.shape[1]
        motion = Motion(locked(state.points), locked(state.points), 0.0, np.zeros(0))
        out = np.empty((blocks, count * (count + 1) // 2 * 9 * LANES))
        kept = _memory(group, state, np.empty(self._remembered))
        run_ranges(
            shell_tangent_nb.shell_stiffness, blocks, BLOCKS, motion, group.tables, kept, out
        )
        return out

    def _slope_stiffness(self, state: MatterState) -> FloatArray:
        """(n, 3 k, 3 k) of the points that keep slopes."""
        assert self._slopes is not None
        count, size = self._slopes.nodes.shape
        out = np.empty((count, 3 * size, 3 * size))
        kernel = shell_slope_nb.slope_stiffness
        run_ranges(kernel, count, EDGE_POINTS, locked(state.points), self._slopes, out)
        return out

    def _at_nodes(self, partial: FloatArray) -> FloatArray:
        out = np.empty((len(self.mass), 3))
        starts, rows = self._sums
        run_ranges(straight(lanes_nb.sum_at_nodes), len(out), NODES, partial, starts, rows, out)
        return out


class _Entries(NamedTuple):
    """Stiffness of elements."""

    nodes: IntArray
    """(e, k)."""
    values: FloatArray
    """(e, 3 k, 3 k)."""


def _block_entries(group: ShellGroup, pairs: FloatArray) -> _Entries:
    """Of the pairs I ≤ J of blocks of lanes."""
    n, k = group.elements.shape
    lanes = pairs.reshape(len(pairs), -1, 3, 3, LANES)
    each = np.moveaxis(lanes, 4, 1).reshape(len(pairs) * LANES, -1, 3, 3)[:n]
    values = np.empty((n, k, 3, k, 3))
    upper, right = np.triu_indices(k)
    values[:, right, :, upper] = np.moveaxis(each, 0, 1).swapaxes(2, 3)
    values[:, upper, :, right] = np.moveaxis(each, 0, 1)
    return _Entries(group.elements, values.reshape(n, 3 * k, 3 * k))


def _flattened(entries: _Entries) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any]]:
    """Rows, columns and values."""
    places = (3 * entries.nodes[:, :, None] + np.arange(3, dtype=np.int32)).reshape(
        len(entries.nodes), -1
    )
    shape = entries.values.shape
    rows = np.broadcast_to(places[:, :, None], shape)
    columns = np.broadcast_to(places[:, None, :], shape)
    return rows.ravel(), columns.ravel(), entries.values.ravel()


def _memory(group: ShellGroup, state: MatterState, new: FloatArray) -> Memory:
    """A group's part of what a state remembers, and of what is written."""
    blocks = len(group.tables.nodes)
    old = state.memory[group.memory].reshape(blocks, -1)
    return Memory(locked(old), new[group.memory].reshape(blocks, -1))


def _flat(group: ShellGroup, now: GaussPoints, q: FloatArray) -> ElementError:
    """The first element without a normal, and where it is."""
    area = np.cross(now.axes[..., 0], now.axes[..., 1])
    flat = np.flatnonzero(~(np.sum(area * area, axis=-1) > 0.0).all(axis=1))
    place = q[group.elements[flat[0]]].mean(axis=0)
    return ElementError("of a shell, pressed to a line", int(flat[0]), place, len(flat))


def _count(value: object, where: str, least: int) -> int:
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or value < least:
        raise InputError(
            "must be a whole number", where=where, found=value, allowed=f"{least} or more"
        )
    return int(value)


def _not_negative(value: float, where: str) -> float:
    number = float(value)
    if not 0.0 <= number < np.inf:
        raise InputError("must be 0 or more", where=where, found=value, allowed="a finite number")
    return number
