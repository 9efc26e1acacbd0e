"""Records of what an LS-DYNA deck says beside its mesh, and of what is not understood."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from contiga.io.mesh.lsdyna_cards import Block
from contiga.io.mesh.lsdyna_curves import DeckCurve, number_of, read_curves
from contiga.io.mesh.lsdyna_parts import Parts, read_parts
from contiga.io.mesh.lsdyna_soft import SoftLaw
from contiga.io.mesh.lsdyna_ties import NodeTie

_FOREVER = 1e20
"""A death later than that is none; LS-DYNA's default is 1e28."""


class Material(NamedTuple):
    """What is understood of a *MAT."""

    density: float
    modulus: float
    poisson: float
    rigid: bool
    held: tuple[int, int]
    """CON1 and CON2 of a rigid one: which ways and turns are held."""
    block: Block
    soft: SoftLaw | None = None
    """What a part of it is made of where it deforms."""
    unmade: str = ""
    """Why it is none of what deforms, of a material that may."""


class DeckContact(NamedTuple):
    """A *CONTACT between two sides, of a kind (SSTYP) and a number (SSID) each."""

    block: Block
    sides: tuple[tuple[int, int], tuple[int, int]]
    """Kind and number of slave and master."""
    friction: tuple[float, float, float]
    """FS, FD, DC."""
    scale: float
    """Of the slave's penalty, SFS."""


class Prescribed(NamedTuple):
    """A *BOUNDARY_PRESCRIBED_MOTION_RIGID."""

    part: int
    way: int
    """1, 2, 3: along x, y, z."""
    kind: int
    """0 velocity, 1 acceleration, 2 displacement."""
    curve: int
    scale: float
    block: Block
    line: int


class Start(NamedTuple):
    """Velocity and spin at the start."""

    rates: tuple[float, ...]
    """vx, vy, vz, and the spin about x, y, z."""
    over: tuple[int, ...]
    """Parts whose own rates of *PART_INERTIA it replaces, IRIGID; 0 stands for all."""
    block: Block


class NodeStart(NamedTuple):
    """Velocity and spin of a node at the start."""

    rates: tuple[float, ...]
    """vx, vy, vz, and the spin about x, y, z."""
    block: Block
    line: int


@dataclass
class DeckModel:
    """What a deck says, as far as it is understood."""

    path: Path
    parts: Parts = field(default_factory=lambda: read_parts([]))
    curves: dict[int, DeckCurve] = field(default_factory=dict)
    part_sets: dict[int, list[int]] = field(default_factory=dict)
    title: str = ""
    end: float = 0.0
    materials: dict[int, Material] = field(default_factory=dict)
    contacts: list[DeckContact] = field(default_factory=list)
    motions: list[Prescribed] = field(default_factory=list)
    ties: list[NodeTie] = field(default_factory=list)
    velocities: dict[int, Start] = field(default_factory=dict)
    """By part; 0 stands for all."""
    node_velocities: dict[int, NodeStart] = field(default_factory=dict)
    """By node."""
    gravity: dict[int, tuple[int, float, Block]] = field(default_factory=dict)
    """By axis (0 to 2): curve, scale, where it is said."""
    unread: dict[int, Block] = field(default_factory=dict)
    """Curves with parameters without a value, by number."""
    unknown: dict[str, list[int]] = field(default_factory=dict)
    """Lines of what is not understood, by keyword, in brackets what of it, and included file."""

    def leave(self, block: Block, why: str = "", line: int = 0) -> None:
        """Note that a keyword, or something of it, is not understood."""
        text = f"*{block.keyword}{f' ({why})' if why else ''}{self._file_of(block)}"
        lines = self.unknown.setdefault(text, [])
        if (line or block.line) not in lines:
            lines.append(line or block.line)

    def leave_curve(self, block: Block, why: str) -> None:
        """The same of a curve, whose block is kept: a case that needs it is refused."""
        self.unread[number_of(block)] = block
        self.leave(block, why)

    def ends_after(self, death: float) -> bool:
        """Whether something is over before the run is; a death of 0 is none."""
        return 0.0 < death < (self.end or _FOREVER)

    def place(self, block: Block, line: int = 0) -> str:
        """Where a keyword, or a card of it, stands: its line, and an included file's name."""
        return f"line {line or block.line}{self._file_of(block)}"

    def _file_of(self, block: Block) -> str:
        return "" if block.path == self.path else f" of {block.path.name}"

    def curve(self, number: int) -> DeckCurve | None:
        """A curve; None where there is none.

        Raises
        ------
        MeshError
            It has parameters without a value.
        """
        if number in self.unread:
            read_curves([self.unread[number]])
        return self.curves.get(number)
