"""Records of an LS-DYNA deck besides its mesh, and its contents that are not understood."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np

from contiga.io.mesh.lsdyna import Lumped
from contiga.io.mesh.lsdyna_cards import Block, Card, Row, unread_fields
from contiga.io.mesh.lsdyna_curves import DeckCurve, number_of, read_curves
from contiga.io.mesh.lsdyna_parts import Inertia, Parts, axes_of, read_parts
from contiga.io.mesh.lsdyna_soft import SoftLaw
from contiga.io.mesh.lsdyna_ties import NodeTie
from contiga.records import FloatArray

_NO_DEATH = 1e20
"""Death times above this one count as none; LS-DYNA's default is 1e28."""
_MAX_VALUES = 4
"""Largest number of values of a field in a message."""


class Material(NamedTuple):
    """The understood part of a *MAT."""

    density: float
    modulus: float
    poisson: float
    rigid: bool
    constraints: tuple[int, int]
    """CON1 and CON2 of a rigid material: codes of fixed translations and rotations, 0 for none."""
    block: Block
    soft: SoftLaw | None = None
    """Law of a deforming part of this material."""
    no_law_reason: str = ""
    """Reason why a material that may deform has no law."""


class DeckContact(NamedTuple):
    """A *CONTACT between two sides, of a kind (SSTYP) and a number (SSID) each."""

    block: Block
    sides: tuple[tuple[int, int], tuple[int, int]]
    """Kind and number of slave and master."""
    friction: tuple[float, float, float]
    """FS, FD, DC."""
    scales: Row
    """The third card, with the stiffness scales; the case reads it."""


class Prescribed(NamedTuple):
    """A *BOUNDARY_PRESCRIBED_MOTION_RIGID."""

    part: int
    direction: int
    """1, 2, 3: along x, y, z."""
    kind: int
    """0 velocity, 1 acceleration, 2 displacement."""
    curve: int
    """Number of the curve over time."""
    scale: float
    """Factor on its ordinates, SF."""
    block: Block
    line: int


class Start(NamedTuple):
    """Initial velocity and spin."""

    rates: tuple[float, ...]
    """vx, vy, vz, and the spin about x, y, z."""
    over: tuple[int, ...]
    """Parts whose own rates of *PART_INERTIA it replaces, IRIGID; 0 means all."""
    block: Block


class NodeStart(NamedTuple):
    """Initial velocity and spin of a node, from its card in `line` of the deck."""

    rates: tuple[float, ...]
    """vx, vy, vz, and the spin about x, y, z."""
    block: Block
    line: int


