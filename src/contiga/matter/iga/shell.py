"""Shells and membranes of splines behind the protocol of matter."""

from __future__ import annotations

from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array

from contiga.arrays.layout import locked
from contiga.arrays.threads import run_ranges
from contiga.arrays.workspace import Workspace
from contiga.errors import ElementError
from contiga.jit import straight
from contiga.matter.blocks import NodeSums
from contiga.matter.element_fields import ElementFields, Inside
from contiga.matter.iga.elements import drawn_points, gauss, points_of
from contiga.matter.iga.inside import GaussPoints, as_fields, fields_at, gauss_points
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
from contiga.patches.checks import whole_number
from contiga.patches.net import Net
from contiga.patches.nodes import SurfaceNodes
from contiga.patches.points import SplinePoints
from contiga.records import FloatArray, IntArray

BLOCKS, NODES, EDGE_POINTS = 1, 2000, 200
"""Grains of threads."""

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
    """Part of the memory of all groups."""


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
        contact: SplinePoints | SurfaceNodes,
    ) -> None:
        self.net, self.thickness, self.groups = net, thickness, groups
        self.mass, self.contact = mass, contact
        self._sums, self._slopes = sums, slopes
        self._remembered = max(group.memory.stop for group in groups)

    @property
    def nodes(self) -> FloatArray:
        """Control points (m, 3) at rest."""
        return self.net.points

    @property
    def facets(self) -> IntArray:
        """Triangles (f, 3) between the points of contact."""
        return self.contact.facets

    @property
    def areas(self) -> FloatArray:
        """Area (n,) at rest that each point of contact stands for."""
        return self.contact.weight

    def points(self, q: FloatArray) -> FloatArray:
        """See `Matter`: the points of contact."""
        return self.contact.points(q)

    def spread(self, f: FloatArray) -> FloatArray:
        """See `Matter`."""
        return self.contact.spread(f)

    def drawn(self, parts: int) -> SplinePoints:
        """A mesh to draw, each element in so many parts in u and in v."""
        return drawn_points(self.net, whole_number(parts, "parts", 1))

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
        """Return the stiffness (3 m, 3 m) −∂f/∂q at a state, rows x, y, z of each control point.

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
        """Return stress, strain and stored energy of all elements, by pairs of degrees.

        They are means over Gauss points, at a height of −1 … 1 of half the thickness along a₃.
        """
        found = []
        for group in self.groups:
            columns, weights = self._columns(group, state, height)
            areas = weights.sum(axis=1)
            means = (weights[:, :, None] * columns).sum(axis=1) / areas[:, None]
            found.append(Inside(group.elements, areas * self.thickness, as_fields(means)))
        return found

    def nodal_fields(self, state: MatterState, height: float = 0.0) -> ElementFields:
        """Return fields at control points, as means by their basis functions.

        `points` and `drawn` take them to the surface.
        """
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
        """Return the forces (m, 3) of a unit pressure, which follows the surface."""
        there = self._gauss
        return there.spread(there.measure[:, None] * there.normals(q))

    @cached_property
    def _gauss(self) -> SplinePoints:
        """Gauss's points, their degrees and 1 of an element in each direction."""
        return points_of(self.net, gauss, None)

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
        """Return fields (e, g, 13) at Gauss points, and their areas (e, g) at rest."""
        now, rest = self._inside(group, state), self._inside(group, self.start())
        lanes = group.tables.weights.reshape(-1, group.tables.points, LANES)
        weights = lanes.transpose(0, 2, 1).reshape(-1, group.tables.points)
        columns = fields_at(now, rest, self.thickness, height)
        return columns, weights[: len(group.elements)]

    def _stiffness_of(self, group: ShellGroup, state: MatterState) -> FloatArray:
        """Return the stiffness (b, pairs · 9 · LANES) of a group."""
        blocks, count = len(group.tables.nodes), group.elements.shape[1]
        motion = Motion(locked(state.points), locked(state.points), 0.0, np.zeros(0))
        out = np.empty((blocks, count * (count + 1) // 2 * 9 * LANES))
        kept = _memory(group, state, np.empty(self._remembered))
        run_ranges(
            shell_tangent_nb.shell_stiffness, blocks, BLOCKS, motion, group.tables, kept, out
        )
        return out

    def _slope_stiffness(self, state: MatterState) -> FloatArray:
        """Return the stiffness (n, 3 k, 3 k) of the points that keep slopes."""
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
    """Return the entries of pairs I ≤ J in blocks of lanes."""
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
    """Return a group's part of the memory of a state, and of the one to write."""
    blocks = len(group.tables.nodes)
    old = state.memory[group.memory].reshape(blocks, -1)
    return Memory(locked(old), new[group.memory].reshape(blocks, -1))


def _flat(group: ShellGroup, now: GaussPoints, q: FloatArray) -> ElementError:
    """Return the error of the first element without a normal."""
    area = np.cross(now.axes[..., 0], now.axes[..., 1])
    flat = np.flatnonzero(~(np.sum(area * area, axis=-1) > 0.0).all(axis=1))
    place = q[group.elements[flat[0]]].mean(axis=0)
    return ElementError("of a shell, pressed to a line", int(flat[0]), place, len(flat))
