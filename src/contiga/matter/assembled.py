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
from contiga.matter.blocks import NodeSums
from contiga.matter.coefficients import Reach
from contiga.matter.element_fields import ElementFields, Inside, Reached, at_nodes
from contiga.matter.kernels import elements_nb, lanes_nb, row_sums_nb
from contiga.matter.kernels.lanes_nb import KINDS, LANES
from contiga.matter.mass_scaling import AddedMass
from contiga.matter.parts import DIMENSION
from contiga.matter.protocol import MatterEnergy, MatterForces, MatterState
from contiga.matter.strain import bar_gradients, green, membrane_gradients, metric
from contiga.matter.stress import Apart, apart, cauchy
from contiga.matter.tables import ElementOutput, ElementTables, Memory, Motion
from contiga.records import FloatArray, IntArray

BLOCKS, NODES = 8, 2000
"""Grains of threads."""
INSTANT_STEP = 1e-250
"""Step in which nothing that resists a rate has time to give."""
KERNELS: dict[str, tuple[Callable[..., Any], Callable[..., Any]]] = {
    "tet4": (elements_nb.tetrahedra, row_sums_nb.tet_rows),
    "hex8": (elements_nb.hexahedra, row_sums_nb.hex_rows),
    "tri3": (elements_nb.triangles, row_sums_nb.triangle_rows),
    "bar2": (elements_nb.bars, row_sums_nb.bar_rows),
}
"""Forces and row sums."""

_workspace = Workspace()


class Average(NamedTuple):
    """Average of the change of volume of tetrahedra at their nodes."""

    modulus: float
    """λ."""
    volumes: FloatArray
    """(m,) a quarter of that of each tetrahedron at a node, at rest; 0 of nodes that have none."""
    sums: NodeSums
    """Of the group's rows alone."""


