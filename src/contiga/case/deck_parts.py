"""The parts of an LS-DYNA deck as tables of a case: names, masses, motions, laws."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.errors import InputError, MeshError
from contiga.io.mesh.lsdyna_deck import DeckModel, Material, Prescribed, Start
from contiga.io.mesh.lsdyna_parts import Inertia
from contiga.io.mesh.lsdyna_sets import set_name
from contiga.io.mesh.raw import Group, RawMesh
from contiga.io.mesh.read_master import master_of
from contiga.io.mesh.read_mesh import read_raw, slave_of
from contiga.records import FloatArray, MassProperties
from contiga.rigid.inertia import combined, of_points
from contiga.slaves.cells import SHELLS

_RATES = ("vx", "vy", "vz", "a spin about x", "a spin about y", "a spin about z")
_HELD_AXES = {1: "x", 2: "y", 3: "z", 4: "xy", 5: "yz", 6: "zx", 7: "xyz"}
"""Directions by the values of CON1 and CON2 of a *MAT_RIGID."""
_PENALTY_FACTOR = 0.1
"""Share of the bulk modulus in LS-DYNA's penalty stiffness by default, SLSFAC."""
_JUMP_TIME = 1e-6
"""Time between the two values of a step in a curve, as a share of the run."""
_THICKNESS_TOL = 1e-9
"""Relative difference up to which thicknesses are equal."""


class _Facets(NamedTuple):
    """Facets of a skin."""

    corners: FloatArray
    """(m, 3, 3)"""
    thickness: FloatArray
    """(m,) thickness of shells; 0 if the deck gives none."""


