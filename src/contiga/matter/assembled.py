"""Finite elements behind the protocol of matter: the forces of all groups, summed at the nodes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from contiga.arrays.layout import locked
from contiga.arrays.threads import run_ranges
from contiga.arrays.workspace import Workspace
from contiga.errors import ElementError
from contiga.jit import straight
from contiga.matter.blocks import NodeSums, memory_of, sum_at_nodes
from contiga.matter.coefficients import Reach
from contiga.matter.element_fields import ElementFields, KindFields, LargestStrain, at_nodes
from contiga.matter.kernels import elements_nb, row_sums_nb
from contiga.matter.kernels.lanes_nb import LANES, N_ENERGIES
from contiga.matter.mass_scaling import AddedMass
from contiga.matter.parts import DIMENSION
from contiga.matter.protocol import MatterEnergy, MatterForces, MatterState
from contiga.matter.strain import bar_gradients, green, membrane_gradients, metric
from contiga.matter.stress import Apart, apart, cauchy
from contiga.matter.tables import ElementOutput, ElementTables, Motion
from contiga.records import FloatArray, IntArray

MIN_BLOCKS = 8
"""Least number of blocks for a thread."""
INSTANT_STEP = 1e-250
"""Step so short that dashpots do not move: the stiffness includes rate effects."""
KERNELS: dict[str, tuple[Callable[..., Any], Callable[..., Any]]] = {
    "tet4": (elements_nb.tetrahedra, row_sums_nb.tet_rows),
    "hex8": (elements_nb.hexahedra, row_sums_nb.hex_rows),
    "tri3": (elements_nb.triangles, row_sums_nb.triangle_rows),
    "bar2": (elements_nb.bars, row_sums_nb.bar_rows),
}
"""Kernels of forces and of row sums of the stiffness."""

_workspace = Workspace()


class Average(NamedTuple):
    """Average of the change of volume of tetrahedra at their nodes."""

    modulus: float
    """λ."""
    volumes: FloatArray
    """(m,) sum of a quarter of the volume at rest of each tetrahedron at a node; 0 without any."""
    sums: NodeSums
    """Sums of the rows of the group alone."""


class Group(NamedTuple):
    """The elements of a part, with their tables for kernels."""

    name: str
    kind: str
    elements: IntArray
    """(n, k)."""
    tables: ElementTables
    bound: ElementTables
    """Tables without averages at nodes, for bounds of the stiffness."""
    average: Average | None
    rows: slice
    """Rows in the table of sums of blocks of all groups."""
    memory: slice
    """Places in the memory of all groups."""
    across: float
    """Factor from an element's measure to its volume: thickness, section, or 1 for a solid."""
    reaches: tuple[Reach, ...]
    """Tables of its material."""