class Group(NamedTuple):
    """The elements of a part, as kernels take them."""

    name: str
    kind: str
    elements: IntArray
    """(n, k)."""
    tables: ElementTables
    bound: ElementTables
    """The same with all of its stiffness in the elements: none is averaged at nodes."""
    average: Average | None
    rows: slice
    """Of the table that all groups write sums of blocks to."""
    memory: slice
    """Of what all groups remember."""
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
        self._remembered = max((group.memory.stop for group in groups), default=0)

    def points(self, q: FloatArray) -> FloatArray:
        """See `Matter`: the nodes themselves."""
        return q

    def spread(self, f: FloatArray) -> FloatArray:
        """See `Matter`: forces on nodes."""
        return f

    def start(self) -> MatterState:
        """See `Matter`: the nodes at rest."""
        return MatterState(self.nodes.copy(), np.zeros(self._remembered))

    def forces(self, state: MatterState, q: FloatArray, v: FloatArray, dt: float) -> MatterForces:
        """See `Matter`."""
        q, v = np.ascontiguousarray(q, np.float64), np.ascontiguousarray(v, np.float64)
        motion = Motion(locked(q), locked(v), float(dt), np.zeros(0))
        partial = _workspace.rows(len(self._sums.rows), 3)
        energy, memory = np.zeros(KINDS), np.empty(self._remembered)
        for group in self.groups:
            energy += self._write_forces(group, motion, _memory(group, state, memory), partial)
        force = self._at_nodes(partial)
        if self.damping:
            drag = (self.damping * self.mass)[:, None] * v
            force -= drag
            energy[2] += dt * float(np.sum(drag * v))
        energies = MatterEnergy(*energy.tolist())
        return MatterForces(force, energies, MatterState(locked(q), memory))

    def _write_forces(
        self, group: Group, motion: Motion, memory: Memory, partial: FloatArray
    ) -> FloatArray:
        """Return the energies (4,) of a group, and write its forces to its rows of `partial`."""
        blocks = len(group.tables.nodes)
        out = ElementOutput(
            partial[group.rows], np.empty((blocks, KINDS)), np.empty(blocks, np.int32)
        )
        of_volume = 0.0
        if group.average is not None:
            pressures, of_volume = _pressures(group, group.average, motion, out)
            motion = motion._replace(pressures=pressures)
        run_ranges(
            straight(KERNELS[group.kind][0]), blocks, BLOCKS, motion, group.tables, memory, out
        )
        if out.inverted.any():
            raise _inverted(group, motion.points, out.inverted)
        energy = out.energy.sum(axis=0)
        energy[0] += of_volume
        return np.asarray(energy)

    def _at_nodes(self, partial: FloatArray) -> FloatArray:
        out = np.empty((len(self.mass), 3))
        starts, rows = self._sums
        run_ranges(straight(lanes_nb.sum_at_nodes), len(out), NODES, partial, starts, rows, out)
        return out

    def stress(self, state: MatterState) -> FloatArray:
        """Return the Cauchy stresses (m, 6) xx, yy, zz, xy, yz, xz of `nodal_fields`."""
        return self.nodal_fields(state).stress

    def nodal_fields(self, state: MatterState) -> ElementFields:
        """Return stress, strain and stored energy at the nodes.

        They are means of the elements at each node by their volumes at rest.
        """
        return at_nodes(self.element_fields(state), len(self.mass))

    def element_fields(self, state: MatterState) -> list[Inside]:
        """Return stress, strain and stored energy of all elements, one entry by part.

        Stresses of membranes and bars are by the thickness or section that they have at rest, and
        their strains are those in their plane or along them.
        """
        if not self._apart:
            self._apart = [self._taken_apart(group) for group in self.groups]
        return [
            self._inside(group, pieces, state)
            for group, pieces in zip(self.groups, self._apart, strict=True)
        ]

    def reached(self, state: MatterState) -> list[Reached]:
        """Return the largest strains since the start of the tables of all parts."""
        return [
            Reached(group.name, reach.what, _largest(group, state, reach.column), reach.end)
            for group in self.groups
            for reach in group.reaches
        ]

    def _taken_apart(self, group: Group) -> Apart:
        gradients = self._gradients(group)
        still = metric(self.nodes[group.elements], gradients)
        return apart(group.elements, group.tables, gradients, still)

    def _gradients(self, group: Group) -> FloatArray:
        """Return the gradients (e, k, 3) of all corners' shape functions at rest, in space."""
        if DIMENSION[group.kind] == 3:
            return full_gradients(group)
        rest = self.nodes[group.elements]
        return membrane_gradients(rest) if group.kind == "tri3" else bar_gradients(rest)

    def _inside(self, group: Group, pieces: Apart, state: MatterState) -> Inside:
        corners = state.points[group.elements]
        n, k = group.elements.shape
        volumes = group.tables.measures.ravel()[:n] * group.across
        forces, energies = self._forces_apart(group, pieces, state)
        fields = ElementFields(
            cauchy(group.kind, corners, forces.reshape(n, k, 3), group.across),
            green(corners, pieces.gradients, pieces.still),
            energies[:n] / volumes,
        )
        return Inside(group.elements, volumes, fields)

    def _forces_apart(
        self, group: Group, pieces: Apart, state: MatterState
    ) -> tuple[FloatArray, FloatArray]:
        """Return the forces (e · k, 3) on the corners of each element of a group, and its energy.

        The energy (≥ e,) is what each element stores.
        """
        blocks, q = len(group.tables.nodes), locked(state.points)
        rows = max(len(pieces.rows), group.rows.stop - group.rows.start)
        partial = np.empty((rows, 3))
        energy, inverted = np.zeros((blocks, KINDS + LANES)), np.empty(blocks, np.int32)
        out = ElementOutput(partial, energy, inverted)
        pressures, of_volume = np.zeros(0), np.zeros(0)
        if group.average is not None:
            motion = Motion(q, q, 0.0, pressures)
            every = _pressures(group, group.average, motion, out)[0]
            pressures = every[pieces.corners]
            density = 0.5 * (every * every / group.average.modulus)[group.elements].mean(axis=1)
            of_volume = density * group.tables.measures.ravel()[: len(density)]
        points = locked(state.points[pieces.corners])
        motion = Motion(points, locked(np.zeros_like(points)), 0.0, pressures)
        memory = _memory(group, state, np.empty(self._remembered))
        run_ranges(KERNELS[group.kind][0], blocks, BLOCKS, motion, pieces.tables, memory, out)
        forces = np.empty((len(pieces.corners), 3))
        forces[pieces.rows] = partial[: len(pieces.rows)]
        stored = energy[:, KINDS:].ravel()
        stored[: len(of_volume)] += of_volume
        return forces, stored

    def stiffness(self, state: MatterState) -> FloatArray:
        """See `Matter`: at the state's points, without damping."""
        motion = Motion(locked(state.points), locked(state.points), INSTANT_STEP, np.zeros(0))
        partial = _workspace.rows(len(self._sums.rows), 3)
        for group in self.groups:
            blocks = len(group.tables.nodes)
            out = ElementOutput(partial[group.rows], np.empty((0, KINDS)), np.empty(0, np.int32))
            memory = _memory(group, state, np.empty(self._remembered))
            run_ranges(KERNELS[group.kind][1], blocks, BLOCKS, motion, group.bound, memory, out)
        return np.asarray(self._at_nodes(partial).max(axis=1))


