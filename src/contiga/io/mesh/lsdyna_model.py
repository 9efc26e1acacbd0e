"""Reading what an LS-DYNA deck says beside its mesh: rigid parts, contacts, motions, times.

What is not understood is kept by keyword, with the lines it stands in. Card layouts: LS-DYNA
Keyword User's Manual, volumes I and II.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from contiga.errors import FileError
from contiga.io.mesh.lsdyna_cards import Block, Row, leaving_parameters, read_blocks, row_of
from contiga.io.mesh.lsdyna_curves import is_curve, read_curves
from contiga.io.mesh.lsdyna_deck import (
    DeckContact,
    DeckModel,
    Material,
    NodeStart,
    Prescribed,
    Start,
)
from contiga.io.mesh.lsdyna_parameters import is_parameters
from contiga.io.mesh.lsdyna_parts import is_part, read_parts
from contiga.io.mesh.lsdyna_sets import is_set, read_sets
from contiga.io.mesh.lsdyna_soft import SOFT, SoftLaw
from contiga.io.mesh.lsdyna_ties import is_tie, read_ties

_MESH = ("NODE", "ELEMENT_MASS", "TITLE")
_MESH_STARTS = ("ELEMENT_SHELL", "ELEMENT_SOLID", "ELEMENT_TSHELL", "SECTION_")
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


def read_model(path: Path) -> DeckModel:
    """Read what a deck says beside its mesh.

    Raises
    ------
    FileError
        Not a keyword deck, or an included file is missing.
    MeshError
        A field that should be a number is none; parameters (&) without a value are noted.
    """
    try:
        blocks = list(read_blocks(path))
    except OSError as error:
        raise FileError(f"cannot be read ({error.strerror})", where=str(path)) from error
    if not blocks:
        raise FileError("not an LS-DYNA keyword deck", where=str(path), allowed="a file with *NODE")
    model = DeckModel(path)
    model.parts = read_parts(blocks, model.leave)
    model.curves = read_curves(blocks, model.leave_curve)
    model.part_sets = read_sets(blocks, "PART", model.leave)
    # The mesh has the sets of nodes: here only those that cannot be read are noted.
    read_sets(blocks, "NODE", model.leave)
    # The end comes first: what is over before it is told from what is not.
    for block in sorted(blocks, key=lambda block: not block.keyword.startswith(_TERMINATION)):
        _take(block, model)
    for left in blocks[0].parameters.left:
        model.leave(*left)
    model.motions = list(_possible(model))
    return model


def _possible(model: DeckModel) -> Iterator[Prescribed]:
    """Motions whose curve can be followed, of one kind for each part; others are noted."""
    kinds: dict[int, int] = {}
    for one in model.motions:
        curve = model.curves.get(one.curve)
        why = ""
        if curve is None and one.curve not in model.unread:
            why = f"part {one.part}, there is no curve {one.curve}"
        elif curve is not None and len(curve.table) == 0:
            why = f"part {one.part}, curve {one.curve} has no points"
        elif curve is not None and (np.diff(curve.table[:, 0]) < 0.0).any():
            why = f"part {one.part}, the times of curve {one.curve} fall"
        elif kinds.setdefault(one.part, one.kind) != one.kind:
            why = f"part {one.part}, VAD {one.kind} beside VAD {kinds[one.part]}"
        if why:
            model.leave(one.block, why, one.line)
        else:
            yield one


def _take(block: Block, model: DeckModel) -> None:
    name = block.keyword
    if name == "TITLE" and block.cards:
        model.title = block.cards[0].text.strip()
    if name in _MESH or name.startswith(_MESH_STARTS) or is_curve(block) or is_part(block):
        return
    if is_set(block, "NODE") or is_set(block, "PART") or is_parameters(block):
        return
    reader = next((read for start, read in _READERS.items() if name.startswith(start)), None)
    if reader is None:
        model.leave(block)
        return
    with leaving_parameters(block, model.leave):
        reader(block, model)


def _rows(block: Block) -> list[Row]:
    """Cards with their fields; one that is empty in the midst of others has all its defaults."""
    return [row_of(card, block) for card in block.cards]


def _material(block: Block, model: DeckModel) -> None:
    kind = block.keyword.removeprefix("MAT_").removesuffix("_TITLE")
    rows = _rows(block)[block.keyword.endswith("_TITLE") :]
    soft = _soft(kind, rows)
    why, soft = (soft, None) if isinstance(soft, str) else ("", soft)
    if not rows or (kind not in _ELASTIC and soft is None):
        model.leave(block, why)
        return
    density, modulus, poisson = rows[0].reals(1, 4)
    if soft is not None:
        modulus, poisson = soft.modulus, soft.poisson
    rigid, held = kind in _RIGID, (0, 0)
    if rigid and len(rows) > 1:
        code, ways, turns = map(int, rows[1].reals(0, 3))
        if code > 0:
            held = ways, turns
        elif code < 0:
            model.leave(block, "held in axes of its own")
    model.materials[rows[0].whole(0)] = Material(
        density,
        modulus,
        poisson if _ELASTIC.get(kind, True) else 0.0,
        rigid,
        held,
        block,
        soft,
        why,
    )


def _soft(kind: str, rows: list[Row]) -> SoftLaw | str | None:
    """What a part of the material is made of where it deforms, or why of nothing; None where there
    is no such here."""
    soft = SOFT.get(kind)
    if soft is None or not rows:
        return None
    numbers: list[float] = []
    for k, places in enumerate(soft.cards):
        numbers += [rows[k].real(i) if k < len(rows) else 0.0 for i in range(8)[places]]
    return soft.law(*numbers)


def _tied(block: Block, model: DeckModel) -> None:
    """*BOUNDARY_SPC_… and *CONSTRAINED_EXTRA_NODES_…."""
    if not is_tie(block):
        model.leave(block)
        return
    for tie in read_ties(block):
        if tie.problem:
            model.leave(block, f"{tie.what}, {tie.problem}", tie.line)
        else:
            model.ties.append(tie)


def _contact(block: Block, model: DeckModel) -> None:
    words, rows = block.keyword, _rows(block)
    for option in ("_ID", "_TITLE"):
        if words.endswith(option):
            words, rows = words.removesuffix(option), rows[1:]
    known = words.endswith(("SURFACE_TO_SURFACE", "NODES_TO_SURFACE", "SINGLE_SURFACE"))
    if not known or any(word in words for word in _OTHER_CONTACTS) or len(rows) < 2:
        model.leave(block)
        return
    a, b, kind_a, kind_b = rows[0].wholes(0, 4)
    scale = rows[2].real(0) if len(rows) > 2 else 0.0
    if words.endswith("SINGLE_SURFACE"):
        b, kind_b = a, kind_a
    for why in _left_of_contact(rows, model):
        model.leave(block, why)
    static, dynamic, decay = rows[1].reals(0, 3)
    model.contacts.append(
        DeckContact(block, ((kind_a, a), (kind_b, b)), (static, dynamic, decay), scale or 1.0)
    )


def _left_of_contact(rows: list[Row], model: DeckModel) -> Iterator[str]:
    """What the first two cards say that a case has no word for."""
    for k, name in ((4, "SBOXID"), (5, "MBOXID")):
        if rows[0].whole(k):
            yield f"box {name}, it is everywhere"
    static, dynamic, decay, viscous, damping, _, birth, death = rows[1].reals(0, 8)
    if static < 0.0:
        yield f"FS {static:g}, friction of parts or by a table"
    elif decay > 0.0 and not 0.0 <= dynamic <= static:
        yield f"FD {dynamic:g} beside FS {static:g}, DC is left out"
    if viscous or damping:
        yield "VC and VDC"
    if birth > 0.0 or model.ends_after(death):
        yield "BT and DT, it lasts all the time"


def _prescribed(block: Block, model: DeckModel) -> None:
    if block.keyword not in _PRESCRIBED:
        model.leave(block)
        return
    rows = _rows(block)
    for row in rows[1::2] if block.keyword.endswith("_ID") else rows:
        line = row.card.line
        if not row.card.text.strip():
            continue
        part, way, kind, curve = row.wholes(0, 4)
        scale = row.real(4)
        if way not in (1, 2, 3) or kind not in (0, 1, 2):
            model.leave(block, f"part {part}, DOF {way}, VAD {kind}")
            continue
        death, birth = row.reals(6, 8)
        if model.ends_after(death):
            model.leave(block, f"part {part}, DEATH {death:g}: the motion goes on", line)
        if birth > 0.0:
            model.leave(block, f"part {part}, BIRTH {birth:g}: it moves before, too", line)
        model.motions.append(Prescribed(part, way, kind, curve, scale or 1.0, block, line))


def _initial(block: Block, model: DeckModel) -> None:
    rows = _rows(block)
    if block.keyword == "INITIAL_VELOCITY_RIGID_BODY":
        for row in rows:
            part = row.whole(0)
            if row.whole(7):
                model.leave(block, f"part {part}, in axes of its own, ICID", row.card.line)
            elif part:
                model.velocities[part] = Start(row.reals(1, 7), (part,), block)
    elif block.keyword == "INITIAL_VELOCITY_GENERATION":
        for head, tail in zip(rows[::2], rows[1::2], strict=False):
            _generated(head, tail, model)
    elif block.keyword == "INITIAL_VELOCITY" and len(rows) > 1:
        _of_all(rows, model)
    elif block.keyword == "INITIAL_VELOCITY_NODE":
        _of_nodes(rows, model)
    else:
        model.leave(block)


def _of_all(rows: list[Row], model: DeckModel) -> None:
    block = rows[0].block
    nodes, exempt, box, over, axes = rows[0].wholes(0, 5)
    for said, why in (
        (nodes, "of a set of nodes"),
        (box, f"in box {box} only, BOXID"),
        (axes, "in axes of its own, ICID"),
    ):
        if said:
            model.leave(block, why)
            return
    if exempt:
        model.leave(block, f"all but set of nodes {exempt}, NSIDEX: these, too")
    replaced = [0] * (over < 0) if over <= 0 else model.part_sets.get(over, [])
    model.velocities[0] = Start(rows[1].reals(0, 6), tuple(replaced), block)


def _of_nodes(rows: list[Row], model: DeckModel) -> None:
    for row in rows:
        node, line = row.whole(0), row.card.line
        if node and row.whole(7):
            model.leave(row.block, f"node {node}, in axes of its own, ICID", line)
        elif node:
            model.node_velocities[node] = NodeStart(row.reals(1, 7), row.block, line)


def _generated(head: Row, tail: Row, model: DeckModel) -> None:
    number, kind = head.wholes(0, 2)
    omega, *velocity = head.reals(2, 6)
    parts = [number] if kind == 2 or number == 0 else model.part_sets.get(number, [])
    why = ""
    if omega:
        why = "a turn"
    elif number and kind not in (1, 2):
        why = "of a set of nodes"
    elif head.whole(7):
        why = "in axes of its own, ICID"
    elif not parts:
        why = f"there is no set of parts {number}"
    if why:
        model.leave(head.block, why, head.card.line)
        return
    over = (0,) if tail.whole(7) == 1 else ()
    for part in parts:
        model.velocities[part] = Start((*velocity, 0.0, 0.0, 0.0), over, head.block)


def _gravity(block: Block, model: DeckModel) -> None:
    axis = "XYZ".find(block.keyword.removeprefix("LOAD_BODY_"))
    rows = _rows(block)
    if axis < 0 or len(block.keyword) != len("LOAD_BODY_X") or not rows:
        model.leave(block)
        return
    scale = rows[0].real(1)
    model.gravity[axis] = rows[0].whole(0), scale or 1.0, block


def _termination(block: Block, model: DeckModel) -> None:
    for card in block.cards[:1]:
        model.end = row_of(card, block).real(0)


_TERMINATION = "CONTROL_TERMINATION"
_PRESCRIBED = ("BOUNDARY_PRESCRIBED_MOTION_RIGID", "BOUNDARY_PRESCRIBED_MOTION_RIGID_ID")
_READERS: dict[str, Callable[[Block, DeckModel], None]] = {
    "MAT_": _material,
    "CONTACT_": _contact,
    "BOUNDARY_PRESCRIBED_MOTION": _prescribed,
    "BOUNDARY_SPC": _tied,
    "CONSTRAINED_EXTRA_NODES": _tied,
    "INITIAL_VELOCITY": _initial,
    "LOAD_BODY": _gravity,
    _TERMINATION: _termination,
}