@dataclass
class DeckModel:
    """The understood contents of a deck."""

    path: Path
    blocks: list[Block] = field(default_factory=list)
    parts: Parts = field(default_factory=lambda: read_parts([]))
    curves: dict[int, DeckCurve] = field(default_factory=dict)
    tables: dict[int, list[tuple[float, int]]] = field(default_factory=dict)
    """Values and curves, by the number of the table."""
    part_sets: dict[int, list[int]] = field(default_factory=dict)
    node_sets: dict[int, list[int]] = field(default_factory=dict)
    other_sets: dict[tuple[str, int], Block] = field(default_factory=dict)
    """Sets of unknown type, by kind ("NODE", "PART") and number."""
    title: str = ""
    end: float = 0.0
    """Time at which the run ends, ENDTIM; 0 if it is not given."""
    state_interval: float = 0.0
    """Time between written states; 0 if it is not given."""
    materials: dict[int, Material] = field(default_factory=dict)
    contacts: list[DeckContact] = field(default_factory=list)
    motions: list[Prescribed] = field(default_factory=list)
    """Motions with usable curves, one for each part and direction."""
    ties: list[NodeTie] = field(default_factory=list)
    """Ties without those that have a problem."""
    velocities: dict[int, Start] = field(default_factory=dict)
    """Initial velocities by part; 0 means all."""
    node_velocities: dict[int, NodeStart] = field(default_factory=dict)
    """Initial velocities by node."""
    systems: dict[int, FloatArray] = field(default_factory=dict)
    """(3, 3) columns, the axes of *DEFINE_COORDINATE_SYSTEM and _VECTOR, by number."""
    masses: list[Lumped] = field(default_factory=list)
    part_masses: dict[int, Row] = field(default_factory=dict)
    """Cards of *ELEMENT_MASS_PART, by part."""
    gravity: dict[int, tuple[int, float, Block]] = field(default_factory=dict)
    """Gravity by axis (0 to 2): curve, scale, and block."""
    unresolved_curves: dict[int, Block] = field(default_factory=dict)
    """Curves with unresolved parameters, by number."""
    unknown: dict[str, list[int]] = field(default_factory=dict)
    """Lines of unknown contents, by keyword with details in brackets and included file."""

    def leave(self, block: Block, reason: str = "", line: int = 0) -> None:
        """Note in `unknown`, once for each line, that something of a keyword is not understood.

        Without `line` it is the line of the keyword. Its fields stay as read or unread as they are.
        """
        text = f"*{block.keyword}{f' ({reason})' if reason else ''}{self._file_of(block)}"
        lines = self.unknown.setdefault(text, [])
        if (line or block.line) not in lines:
            lines.append(line or block.line)

    def drop(
        self, block: Block, reason: str = "", line: int = 0, cards: Sequence[Card] = ()
    ) -> None:
        """Do as `leave`, and mark `cards`, all cards of the keyword if empty, as read.

        So `leave_unread` does not list their fields.
        """
        self.leave(block, reason, line)
        block.mark_read(*(cards or block.cards))

    def drop_curve(self, block: Block, reason: str) -> None:
        """Note that a curve is left out; its block is kept, and a case that needs it is refused."""
        self.unresolved_curves[number_of(block)] = block
        self.drop(block, reason)

    def leave_unread(self) -> None:
        """Note in `unknown` each field that is neither blank nor default and that no one has read.

        Blocks with the same keyword, file and unread names share an entry, which has up to
        `_MAX_VALUES` values of each name. All their cards then count as read.
        """
        entries: dict[tuple[str, ...], tuple[list[Block], dict[str, list[str]]]] = {}
        for block in self.blocks:
            fields = list(unread_fields(block))
            names = tuple(dict.fromkeys(name for name, _ in fields))
            if names:
                key = (block.keyword, self._file_of(block), *names)
                blocks, values = entries.setdefault(key, ([], {name: [] for name in names}))
                blocks.append(block)
                for name, text in fields:
                    if text not in values[name]:
                        values[name].append(text)
        for blocks, values in entries.values():
            reason = ", ".join(
                f"{name} {'/'.join(texts[:_MAX_VALUES])}{'/…' * (len(texts) > _MAX_VALUES)}"
                for name, texts in values.items()
            )
            for block in blocks:
                self.drop(block, reason)

    def no_set(self, kind: str, number: int) -> str:
        """Return why there is no set of a kind ("NODE", "PART") and number; "" if there is one."""
        if number in (self.node_sets if kind == "NODE" else self.part_sets):
            return ""
        other = self.other_sets.get((kind, number))
        if other is None:
            return f"there is no set of {kind.lower()}s {number}"
        return f"set {number} is a *{other.keyword}, {self.place(other)}, which is not understood"

    def nodes_of(self, mass: Lumped) -> list[int]:
        """Return the numbers of the nodes of a lumped mass; none if its set does not exist."""
        return self.node_sets.get(mass.number, []) if mass.of_set else [mass.number]

    def axes_of(self, inertia: Inertia) -> FloatArray | None:
        """Return the axes of a tensor as columns (3, 3); None if they are not understood.

        They are those of the system that its card names, or else of the vectors on the card, and
        without a card those of the world. Parallel vectors and unknown systems have none.
        """
        if inertia.axes is None:
            return np.eye(3)
        system = inertia.axes.whole("CID")
        if system:
            return self.systems.get(system)
        return axes_of(inertia.axes.reals("XL YL ZL"), inertia.axes.reals("XLIP YLIP ZLIP"))

    def ends_after(self, death: float) -> bool:
        """Return whether a death time lies before the end of the run; 0 means never.

        If the deck gives no end of the run, any other death time below 1e20 does.
        """
        return 0.0 < death < (self.end or _NO_DEATH)

    def place(self, block: Block, line: int = 0) -> str:
        """Return the place of a keyword or a card: its line, and an included file's name."""
        return f"line {line or block.line}{self._file_of(block)}"

    def _file_of(self, block: Block) -> str:
        return "" if block.path == self.path else f" of {block.path.name}"

    def curve(self, number: int) -> DeckCurve | None:
        """Return the curve of a number, or None if there is none.

        Raises
        ------
        MeshError
            It is one of `unresolved_curves`: a parameter has no value.
        """
        if number in self.unresolved_curves:
            read_curves([self.unresolved_curves[number]])
        return self.curves.get(number)