class Assembled:
    """Finite elements as `Matter`: its points are its degrees of freedom. Made by `assemble`."""

    def __init__(
        self,
        nodes: FloatArray,
        groups: list[Group],
        sums: NodeSums,
        mass: FloatArray,
        facets: IntArray,
        damping: float,
    ) -> None:
        self.nodes, self.mass, self.facets = nodes, mass, facets
        self.groups, self.damping = groups, damping
        self.added: tuple[AddedMass, ...] = ()
        """Mass that scaling added to each part."""
        self._sums = sums
        self._apart: list[Apart] = []
        self._memory_size = max((group.memory.stop for group in groups), default=0)

    def points(self, q: FloatArray) -> FloatArray:
        """See `Matter`: the nodes themselves."""
        return q

    def spread(self, f: FloatArray) -> FloatArray:
        """See `Matter`: forces on nodes."""
        return f

    def start(self) -> MatterState:
        """See `Matter`: the nodes at rest."""
        return MatterState(self.nodes.copy(), np.zeros(self._memory_size))

    def forces(self, state: MatterState, q: FloatArray, v: FloatArray, dt: float) -> MatterForces:
        """See `Matter`, here with the drag of `damping`; its work is a loss by viscosity.

        The error names the first inverted element of the first part with any.
        """
        q, v = np.ascontiguousarray(q, np.float64), np.ascontiguousarray(v, np.float64)
        motion = Motion(locked(q), locked(v), float(dt), np.zeros(0))
        partial = _workspace.rows(len(self._sums.rows), 3)
        energy, memory = np.zeros(N_ENERGIES), np.empty(self._memory_size)
        for group in self.groups:
            blocks = len(group.tables.nodes)
            out = ElementOutput(
                partial[group.rows], np.empty((blocks, N_ENERGIES)), np.empty(blocks, np.int32)
            )
            averaged_energy, group_motion = 0.0, motion
            if group.average is not None:
                pressures, averaged_energy = _pressures(group, group.average, motion, out)
                group_motion = motion._replace(pressures=pressures)
            run_ranges(
                straight(KERNELS[group.kind][0]),
                blocks,
                MIN_BLOCKS,
                group_motion,
                group.tables,
                memory_of(blocks, group.memory, state, memory),
                out,
            )
            if out.inverted.any():
                corners, gradients = q[group.elements], full_gradients(group)
                with np.errstate(invalid="ignore"):
                    determinants = np.linalg.det(np.einsum("eai,eaj->eij", corners, gradients))
                first = int(np.flatnonzero(~(determinants > 0.0))[0])
                raise ElementError(
                    f"{group.kind} of {group.name}",
                    first,
                    corners[first].mean(axis=0),
                    int(out.inverted.sum()),
                )
            of_group = out.energy.sum(axis=0)
            of_group[0] += averaged_energy
            energy += of_group
        force = sum_at_nodes(partial, self._sums)
        if self.damping:
            drag = (self.damping * self.mass)[:, None] * v
            force -= drag
            energy[2] += dt * float(np.sum(drag * v))
        energies = MatterEnergy(*energy.tolist())
        return MatterForces(force, energies, MatterState(locked(q), memory))

    def stress(self, state: MatterState) -> FloatArray:
        """Return the Cauchy stresses (m, 6) xx, yy, zz, xy, yz, xz of `nodal_fields`."""
        return self.nodal_fields(state).stress

    def nodal_fields(self, state: MatterState) -> ElementFields:
        """Return stress, strain and stored energy at the nodes.

        They are means of the elements at each node by their volumes at rest.
        """
        return at_nodes(self.element_fields(state), len(self.mass))

    def element_fields(self, state: MatterState) -> list[KindFields]:
        """Return stress, strain and stored energy of all elements, one entry for each part.

        Stresses of membranes and bars are by the thickness or section at rest, and their strains
        are in their plane or along them.
        """
        if not self._apart:
            for group in self.groups:
                rest = self.nodes[group.elements]
                if DIMENSION[group.kind] == 3:
                    gradients = full_gradients(group)
                elif group.kind == "tri3":
                    gradients = membrane_gradients(rest)
                else:
                    gradients = bar_gradients(rest)
                pieces = apart(group.elements, group.tables, gradients, metric(rest, gradients))
                self._apart.append(pieces)
        entries = []
        for group, pieces in zip(self.groups, self._apart, strict=True):
            corners = state.points[group.elements]
            n, k = group.elements.shape
            volumes = group.tables.measures.ravel()[:n] * group.across
            forces, energies = self._corner_forces(group, pieces, state)
            fields = ElementFields(
                cauchy(group.kind, corners, forces.reshape(n, k, 3), group.across),
                green(corners, pieces.gradients, pieces.rest_metric),
                energies[:n] / volumes,
            )
            entries.append(KindFields(group.elements, volumes, fields))
        return entries

    def reached(self, state: MatterState) -> list[LargestStrain]:
        """Return the largest strain since the start for each table of each part."""
        strains = []
        for group in self.groups:
            blocks, n = len(group.tables.nodes), len(group.elements)
            lanes = state.memory[group.memory].reshape(blocks, -1, LANES)
            for reach in group.reaches:
                largest = float(lanes[:, reach.column].ravel()[:n].max())
                strains.append(LargestStrain(group.name, reach.what, largest, reach.end))
        return strains

    def _corner_forces(
        self, group: Group, pieces: Apart, state: MatterState
    ) -> tuple[FloatArray, FloatArray]:
        """Return the forces on the corners of a group's separate elements, and the stored energies.

        Forces are (e · k, 3), the k corners of each element in succession; energies are one an
        element, in (≥ e,) rows of which those from e on are padding. Drag is not included.
        """
        blocks, q = len(group.tables.nodes), locked(state.points)
        rows = max(len(pieces.rows), group.rows.stop - group.rows.start)
        partial = np.empty((rows, 3))
        energy, inverted = np.zeros((blocks, N_ENERGIES + LANES)), np.empty(blocks, np.int32)
        out = ElementOutput(partial, energy, inverted)
        corner_pressures, averaged_energies = np.zeros(0), np.zeros(0)
        if group.average is not None:
            motion = Motion(q, q, 0.0, corner_pressures)
            pressures, _ = _pressures(group, group.average, motion, out)
            corner_pressures = pressures[pieces.corners]
            densities = pressures * pressures / group.average.modulus
            density = 0.5 * densities[group.elements].mean(axis=1)
            averaged_energies = density * group.tables.measures.ravel()[: len(density)]
        points = locked(state.points[pieces.corners])
        motion = Motion(points, locked(np.zeros_like(points)), 0.0, corner_pressures)
        memory = memory_of(blocks, group.memory, state, np.empty(self._memory_size))
        run_ranges(KERNELS[group.kind][0], blocks, MIN_BLOCKS, motion, pieces.tables, memory, out)
        forces = np.empty((len(pieces.corners), 3))
        forces[pieces.rows] = partial[: len(pieces.rows)]
        stored = energy[:, N_ENERGIES:].ravel()
        stored[: len(averaged_energies)] += averaged_energies
        return forces, stored

    def stiffness(self, state: MatterState) -> FloatArray:
        """See `Matter`: at the state's points, without damping."""
        motion = Motion(locked(state.points), locked(state.points), INSTANT_STEP, np.zeros(0))
        partial = _workspace.rows(len(self._sums.rows), 3)
        for group in self.groups:
            blocks = len(group.tables.nodes)
            out = ElementOutput(
                partial[group.rows], np.empty((0, N_ENERGIES)), np.empty(0, np.int32)
            )
            memory = memory_of(blocks, group.memory, state, np.empty(self._memory_size))
            run_ranges(KERNELS[group.kind][1], blocks, MIN_BLOCKS, motion, group.bound, memory, out)
        return np.asarray(sum_at_nodes(partial, self._sums).max(axis=1))