class DeckParts:
    """Parts of a deck and their tables in a case.

    Parameters
    ----------
    model : the deck without its mesh
    folder : where the case will stand
    units : of the deck: length, mass, time
    """

    def __init__(self, model: DeckModel, folder: Path, units: tuple[str, str, str]) -> None:
        self.model = model
        self.folder = folder
        self.units = units
        self.file = case_name(model.path, folder)
        """The deck's file name in the case."""
        self._names: dict[str, str] = {}
        self._skins: dict[tuple[str | int, ...], _Facets] = {}
        self._nodes_with_velocity: set[int] = set()
        """Numbers of nodes whose initial velocity a part has taken."""
        self.shared_parts: set[int] = set()
        """Parts that are in several slaves of the case."""
        self.used_ties: set[tuple[str, int, int]] = set()
        """Keys of ties of deforming nodes, and of ties reported elsewhere."""
        self.nodes_with_mass: set[int] = set()
        """Numbers of nodes whose lumped masses slaves that deform have."""

    @cached_property
    def mesh(self) -> RawMesh:
        """Nodes and elements."""
        return read_raw(self.model.path)

    @cached_property
    def groups(self) -> dict[int, Group]:
        """Parts that have elements, by number."""
        return {group.id: group for group in self.mesh.groups if group.id is not None}

    def _facets(self, parts: list[str | int]) -> _Facets:
        """Return corners and thicknesses of the facets of the skin of parts; they are cached."""
        key = tuple(parts)
        if key not in self._skins:
            slave = slave_of(self.mesh, self.model.path, chosen=(parts, None, "skin"))
            facets = np.zeros((0, 3), np.int64) if slave.facets is None else slave.facets
            thickness = slave.thickness
            if thickness is None:
                thickness = np.zeros(len(slave.points))
            self._skins[key] = _Facets(slave.points[facets], thickness[facets].mean(axis=1))
        return self._skins[key]

    def material(self, part: int) -> Material | None:
        """Return the material of a part; None if it is not understood."""
        return self.model.materials.get(self.model.parts.materials.get(part, -1))

    def is_rigid(self, part: int) -> bool:
        """Return whether a part is rigid."""
        material = self.material(part)
        return material is not None and material.rigid

    def name(self, part: int) -> str:
        """Return the name of a part in the case: its title, if it is unique."""
        return self._unique_name(f"part {part}", self.model.parts.titles.get(part, ""))

    def _unique_name(self, key: str, title: str) -> str:
        """Return the title without special characters, the same name at each call for a `key`.

        It is the key itself if the title is empty, "ground", or the name of another part.
        """
        if key not in self._names:
            name = re.sub(r"[^\w -]+", " ", title, flags=re.ASCII).strip(" -")
            reserved = {*self._names.values(), "ground", ""}
            self._names[key] = key if name in reserved else name
        return self._names[key]

    def slave_name(self, parts: tuple[int, ...]) -> str:
        """Return the name of several parts together in the case."""
        if len(parts) == 1:
            return self.name(parts[0])
        return self._unique_name(f"parts {' '.join(map(str, parts))}"[:60], "")

    def nodes_name(self, number: int) -> str:
        """Return the name in the case of the slave of a set of nodes."""
        return self._unique_name(set_name(number), "")

    def owner(self, number: int) -> int | None:
        """Return the first rigid part that all nodes of a set belong to; None if there is none."""
        nodes = next((g.nodes for g in self.mesh.groups if g.name == set_name(number)), None)
        if nodes is None:
            return None
        for part, group in self.groups.items():
            if self.is_rigid(part) and np.isin(nodes, self.nodes_of(group)).all():
                return part
        return None

    def part_of(self, number: int) -> int | None:
        """Return the part with the most nodes of a set, of equals the first; None without any."""
        nodes = next((g.nodes for g in self.mesh.groups if g.name == set_name(number)), None)
        if nodes is None:
            return None
        counts = {
            part: np.count_nonzero(np.isin(nodes, self.nodes_of(group)))
            for part, group in self.groups.items()
        }
        part = max(counts, key=lambda part: counts[part], default=None)
        return part if part is not None and counts[part] > 0 else None

    def nodes_of(self, group: Group) -> Any:
        """Return the rows (k,) of the mesh's nodes that the elements of a group have, rising."""
        nodes = [
            block.nodes[rows].ravel()
            for block, rows in zip(self.mesh.blocks, group.cells or (), strict=True)
        ]
        return np.unique(np.concatenate(nodes))

    def geometry(self, part: int) -> dict[str, Any]:
        """Return the `geometry` of a rigid part; its shells get consistent normals."""
        orient = {"orient": True} if self.is_shell(part) else {}
        return {"mesh": self.file, "parts": [part], **orient}

    def is_shell(self, part: int) -> bool:
        """Return whether there are shells in a part."""
        blocks = zip(self.mesh.blocks, self.groups[part].cells or (), strict=True)
        return any(block.kind in SHELLS and len(rows) > 0 for block, rows in blocks)

    def thickness(self, part: int) -> float:
        """Return the one thickness of the shells of a part, equal up to 1e-9, in 12 digits.

        Raises
        ------
        InputError
            There is none, or more than one.
        """
        thickness = self._facets([part]).thickness
        low, high = float(thickness.min(initial=np.inf)), float(thickness.max(initial=0.0))
        if not 0.0 < low <= high:
            raise InputError("have no thickness", where="its shells")
        if high - low > _THICKNESS_TOL * high:
            raise InputError(f"have thicknesses from {low:g} to {high:g}", where="its shells")
        return float(f"{high:.12g}")  # the mean of the corners is rounded

    def mass(self, part: int) -> tuple[dict[str, Any], str]:
        """Return the `mass` table of a rigid part, and its source in words.

        *PART_INERTIA gives all of it; else its elements count, and lumped masses on its nodes.
        Axes of *PART_INERTIA that are not understood, and shells without a thickness (1 is taken),
        are noted.

        Raises
        ------
        MeshError
            It has no mass.
        """
        inertia, material = self.model.parts.inertia.get(part), self.material(part)
        assert material is not None
        if inertia is not None and inertia.mass > 0.0:
            source = "*PART_INERTIA"
            if self.model.axes_of(inertia) is None:
                fault = "its own axes are not understood, those of the world are taken"
                self.model.leave(inertia.block, f"part {part}: {fault}")
                source += ", its own axes taken for those of the world"
            return _table(self._card_inertia(inertia)), source
        shells, lumped = self.is_shell(part), self._lumped_inertia(part)
        has_density_alone = not shells and lumped is None and part not in self.model.part_masses
        if has_density_alone and material.density > 0.0:
            return {"density": material.density}, f"density of the *{material.block.keyword}"
        elements = (self._shell_inertia if shells else self._solid_inertia)(part, material)
        bodies = [body for body in (elements, lumped) if body is not None]
        if not bodies:
            raise MeshError(
                "is free to move and has no mass",
                where=f"{self.model.path}: part {part}",
                found=f"density {material.density:g} in *{material.block.keyword}, "
                f"{self.model.place(material.block)}",
                allowed="a density above zero, or *PART_INERTIA",
            )
        source = "its shells at their thickness" if shells else "its solids at their density"
        if shells and not (self._facets([part]).thickness > 0.0).all():
            fault = f"part {part}, its shells have no thickness: 1 is taken for its mass"
            self.model.leave(material.block, fault)
            source = "its shells at a thickness of 1, as the deck has none: set it"
        if lumped is not None:
            source += f", and {lumped.mass:g} on its nodes by *ELEMENT_MASS"
        return _table(combined(bodies)), source

    def _card_inertia(self, inertia: Inertia) -> MassProperties:
        """Return the mass properties of a *PART_INERTIA, in world axes.

        The centre is its node, if it names one. Axes that are not understood count as the world's.
        """
        xx, xy, xz, yy, yz, zz = inertia.tensor
        tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        centre = np.array(inertia.centre)
        if inertia.node and self.mesh.node_ids is not None:
            rows = np.flatnonzero(self.mesh.node_ids == inertia.node)
            centre = self.mesh.points[rows[0]] if len(rows) else centre
        axes = self.model.axes_of(inertia)
        if axes is not None and not np.array_equal(axes, np.eye(3)):
            tensor = axes @ tensor @ axes.T
        return MassProperties(inertia.mass, centre, tensor)

    def _shell_inertia(self, part: int, material: Material) -> MassProperties | None:
        """Return the mass properties of shells, as sheets without thickness; None without mass.

        The mass per area of their section and of *ELEMENT_MASS_PART is included; shells without a
        thickness count as 1 thick. Points at the middles of the three edges are exact for a facet.
        """
        corners, thickness = self._facets([part])
        thickness = np.where(thickness > 0.0, thickness, 1.0)
        areas = _areas(corners)
        masses = areas * (thickness * material.density + self._area_mass(part))
        masses += self._added_mass(part, float(masses.sum())) * areas / areas.sum()
        middles = 0.5 * (corners + np.roll(corners, 1, axis=1)).reshape(-1, 3)
        return of_points(middles, np.repeat(masses / 3.0, 3)) if masses.sum() > 0.0 else None

    def _solid_inertia(self, part: int, material: Material) -> MassProperties | None:
        """Return the mass properties of solids, with the mass that *ELEMENT_MASS_PART adds.

        It is spread evenly over the volume. None without mass.
        """
        if material.density <= 0.0 and part not in self.model.part_masses:
            return None
        at_density_one = self._volume(part)
        mass = material.density * at_density_one.mass
        density = (mass + self._added_mass(part, mass)) / at_density_one.mass
        if density <= 0.0:
            return None
        return at_density_one._replace(
            mass=density * at_density_one.mass, inertia=density * at_density_one.inertia
        )

    def _volume(self, part: int) -> MassProperties:
        """Return the mass properties of the solids of a part at a density of 1."""
        slave = slave_of(self.mesh, self.model.path, chosen=([part], None, "skin"))
        where = f"{self.model.path}: part {part}"
        return master_of(slave, where=where).compact().mass_properties(1.0)

    def _area_mass(self, part: int) -> float:
        """Return the mass per area that the section of a part adds, MAREA."""
        return self.model.parts.added.get(self.model.parts.sections.get(part, -1), 0.0)

    def _added_mass(self, part: int, mass: float) -> float:
        """Return the mass that *ELEMENT_MASS_PART adds to a part whose elements have `mass`.

        A final mass FINMASS replaces ADDMASS, and may take mass away. Zero without such a card.
        """
        row = self.model.part_masses.get(part)
        if row is None:
            return 0.0
        added, final = row.reals("ADDMASS FINMASS")
        return final - mass if final > 0.0 else added

    def density(self, part: int) -> float:
        """Return the density of a deforming part, with the mass that cards add to it.

        Raises
        ------
        InputError
            Its shells have no thickness, or several.
        """
        material = self.material(part)
        assert material is not None
        density = material.density
        if self.is_shell(part):
            thickness = self.thickness(part)
            density += self._area_mass(part) / thickness
            if part in self.model.part_masses:
                volume = float(_areas(self._facets([part]).corners).sum()) * thickness
                density += self._added_mass(part, density * volume) / volume
        elif part in self.model.part_masses:
            volume = self._volume(part).mass
            density += self._added_mass(part, density * volume) / volume
        return density

    def _nodes_of(self, part: int) -> NDArray[np.bool_]:
        """Return a mask (n,) of the nodes of a rigid part, and of nodes that cards add to it."""
        mask = np.zeros(len(self.mesh.points), np.bool_)
        mask[self.nodes_of(self.groups[part])] = True
        names = {tie.nodes for tie in self.model.ties if tie.part == part}
        for group in self.mesh.groups:
            if group.name in names and group.nodes is not None:
                mask[group.nodes] = True
        return mask

    def _lumped_inertia(self, part: int) -> MassProperties | None:
        """Return the mass properties of the lumped masses on nodes of a rigid part; None without.

        Cards that add nodes with a mass to the part are marked as used in `used_ties`.
        """
        if self.mesh.mass is None:
            return None
        rows = np.flatnonzero(self._nodes_of(part) & (self.mesh.mass > 0.0))
        if not len(rows):
            return None
        row_set = set(rows.tolist())
        for group in self.mesh.groups:
            if group.nodes is not None and row_set.intersection(group.nodes.tolist()):
                ties = [t for t in self.model.ties if t.part == part and t.nodes == group.name]
                self.used_ties.update(tie.key for tie in ties)
        return of_points(self.mesh.points[rows], self.mesh.mass[rows])

    def masses(self, nodes: NDArray[np.bool_], hosts: Iterable[int]) -> dict[str, Any] | None:
        """Return the table of lumped masses on deforming nodes (n,), or None if there are none.

        Masses on nodes of its rigid hosts are left out.
        """
        if self.mesh.mass is None or self.mesh.node_ids is None:
            return None
        has_mass = nodes & (self.mesh.mass > 0.0)
        for part in hosts:
            has_mass &= ~self._nodes_of(part)
        rows = np.flatnonzero(has_mass)
        if not len(rows):
            return None
        return {"nodes": self.mesh.node_ids[rows].tolist(), "mass": self.mesh.mass[rows].tolist()}

    def leave_masses(self, bodies: Iterable[int]) -> None:
        """Note the lumped masses that neither rigid `bodies` nor slaves that deform have.

        They are on nodes that are not in `nodes_with_mass`; the note has their number.
        """
        if self.mesh.mass is None or self.mesh.node_ids is None:
            return
        carried = np.zeros(len(self.mesh.points), np.bool_)
        for part in bodies:
            carried |= self._nodes_of(part)
        unused = (
            set(self.mesh.node_ids[~carried & (self.mesh.mass > 0.0)].tolist())
            - self.nodes_with_mass
        )
        for block in {id(card.block): card.block for card in self.model.masses}.values():
            cards = [card for card in self.model.masses if card.block is block]
            nodes = {node for card in cards for node in self.model.nodes_of(card)} & unused
            if nodes:
                text = f"{len(nodes)} nodes of nothing that moves here, first {min(nodes)}"
                self.model.leave(block, f"{text}: their masses are left out")

    def free_motion(self, part: int) -> dict[str, Any] | None:
        """Return the `motion` of a rigid part that forces move; None if it is fully held.

        It has the initial velocity and spin, and the directions that its material holds.
        """
        material = self.material(part)
        assert material is not None
        directions, rotations = (_HELD_AXES.get(code, "") for code in material.constraints)
        if len(directions) == len(rotations) == 3:
            return None
        rates = self._start(part)
        motion: dict[str, Any] = {"kind": "free"}
        for key, values in (("velocity", rates[:3]), ("spin", rates[3:])):
            if any(values):
                motion[key] = list(values)
        if directions or rotations:
            motion["hold"] = [*directions, *(f"r{axis}" for axis in rotations)]
        return motion

    def _start(self, part: int) -> tuple[float, ...]:
        """Return initial velocity and spin (6 numbers), zero if no card gives them.

        *PART_INERTIA precedes *INITIAL_VELOCITY, unless that card has IRIGID; a card that has no
        effect is noted.
        """
        inertia, start = self.model.parts.inertia.get(part), self._start_of_cards(part)
        if inertia is None:
            return (0.0,) * 6 if start is None else start.rates
        rates = (*inertia.velocity, *inertia.spin)
        if start is None:
            return rates
        if 0 in start.over or part in start.over:
            return start.rates
        if start.rates != rates:
            self.model.leave(start.block, f"part {part} has that of its *PART_INERTIA, IRIGID")
        return rates

    def _start_of_cards(self, part: int) -> Start | None:
        """Return the start of a part by *INITIAL_VELOCITY; None if no card gives it.

        A card of the part precedes cards of its nodes, if these give all nodes one velocity without
        a spin (the nodes are then marked as started), and these precede a card of all parts.
        """
        if start := self.model.velocities.get(part):
            return start
        by_node, node_ids = self.model.node_velocities, self.mesh.node_ids
        if by_node and node_ids is not None:
            nodes = node_ids[self.nodes_of(self.groups[part])].tolist()
            starts = [by_node[node] for node in nodes if node in by_node]
            is_one_velocity = len({start.rates for start in starts}) <= 1
            if len(starts) == len(nodes) and is_one_velocity and not any(starts[0].rates[3:]):
                self._nodes_with_velocity.update(nodes)
                return Start(starts[0].rates, (), starts[0].block)
        return self.model.velocities.get(0)

    def common_velocity(self, parts: list[int]) -> list[float] | None:
        """Return the initial velocity of some parts; None if all are at rest.

        Velocities that differ, or come with a spin, are noted, and give None.
        """
        starts = [self._start_of_cards(part) for part in parts]
        moving = [start for start in starts if start is not None and any(start.rates)]
        if not moving:
            return None
        rates, block = moving[0].rates, moving[0].block
        if any(start is None or start.rates != rates for start in starts) or any(rates[3:]):
            self.model.leave(block, "parts that deform start all with one velocity, without a spin")
            return None
        return list(rates[:3])

    def leave_ties(self) -> None:
        """Note the ties that are not in `used_ties`: their nodes belong to nothing that deforms."""
        for tie in self.model.ties:
            if tie.key not in self.used_ties:
                no_set = "" if tie.is_single else self.model.no_set("NODE", tie.number)
                fault = no_set or f"{tie.nodes}: of no part that deforms here"
                self.model.leave(tie.block, fault, tie.line)

    def leave_nodes(self) -> None:
        """Note the nodes whose initial velocity no part uses: their number, and the first."""
        nodes = [
            node for node in self.model.node_velocities if node not in self._nodes_with_velocity
        ]
        if nodes:
            first = self.model.node_velocities[nodes[0]]
            text = f"{len(nodes)} nodes, first {nodes[0]}"
            fault = f"{text}: not all those of a rigid part, at one velocity"
            self.model.leave(first.block, fault, first.line)

    def prescribed_motion(self, part: int, end: float) -> dict[str, Any] | None:
        """Return the `motion` that the deck prescribes for a part; None if it prescribes none.

        The first card decides whether it is velocity, acceleration or displacement; directions
        without a card stand still, or keep their initial velocity if it is an acceleration. Initial
        rates that get lost are noted.
        """
        motions = [m for m in self.model.motions if m.part == part]
        if not motions:
            return None
        kind = ("velocity", "acceleration", "translate")[motions[0].kind]
        motion = {"kind": kind, "table": self._over_time(motions, end).tolist()}
        start = list(self._start(part))
        if kind == "acceleration" and any(start[:3]):
            motion["velocity"] = start[:3]
            start[:3] = [0.0] * 3
        for card in motions:
            start[card.direction - 1] = 0.0
        unused = [name for name, rate in zip(_RATES, start, strict=True) if rate]
        if unused:
            fault = f"part {part} starts with {', '.join(unused)}, which is left out"
            self.model.leave(motions[0].block, fault, motions[0].line)
        return motion

    def _over_time(self, motions: list[Prescribed], end: float) -> FloatArray:
        """Return rows t, x, y, z (n, 4) from the start to the end; the last value is held.

        If a curve has two values at a time, the first of them comes just before it.
        """
        curves = [self.model.curve(motion.curve) for motion in motions]
        tables = [curve.table for curve in curves if curve is not None]
        steps = [table[1:, 0][np.diff(table[:, 0]) == 0.0] for table in tables]
        before_jumps = np.concatenate(steps) - _JUMP_TIME * end
        times = np.unique(np.concatenate([[0.0, end], before_jumps, *(t[:, 0] for t in tables)]))
        times = times[(times >= 0.0) & (times <= end)]
        rows = np.zeros((len(times), 4))
        rows[:, 0] = times
        for motion, table in zip(motions, tables, strict=True):
            rows[:, motion.direction] = motion.scale * np.interp(times, table[:, 0], table[:, 1])
        return rows

    def law(self, selection: list[str | int], part: int | None, scale: float) -> str:
        """Return two lines of a case, a comment and the `law` of a contact on a slave.

        It is a penalty per area as in LS-DYNA: 0.1 · `scale` · bulk modulus / size of facets, or 1
        if the deck has no modulus. `part` is the part of the slave, or of most of its nodes, and
        its facets count if the selection has none; without any the size is 1.
        """
        material = None if part is None else self.material(part)
        size = self.size_of_facets(selection) or (
            self.size_of_facets([part]) if part is not None else 0.0
        )
        bulk = 0.0
        if material is not None and material.poisson < 0.5:
            bulk = material.modulus / (3.0 * (1.0 - 2.0 * material.poisson))
        stiffness = _PENALTY_FACTOR * scale * bulk / (size or 1.0) if bulk else 1.0
        source = "the deck has no modulus that is understood: set it"
        if bulk:
            source = f"0.1 × {scale:g} × bulk modulus {bulk:.4g} / facets of {size or 1.0:.4g}"
        return (
            f"# stiffness, a stress over a penetration: {source}\n"
            f'law = {{ kind = "penalty", stiffness = {stiffness:.6g}, per_area = true }}'
        )

    def size_of_facets(self, parts: list[str | int]) -> float:
        """Return the root of twice the mean area of the facets, length; 0 if there are none."""
        areas = _areas(self._facets(parts).corners)
        return float(np.sqrt(2.0 * areas.mean())) if len(areas) else 0.0

    def has_facets(self, parts: list[str | int]) -> bool:
        """Return whether the skin of `parts` has facets, whose areas weight contact forces."""
        return len(self._facets(parts).corners) > 0


def _areas(corners: FloatArray) -> FloatArray:
    """Return the areas (m,) of facets (m, 3, 3)."""
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return np.asarray(0.5 * np.linalg.norm(normals, axis=1))


def _table(mass: MassProperties) -> dict[str, Any]:
    """Return the `mass` table of a case, by total, centre and inertia."""
    entries = [mass.inertia[i, j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))]
    return {
        "total": float(mass.mass),
        "centre": mass.centre.tolist(),
        "inertia": [float(entry) for entry in entries],
    }


def case_name(path: Path, folder: Path) -> str:
    """Return the path of a file from a case in `folder`; the absolute path on another drive."""
    try:
        return Path(os.path.relpath(path.resolve(), folder.resolve())).as_posix()
    except ValueError:  # on another drive
        return path.resolve().as_posix()