def _pressures(
    group: Group, average: Average, motion: Motion, out: ElementOutput
) -> tuple[FloatArray, float]:
    """Return λ (J̄ − 1) (m,), J̄ the mean of a node's elements by volume, and Σ V λ (J̄ − 1)²/2.

    Its gradient is Σ p̄ ∂v/∂x over elements of volume v, p̄ the mean of their corners' λ (J̄ − 1).
    """
    blocks, m = len(group.tables.nodes), len(average.volumes)
    run_ranges(elements_nb.tet_volumes, blocks, BLOCKS, motion, group.tables, out)
    sums = np.empty((m, 3))
    starts, rows = average.sums
    run_ranges(lanes_nb.sum_at_nodes, m, NODES, out.partial, starts, rows, sums)
    there = average.volumes > 0.0
    change = np.where(there, sums[:, 0] / np.where(there, average.volumes, 1.0) - 1.0, 0.0)
    pressures = average.modulus * change
    return pressures, 0.5 * float(np.sum(average.volumes * pressures * change))


def _memory(group: Group, state: MatterState, new: FloatArray) -> Memory:
    """Return a group's part of the memory of a state, and of the one to write."""
    blocks = len(group.tables.nodes)
    old = state.memory[group.memory].reshape(blocks, -1)
    return Memory(locked(old), new[group.memory].reshape(blocks, -1))


def _largest(group: Group, state: MatterState, column: int) -> float:
    """Return the largest value in a column of the memory of a group."""
    blocks = len(group.tables.nodes)
    lanes = state.memory[group.memory].reshape(blocks, -1, LANES)[:, column]
    return float(lanes.ravel()[: len(group.elements)].max())


def _inverted(group: Group, points: FloatArray, counts: IntArray) -> ElementError:
    """Return the error of the first element of a group that is inside out."""
    corners = points[group.elements]
    gradients = full_gradients(group)
    with np.errstate(invalid="ignore"):
        stretch = np.linalg.det(np.einsum("eai,eaj->eij", corners, gradients))
    element = int(np.flatnonzero(~(stretch > 0.0))[0])
    what = f"{group.kind} of {group.name}"
    return ElementError(what, element, corners[element].mean(axis=0), int(counts.sum()))


def full_gradients(group: Group) -> FloatArray:
    """Return the gradients (n, k, 3) of all corners of solids at rest."""
    n, corners = group.elements.shape
    blocks = len(group.tables.nodes)
    lanes = group.tables.gradients.reshape(blocks, -1, 3, LANES).transpose(0, 3, 1, 2)
    rows = lanes.reshape(blocks * LANES, -1, 3)[:n]
    if rows.shape[1] == corners:
        return np.asarray(rows)
    return np.concatenate([-rows.sum(axis=1, keepdims=True), rows], axis=1)