def _pressures(
    group: Group, average: Average, motion: Motion, out: ElementOutput
) -> tuple[FloatArray, float]:
    """Return λ (J̄ − 1) (m,), J̄ the mean of a node's elements by volume, and Σ V λ (J̄ − 1)²/2.

    The latter is an energy, whose gradient is Σ p̄ ∂v/∂x over elements of volume v, p̄ the mean of
    their corners' λ (J̄ − 1). Nodes without tetrahedra have zero; `out.partial` is overwritten.
    """
    blocks = len(group.tables.nodes)
    run_ranges(elements_nb.tet_volumes, blocks, MIN_BLOCKS, motion, group.tables, out)
    has_volume = average.volumes > 0.0
    ratios = sum_at_nodes(out.partial, average.sums)[:, 0] / np.where(
        has_volume, average.volumes, 1.0
    )
    change = np.where(has_volume, ratios - 1.0, 0.0)
    pressures = average.modulus * change
    return pressures, 0.5 * float(np.sum(average.volumes * pressures * change))


def full_gradients(group: Group) -> FloatArray:
    """Return the gradients (n, k, 3) of the shape functions of all corners of solids at rest."""
    n, corners = group.elements.shape
    blocks = len(group.tables.nodes)
    lanes = group.tables.gradients.reshape(blocks, -1, 3, LANES).transpose(0, 3, 1, 2)
    rows = lanes.reshape(blocks * LANES, -1, 3)[:n]
    if rows.shape[1] == corners:
        return np.asarray(rows)
    return np.concatenate([-rows.sum(axis=1, keepdims=True), rows], axis=1)
