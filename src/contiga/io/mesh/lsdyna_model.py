"""What an LS-DYNA deck says beside its mesh: rigid parts, contacts, motions, times.

What is not understood is kept by keyword, with the lines it stands in. Card layouts: LS-DYNA
Keyword User's Manual, volumes I and II.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from contiga.errors import FileError, MeshError
from contiga.io.mesh.lsdyna_cards import Block, Card, fields, read_blocks, real, whole
from contiga.io.mesh.lsdyna_curves import DeckCurve, is_curve, read_curves
from contiga.io.mesh.lsdyna_parts import Parts, read_parts
from contiga.io.mesh.lsdyna_sets import is_set, read_sets

_TEN = (10,) * 8
_MESH = ("NODE", "ELEMENT_MASS", "TITLE")
_MESH_STARTS = ("ELEMENT_SHELL", "ELEMENT_SOLID", "ELEMENT_TSHELL", "PART", "SECTION_")
# Materials whose first card begins with number, density, modulus; the share says whether Poisson's
# ratio comes next.
_ELASTIC = {
    "ELASTIC": True,
    "001": True,
    "PLASTIC_KINEMATIC": True,
    "003": True,
    "RIGID": True,
    "020": True,
    "PIECEWISE_LINEAR_PLASTICITY": True,
    "024": True,
    "LOW_DENSITY_FOAM": False,
    "057": False,
    "CRUSHABLE_FOAM": True,
    "063": True,
    "FU_CHANG_FOAM": False,
    "083": False,
}
_RIGID = ("RIGID", "020")
_OTHER_CONTACTS = ("TIED", "TIEBREAK", "2D", "DRAWBEAD")


class Material(NamedTuple):
    """What is understood of a *MAT."""

    density: float
    modulus: float
    poisson: float
    rigid: bool
    held: tuple[int, int]
    """CON1 and CON2 of a rigid one: which ways and turns are held."""
    keyword: str
    line: int


class DeckContact(NamedTuple):
    """A *CONTACT between two sides, of a kind (SSTYP) and a number (SSID) each."""

    keyword: str
    line: int
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
    line: int


@dataclass
class DeckModel:
    """What a deck says, as far as it is understood."""

    path: Path
    parts: Parts
    curves: dict[int, DeckCurve]
    part_sets: dict[int, list[int]]
    title: str = ""
    end: float = 0.0
    materials: dict[int, Material] = field(default_factory=dict)
    contacts: list[DeckContact] = field(default_factory=list)
    motions: list[Prescribed] = field(default_factory=list)
    velocities: dict[int, tuple[float, ...]] = field(default_factory=dict)
    """Velocity and spin at the start by part; 0 stands for all."""
    gravity: dict[int, tuple[int, float, int]] = field(default_factory=dict)
    """By axis (0 to 2): curve, scale, line."""
    unknown: dict[str, list[int]] = field(default_factory=dict)
    """Lines of what is not understood, by keyword and, in brackets, what of it."""

    def leave(self, block: Block, why: str = "") -> None:
        """Note that a keyword, or something of it, is not understood."""
        told = f"*{block.keyword}{f' ({why})' if why else ''}"
        self.unknown.setdefault(told, []).append(block.line)


def read_model(path: Path) -> DeckModel:
    """Read what a deck says beside its mesh.

    Raises
    ------
    FileError
        Not a keyword deck, or an included file is missing.
    MeshError
        A field that should be a number is none.
    """
    try:
        blocks = list(read_blocks(path))
    except OSError as error:
        raise FileError(f"cannot be read ({error.strerror})", where=str(path)) from error
    if not blocks:
        raise FileError("not an LS-DYNA keyword deck", where=str(path), allowed="a file with *NODE")
    model = DeckModel(path, read_parts(blocks), read_curves(blocks), read_sets(blocks, "PART"))
    for block in blocks:
        _take(block, model)
    model.motions = list(_possible(model))
    return model


def _possible(model: DeckModel) -> Iterator[Prescribed]:
    """Motions whose curve is there, of one kind for each part; others are noted."""
    kinds: dict[int, int] = {}
    for one in model.motions:
        why = ""
        if one.curve not in model.curves:
            why = f"part {one.part}, there is no curve {one.curve}"
        elif kinds.setdefault(one.part, one.kind) != one.kind:
            why = f"part {one.part}, VAD {one.kind} beside VAD {kinds[one.part]}"
        if why:
            told = f"*{_PRESCRIBED[0]} ({why})"
            model.unknown.setdefault(told, []).append(one.line)
        else:
            yield one


def _take(block: Block, model: DeckModel) -> None:
    name = block.keyword
    if name == "TITLE" and block.cards:
        model.title = block.cards[0].text.strip()
    if name in _MESH or name.startswith(_MESH_STARTS) or is_curve(block):
        return
    if is_set(block, "NODE") or is_set(block, "PART"):
        return
    reader = next((read for start, read in _READERS.items() if name.startswith(start)), None)
    if reader is None:
        model.leave(block)
        return
    try:
        reader(block, model)
    except MeshError:
        if not any("&" in card.text for card in block.cards):
            raise
        model.leave(block, "parameters are not worked out")


def _rows(block: Block) -> list[tuple[Card, list[str]]]:
    """Cards with their fields; one that is empty in the midst of others has all its defaults."""
    return [(card, fields(card, block, _TEN)) for card in block.cards]


def _reals(block: Block, card: Card, texts: list[str]) -> tuple[float, ...]:
    return tuple(real(text, block, card) for text in texts)


def _material(block: Block, model: DeckModel) -> None:
    kind = block.keyword.removeprefix("MAT_").removesuffix("_TITLE")
    rows = _rows(block)[block.keyword.endswith("_TITLE") :]
    if kind not in _ELASTIC or not rows:
        model.leave(block)
        return
    card, texts = rows[0]
    density, modulus, poisson = _reals(block, card, texts[1:4])
    rigid, held = kind in _RIGID, (0, 0)
    if rigid and len(rows) > 1:
        card_2, constraint = rows[1]
        code, ways, turns = (int(real(text, block, card_2)) for text in constraint[:3])
        if code > 0:
            held = ways, turns
        elif code < 0:
            model.leave(block, "held in axes of its own")
    model.materials[whole(texts[0], block, card)] = Material(
        density, modulus, poisson if _ELASTIC[kind] else 0.0, rigid, held, block.keyword, block.line
    )


def _contact(block: Block, model: DeckModel) -> None:
    words, rows = block.keyword, _rows(block)
    for option in ("_ID", "_TITLE"):
        if words.endswith(option):
            words, rows = words.removesuffix(option), rows[1:]
    known = words.endswith(("SURFACE_TO_SURFACE", "NODES_TO_SURFACE", "SINGLE_SURFACE"))
    if not known or any(word in words for word in _OTHER_CONTACTS) or len(rows) < 2:
        model.leave(block)
        return
    (first, who), (second, rub) = rows[:2]
    a, b, kind_a, kind_b = (whole(text, block, first) for text in who[:4])
    scale = _reals(block, rows[2][0], rows[2][1][:1])[0] if len(rows) > 2 else 0.0
    if words.endswith("SINGLE_SURFACE"):
        b, kind_b = a, kind_a
    friction = _reals(block, second, rub[:3])
    model.contacts.append(
        DeckContact(
            block.keyword,
            block.line,
            ((kind_a, a), (kind_b, b)),
            (friction[0], friction[1], friction[2]),
            scale or 1.0,
        )
    )


def _prescribed(block: Block, model: DeckModel) -> None:
    if block.keyword not in _PRESCRIBED:
        model.leave(block)
        return
    rows = [row for row in _rows(block) if row[0].text.strip()]
    for card, texts in rows[1::2] if block.keyword.endswith("_ID") else rows:
        part, way, kind, curve = (whole(text, block, card) for text in texts[:4])
        (scale,) = _reals(block, card, texts[4:5])
        if way not in (1, 2, 3) or kind not in (0, 1, 2):
            model.leave(block, f"part {part}, DOF {way}, VAD {kind}")
            continue
        if any(_reals(block, card, texts[6:8])):
            model.leave(block, f"part {part}, DEATH and BIRTH")
        model.motions.append(Prescribed(part, way, kind, curve, scale or 1.0, card.line))


def _initial(block: Block, model: DeckModel) -> None:
    rows = _rows(block)
    if block.keyword == "INITIAL_VELOCITY_RIGID_BODY":
        for card, texts in rows:
            if part := whole(texts[0], block, card):
                model.velocities[part] = _reals(block, card, texts[1:7])
    elif block.keyword == "INITIAL_VELOCITY_GENERATION":
        for (card, texts), _ in zip(rows[::2], rows[1::2], strict=False):
            _generated(block, card, texts, model)
    elif block.keyword == "INITIAL_VELOCITY" and len(rows) > 1:
        if whole(rows[0][1][0], block, rows[0][0]):
            model.leave(block, "of a set of nodes")
            return
        model.velocities[0] = _reals(block, rows[1][0], rows[1][1][:6])
    else:
        model.leave(block)


def _generated(block: Block, card: Card, texts: list[str], model: DeckModel) -> None:
    number, kind = (whole(text, block, card) for text in texts[:2])
    omega, *velocity = _reals(block, card, texts[2:6])
    if omega or kind not in (1, 2):
        model.leave(block, "a turn" if omega else "of a set of nodes")
        return
    parts = [number] if kind == 2 else model.part_sets.get(number, [])
    for part in parts or [0]:
        model.velocities[part] = (*velocity, 0.0, 0.0, 0.0)


def _gravity(block: Block, model: DeckModel) -> None:
    axis = "XYZ".find(block.keyword.removeprefix("LOAD_BODY_"))
    rows = _rows(block)
    if axis < 0 or len(block.keyword) != len("LOAD_BODY_X") or not rows:
        model.leave(block)
        return
    card, texts = rows[0]
    (scale,) = _reals(block, card, texts[1:2])
    model.gravity[axis] = whole(texts[0], block, card), scale or 1.0, block.line


def _termination(block: Block, model: DeckModel) -> None:
    for card, texts in _rows(block):
        (model.end,) = _reals(block, card, texts[:1])
        return


_PRESCRIBED = ("BOUNDARY_PRESCRIBED_MOTION_RIGID", "BOUNDARY_PRESCRIBED_MOTION_RIGID_ID")
_READERS: dict[str, Callable[[Block, DeckModel], None]] = {
    "MAT_": _material,
    "CONTACT_": _contact,
    "BOUNDARY_PRESCRIBED_MOTION": _prescribed,
    "INITIAL_VELOCITY": _initial,
    "LOAD_BODY": _gravity,
    "CONTROL_TERMINATION": _termination,
}
