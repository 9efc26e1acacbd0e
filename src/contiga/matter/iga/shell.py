"""Shells and membranes of splines behind the protocol of matter."""

from __future__ import annotations

from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.sparse import coo_array, csr_array

from contiga.arrays.layout import locked
from contiga.arrays.threads import run_ranges
from contiga.arrays.workspace import Workspace
from contiga.errors import ElementError
from contiga.jit import straight
from contiga.matter.blocks import NodeSums, memory_of, sum_at_nodes
from contiga.matter.element_fields import ElementFields, KindFields
from contiga.matter.iga.elements import drawn_points, gauss, points_of
from contiga.matter.iga.inside import GaussPoints, as_fields, fields_at, gauss_points
from contiga.matter.kernels import shell_elements_nb, shell_slope_nb, shell_tangent_nb
from contiga.matter.kernels.lanes_nb import LANES, N_ENERGIES
from contiga.matter.kernels.shell_nb import INSIDE
from contiga.matter.protocol import MatterEnergy, MatterForces, MatterState
from contiga.matter.tables import (
    ElementOutput,
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

MIN_BLOCKS, MIN_EDGE_POINTS = 1, 200
"""Least number of blocks, or of edge points, for a thread."""

_workspace = Workspace()


class ShellGroup(NamedTuple):
    """The elements of all patches of one pair of degrees, with their tables for kernels."""

    elements: IntArray
    """(e, k) control points."""
    values: FloatArray
    """(e, g, k) their basis functions at Gauss points."""
    tables: ShellTables
    rows: slice
    """Rows in the table of sums of blocks of all groups."""
    memory: slice
    """Places in the memory of all groups."""


class Shell:
    """A Kirchhoff-Love shell, or a membrane, of splines as `Matter`. Made by `assemble_shell`.

    Its degrees of freedom are control points, its points those for contact.
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
        self._memory_size = max(group.memory.stop for group in groups)

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
        """Tributary area (n,) of each point of contact at rest."""
        return self.contact.weight

    def points(self, q: FloatArray) -> FloatArray:
        """See `Matter`: the points of contact."""
        return self.contact.points(q)

    def spread(self, f: FloatArray) -> FloatArray:
        """See `Matter`."""
        return self.contact.spread(f)

    def drawn(self, parts: int) -> SplinePoints:
        """Return a mesh for pictures, each element in `parts` in u and in v."""
        return drawn_points(self.net, whole_number(parts, "parts", 1))

    def start(self) -> MatterState:
        """See `Matter`: control points at rest."""
        return MatterState(self.net.points.copy(), np.zeros(self._memory_size))

    def forces(self, state: MatterState, q: FloatArray, v: FloatArray, dt: float) -> MatterForces:
        """Return forces and energies as `Matter` does; there are no rate effects, `v` is not used.

        Raises
        ------
        ElementError
            An element that bends has an area that is zero or not finite at a Gauss point. Membranes
            are not checked.
        """
        q = np.ascontiguousarray(q, np.float64)
        motion = Motion(locked(q), locked(q), float(dt), np.zeros(0))
        partial = _workspace.rows(len(self._sums.rows), 3)
        energy, memory = np.zeros(N_ENERGIES), np.empty(self._memory_size)
        for group in self.groups:
            blocks = len(group.tables.nodes)
            out = ElementOutput(
                partial[group.rows], np.empty((blocks, N_ENERGIES)), np.empty(blocks, np.int32)
            )
            run_ranges(
                straight(shell_elements_nb.shells),
                blocks,
                MIN_BLOCKS,
                motion,
                group.tables,
                memory_of(blocks, group.memory, state, memory),
                out,
            )
            if out.inverted.any():
                axes = self._gauss_points(group, state._replace(points=q)).axes
                normals = np.cross(axes[..., 0], axes[..., 1])
                flat = np.flatnonzero(~(np.sum(normals * normals, axis=-1) > 0.0).all(axis=1))
                place = q[group.elements[flat[0]]].mean(axis=0)
                raise ElementError("of a shell, pressed to a line", int(flat[0]), place, len(flat))
            energy += out.energy.sum(axis=0)
        if self._slopes is not None:
            count = len(self._slopes.nodes)
            springs = SlopeOutput(partial[self.groups[-1].rows.stop :], np.empty(count))
            run_ranges(
                straight(shell_slope_nb.slopes),
                count,
                MIN_EDGE_POINTS,
                locked(q),
                self._slopes,
                springs,
            )
            energy[0] += springs.energy.sum()
        energies = MatterEnergy(*energy.tolist())
        return MatterForces(
            sum_at_nodes(partial, self._sums), energies, MatterState(locked(q), memory)
        )

    def stiffness(self, state: MatterState) -> FloatArray:
        """See `Matter`: at the state's points."""
        partial = _workspace.rows(len(self._sums.rows), 3)
        motion = Motion(locked(state.points), locked(state.points), 0.0, np.zeros(0))
        for group in self.groups:
            blocks = len(group.tables.nodes)
            out = ElementOutput(
                partial[group.rows], np.empty((0, N_ENERGIES)), np.empty(0, np.int32)
            )
            memory = memory_of(blocks, group.memory, state, np.empty(self._memory_size))
            kernel = shell_tangent_nb.shell_row_sums
            run_ranges(kernel, blocks, MIN_BLOCKS, motion, group.tables, memory, out)
        if self._slopes is not None:
            sums = np.abs(self._slope_stiffness(state)).sum(axis=2)
            partial[self.groups[-1].rows.stop :] = sums.reshape(-1, 3)
        return np.asarray(sum_at_nodes(partial, self._sums).max(axis=1))

    def tangent(self, state: MatterState) -> csr_array:
        """Return the stiffness (3 m, 3 m) −∂f/∂q at a state, rows x, y, z of each control point.

        For materials without a tangent (cloth without compression, fabric) it is an upper bound of
        the stiffness in all states: Newton's method then takes more steps.
        """
        rows, columns, values = [], [], []
        entries = [(group.elements, self._element_stiffness(group, state)) for group in self.groups]
        if self._slopes is not None:
            entries.append((self._slopes.nodes, self._slope_stiffness(state)))
        for nodes, stiffness in entries:
            dofs = (3 * nodes[:, :, None] + np.arange(3, dtype=np.int32)).reshape(len(nodes), -1)
            rows.append(np.broadcast_to(dofs[:, :, None], stiffness.shape).ravel())
            columns.append(np.broadcast_to(dofs[:, None, :], stiffness.shape).ravel())
            values.append(stiffness.ravel())
        indices = np.concatenate(rows), np.concatenate(columns)
        size = 3 * len(self.mass)
        return coo_array((np.concatenate(values), indices), shape=(size, size)).tocsr()

    def element_fields(self, state: MatterState, height: float = 0.0) -> list[KindFields]:
        """Return stress, strain and stored energy of all elements, by pairs of degrees.

        They are means over Gauss points, at a height of −1 … 1 of half the thickness along a₃.
        """
        entries = []
        for group in self.groups:
            columns, weights = self._columns(group, state, height)
            areas = weights.sum(axis=1)
            means = (weights[:, :, None] * columns).sum(axis=1) / areas[:, None]
            entries.append(KindFields(group.elements, areas * self.thickness, as_fields(means)))
        return entries

    def nodal_fields(self, state: MatterState, height: float = 0.0) -> ElementFields:
        """Return fields at the control points (m,), as means weighted by their basis functions.

        They are at a height of −1 … 1 of half the thickness along a₃. `points` and `drawn`
        interpolate them to the surface.
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
        """Return strains, forces and moments at Gauss points, one entry for a pair of degrees."""
        return [self._gauss_points(group, state) for group in self.groups]

    def pressure(self, q: FloatArray) -> FloatArray:
        """Return the forces (m, 3) on control points `q` of a unit pressure along the normals."""
        points = self._gauss
        return points.spread(points.measure[:, None] * points.normals(q))

    @cached_property
    def _gauss(self) -> SplinePoints:
        """Gauss points, degrees plus 1 of an element in each direction."""
        return points_of(self.net, gauss, None)

    def _gauss_points(self, group: ShellGroup, state: MatterState) -> GaussPoints:
        """Return axes, strains, forces, moments and energies at the Gauss points of a group."""
        blocks = len(group.tables.nodes)
        motion = Motion(locked(state.points), locked(state.points), 0.0, np.zeros(0))
        out = np.empty((blocks, group.tables.points * INSIDE * LANES))
        memory = memory_of(blocks, group.memory, state, np.empty(self._memory_size))
        kernel = shell_elements_nb.shell_inside
        run_ranges(kernel, blocks, MIN_BLOCKS, motion, group.tables, memory, out)
        return gauss_points(out, len(group.elements))

    def _columns(
        self, group: ShellGroup, state: MatterState, height: float
    ) -> tuple[FloatArray, FloatArray]:
        """Return fields (e, g, 13) at Gauss points at a height, and their areas (e, g) at rest."""
        now, rest = self._gauss_points(group, state), self._gauss_points(group, self.start())
        lanes = group.tables.weights.reshape(-1, group.tables.points, LANES)
        weights = lanes.transpose(0, 2, 1).reshape(-1, group.tables.points)
        columns = fields_at(now, rest, self.thickness, height)
        return columns, weights[: len(group.elements)]

    def _element_stiffness(self, group: ShellGroup, state: MatterState) -> FloatArray:
        """Return the stiffness (e, 3 k, 3 k) of the elements of a group, symmetric."""
        blocks, (n, k) = len(group.tables.nodes), group.elements.shape
        motion = Motion(locked(state.points), locked(state.points), 0.0, np.zeros(0))
        out = np.empty((blocks, k * (k + 1) // 2 * 9 * LANES))
        memory = memory_of(blocks, group.memory, state, np.empty(self._memory_size))
        kernel = shell_tangent_nb.shell_stiffness
        run_ranges(kernel, blocks, MIN_BLOCKS, motion, group.tables, memory, out)
        # From pairs of control points I ≤ J in blocks of lanes to full matrices.
        lanes = out.reshape(blocks, -1, 3, 3, LANES)
        pairs = np.moveaxis(lanes, 4, 1).reshape(blocks * LANES, -1, 3, 3)[:n]
        stiffness = np.empty((n, k, 3, k, 3))
        rows, columns = np.triu_indices(k)
        stiffness[:, columns, :, rows] = np.moveaxis(pairs, 0, 1).swapaxes(2, 3)
        stiffness[:, rows, :, columns] = np.moveaxis(pairs, 0, 1)
        return stiffness.reshape(n, 3 * k, 3 * k)

    def _slope_stiffness(self, state: MatterState) -> FloatArray:
        """Return the stiffness (n, 3 k, 3 k) of the springs between slopes, by differences."""
        assert self._slopes is not None
        count, size = self._slopes.nodes.shape
        out = np.empty((count, 3 * size, 3 * size))
        kernel = shell_slope_nb.slope_stiffness
        run_ranges(kernel, count, MIN_EDGE_POINTS, locked(state.points), self._slopes, out)
        return out
