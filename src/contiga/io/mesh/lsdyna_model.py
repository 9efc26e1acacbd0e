"""Contents of an LS-DYNA deck besides its mesh: rigid parts, contacts, motions, times.

What is not understood is kept by keyword, with the lines it stands in. Card layouts: LS-DYNA
Keyword User's Manual, volumes I and II.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from contiga.errors import FileError
from contiga.io.mesh.lsdyna import (
    cut_for_what_is_left,
    is_lumped,
    lumped,
    masses_of_parts,
)
from contiga.io.mesh.lsdyna_cards import (
    Block,
    Card,
    Row,
    check_once,
    layout,
    leaving_parameters,
    read_blocks,
    row_of,
    rows_of,
)
from contiga.io.mesh.lsdyna_curves import is_curve, is_table, read_curves, read_tables
from contiga.io.mesh.lsdyna_deck import (
    DeckContact,
    DeckModel,
    Material,
    NodeStart,
    Prescribed,
    Start,
)
from contiga.io.mesh.lsdyna_parameters import is_parameters
from contiga.io.mesh.lsdyna_parts import axes_of, is_part, is_section, read_parts
from contiga.io.mesh.lsdyna_sets import is_other_set, is_set, read_sets, set_of
from contiga.io.mesh.lsdyna_soft import CARDS, SOFT
from contiga.io.mesh.lsdyna_ties import is_tie, read_ties

_MESH = ("NODE", "ELEMENT_SHELL", "ELEMENT_SOLID", "ELEMENT_TSHELL")
_RIGID = ("RIGID", "020")
_OTHER_CONTACTS = ("TIED", "TIEBREAK", "2D", "DRAWBEAD")
_CONTACT = (
    layout("SSID MSID SSTYP MSTYP SBOXID MBOXID ~SPR ~MPR"),
    layout("FS FD DC VC VDC PENCHK BT DT=1e20"),
    layout("SFS=1 SFM=1 SST MST SFST=1 SFMT=1 FSF=1 VSF=1"),
)
# Cards of some kinds of contact, before the optional ones: A, B, C … of the manual.
_OF_KIND = {"ERODING": layout("ISYM EROSOP IADJ"), "CONSTRAINT": layout("KPF")}
_OPTIONAL = (
    layout("SOFT SOFSCL=0.1 LCIDAB MAXPAR=1.025 SBOPT=2 DEPTH=2 ~BSORT ~FRCFRQ"),
    layout("PENMAX THKOPT SHLTHK SNLOG ISYM I2D3D SLDTHK SLDSTF"),
    layout("IGAP=1 IGNORE DPRFAC DTSTIF EDGEK FLANGL CID_RCF"),
    layout("Q2TRI DTPCHK SFNBR FNLSCL DNLSCL TCSO TIEDID SHLEDG"),
    layout("SHAREC CPARM8 IPBACK SRNDE FRICSF=1 ICOR FTORQ REGION"),
    layout("PSTIFF IGNROFF FSTOL=2 2DBINR SSFTYP SWTPR TETFAC"),
    layout("SHLOFF"),
)
_PRESCRIBED = layout("PID DOF VAD LCID SF=1 VID DEATH=1e28 BIRTH")
_RIGID_START = layout("PID VX VY VZ VXR VYR VZR ICID")
_GENERATION = (
    layout("ID STYP=1 OMEGA VX VY VZ IVATN ICID"),
    layout("XC YC ZC NX NY NZ PHASE IRIGID"),
)
_START = (
    layout("NSID NSIDEX BOXID IRIGID ICID"),
    layout("VX VY VZ VXR VYR VZR"),
    layout("VXE VYE VZE VXRE VYRE VZRE"),
)
_NODE_START = layout("NID VX VY VZ VXR VYR VZR ICID")
_RATES = "VX VY VZ VXR VYR VZR"
_LOAD_BODY = layout("LCID SF=1 LCIDDR XC YC ZC CID")
_VECTORS = layout("CID XX YX ZX XV YV ZV NID")
_SYSTEM = layout("CID XO YO ZO XL YL ZL CIDL"), layout("XP YP ZP")
_ENDS = layout("ENDTIM ENDCYC DTMIN ENDENG ENDMAS=1e8 NOSOL")
_STATES = layout("DT ~LCDT ~BEAM NPLTC ~PSETID ~CID")


def read_model(path: Path) -> DeckModel:
    """Read the contents of a deck besides its mesh.

    Raises
    ------
    FileError
        Not a keyword deck, or an included file is missing.
    MeshError
        A field that should be a number is none; parameters (&) without a value are noted. A part,
        section, material or curve is given twice, not alike.
    """
    try:
        blocks = list(read_blocks(path))
    except OSError as error:
        raise FileError(f"cannot be read ({error.strerror})", where=str(path)) from error
    if not blocks:
        raise FileError("not an LS-DYNA keyword deck", where=str(path), allowed="a file with *NODE")
    model = DeckModel(path, blocks)
    model.parts = read_parts(blocks, model.drop)
    model.curves = read_curves(blocks, model.drop_curve)
    model.tables = read_tables(blocks, model.drop)
    model.part_sets = read_sets(blocks, "PART", model.drop)
    model.node_sets = read_sets(blocks, "NODE", model.drop)
    model.other_sets = {set_of(block): block for block in blocks if is_other_set(block)}
    # The end is read first: it decides what ends before the run does.
    for block in sorted(blocks, key=lambda block: not block.keyword.startswith(_TERMINATION)):
        _take(block, model)
    for left in blocks[0].parameters.left:
        model.leave(*left)
    model.motions = list(_possible(model))
    return model


def _possible(model: DeckModel) -> Iterator[Prescribed]:
    """Yield the motions with usable curves; note the others.

    There is one for each part and direction, and one kind for each part.
    """
    kinds: dict[int, int] = {}
    first: dict[tuple[int, int], Prescribed] = {}
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
        elif (before := first.setdefault((one.part, one.way), one)) is not one:
            place = model.place(before.block, before.line)
            why = f"part {one.part}, DOF {one.way} again: that of {place} stands"
        if why:
            model.leave(one.block, why, one.line)
        else:
            yield one


def _take(block: Block, model: DeckModel) -> None:
    name = block.keyword
    if name == "TITLE":
        model.title = block.cards[0].text.strip() if block.cards else ""
        block.mark_read(*block.cards)
        return
    if is_curve(block) or is_table(block) or is_part(block) or is_section(block):
        return
    if is_set(block, "NODE") or is_set(block, "PART"):
        return
    if is_parameters(block):
        block.mark_read(*block.cards)
        return
    reader = next((read for start, read in _READERS.items() if name.startswith(start)), None)
    if reader is None:
        model.drop(block)
        return
    with leaving_parameters(block, model.drop):
        reader(block, model)


def _mesh(block: Block, model: DeckModel) -> None:
    if block.keyword.startswith("NODE_"):
        model.drop(block)
    else:
        cut_for_what_is_left(block)


def _mass(block: Block, model: DeckModel) -> None:
    if is_lumped(block):
        for one in lumped(block):
            model.masses.append(one)
            if one.of_set and (why := model.no_set("NODE", one.number)):
                model.leave(block, why, one.line)
    elif block.keyword == "ELEMENT_MASS_PART":
        model.part_masses |= masses_of_parts(block)
    else:
        model.drop(block)


def _material(block: Block, model: DeckModel) -> None:
    titled = block.keyword.endswith("_TITLE")
    kind = block.keyword.removeprefix("MAT_").removesuffix("_TITLE")
    cards = block.behind(titled)
    if kind not in CARDS or not cards:
        model.drop(block)
        return
    rows = rows_of(block, cards, *CARDS[kind])
    soft = SOFT[kind](rows) if kind in SOFT else None
    why, soft = (soft, None) if isinstance(soft, str) else ("", soft)
    first = rows[0]
    if "E" not in first.layout.places and soft is None:
        model.drop(block, why)
        return
    density = first.real("RO")
    if soft is not None:
        modulus, poisson = soft.modulus, soft.poisson
    else:
        modulus = first.real("E")
        poisson = first.real("PR") if "PR" in first.layout.places else 0.0
    rigid, held = kind in _RIGID, (0, 0)
    if rigid:
        code = rows[1].real("CMO")
        ways, turns = map(int, rows[1].reals("CON1 CON2"))
        if code > 0:
            held = ways, turns
        elif code < 0:
            model.leave(block, "held in axes of its own")
    number = first.whole("MID")
    check_once(model.parts.given, "material", number, block, cards)
    model.materials[number] = Material(density, modulus, poisson, rigid, held, block, soft, why)


def _read_ties(block: Block, model: DeckModel) -> None:
    """Read *BOUNDARY_SPC_… and *CONSTRAINED_EXTRA_NODES_…."""
    if not is_tie(block):
        model.drop(block)
        return
    for tie in read_ties(block):
        if tie.problem:
            model.leave(block, f"{tie.what}, {tie.problem}", tie.line)
        else:
            model.ties.append(tie)


def _contact(block: Block, model: DeckModel) -> None:
    words = block.keyword
    named = words.endswith(("_ID", "_TITLE"))
    words = words.removesuffix("_ID").removesuffix("_TITLE")
    known = words.endswith(("SURFACE_TO_SURFACE", "NODES_TO_SURFACE", "SINGLE_SURFACE"))
    cards = block.behind(named)
    if not known or any(word in words for word in _OTHER_CONTACTS) or len(cards) < 2:
        model.drop(block)
        return
    of_kind = [fields for word, fields in _OF_KIND.items() if word in words]
    between, rub, scales, *_ = rows_of(block, cards, *_CONTACT, *of_kind, *_OPTIONAL)
    a, b, kind_a, kind_b = between.wholes("SSID MSID SSTYP MSTYP")
    if words.endswith("SINGLE_SURFACE"):
        b, kind_b = a, kind_a
    static, dynamic, decay = rub.reals("FS FD DC")
    birth, death = rub.reals("BT DT")
    if static < 0.0:
        model.leave(block, f"FS {static:g}, friction of parts or by a table")
    elif decay > 0.0 and not 0.0 <= dynamic <= static:
        model.leave(block, f"FD {dynamic:g} beside FS {static:g}, DC is left out")
    if birth > 0.0 or model.ends_after(death):
        model.leave(block, "BT and DT, it lasts all the time")
    sides = (kind_a, a), (kind_b, b)
    model.contacts.append(DeckContact(block, sides, (static, dynamic, decay), scales))


def _read_prescribed_motion(block: Block, model: DeckModel) -> None:
    named = block.keyword.endswith("_ID")
    if block.keyword.removesuffix("_ID") != "BOUNDARY_PRESCRIBED_MOTION_RIGID":
        model.drop(block)
        return
    cards = iter(block.cards)
    for card in cards:
        if named:
            block.mark_read(card)
            card = next(cards, Card("", 0))
        if not card.text.strip():
            continue
        row, line = row_of(card, block, _PRESCRIBED), card.line
        part, way, kind, curve = row.wholes("PID DOF VAD LCID")
        scale = row.real("SF")
        if way not in (1, 2, 3) or kind not in (0, 1, 2):
            # Rotations about offset axes, and nodes besides nodes, have one more card.
            offset = [next(cards, card)] if abs(way) in (9, 10, 11) or kind == 4 else []
            model.drop(block, f"part {part}, DOF {way}, VAD {kind}", cards=[card, *offset])
            continue
        death, birth = row.reals("DEATH BIRTH")
        if model.ends_after(death):
            model.leave(block, f"part {part}, DEATH {death:g}: the motion goes on", line)
        if birth > 0.0:
            model.leave(block, f"part {part}, BIRTH {birth:g}: it moves before, too", line)
        model.motions.append(Prescribed(part, way, kind, curve, scale, block, line))


def _initial(block: Block, model: DeckModel) -> None:
    if block.keyword == "INITIAL_VELOCITY_RIGID_BODY":
        for row in (row_of(card, block, _RIGID_START) for card in block.cards):
            part, rates = row.whole("PID"), row.reals(_RATES)
            if row.whole("ICID"):
                model.leave(block, f"part {part}, in axes of its own, ICID", row.card.line)
            elif part:
                _start(model, part, Start(rates, (part,), block))
    elif block.keyword == "INITIAL_VELOCITY_GENERATION":
        for k in range(0, len(block.cards) - 1, 2):
            head, tail = rows_of(block, block.cards[k : k + 2], *_GENERATION)
            _read_velocity_generation(head, tail, model)
    elif block.keyword == "INITIAL_VELOCITY" and len(block.cards) > 1:
        _of_all(block, model)
    elif block.keyword == "INITIAL_VELOCITY_NODE":
        _of_nodes(block, model)
    else:
        model.drop(block)


def _start(model: DeckModel, part: int, start: Start) -> None:
    """Take the velocity of a part, or of all (0); note a conflicting one."""
    before = model.velocities.get(part)
    if before is not None and before.rates != start.rates:
        whose = f"part {part}" if part else "all"
        model.leave(before.block, f"{whose}: that of {model.place(start.block)} comes later")
    model.velocities[part] = start


def _of_all(block: Block, model: DeckModel) -> None:
    whose, rates, _ = rows_of(block, block.cards, *_START)
    nodes, exempt, box, over, axes = whose.wholes("NSID NSIDEX BOXID IRIGID ICID")
    for said, why in (
        (nodes, "of a set of nodes"),
        (box, f"in box {box} only, BOXID"),
        (axes, "in axes of its own, ICID"),
    ):
        if said:
            model.drop(block, why)
            return
    if exempt:
        model.leave(block, f"all but set of nodes {exempt}, NSIDEX: these, too")
    replaced = [0] * (over < 0) if over <= 0 else model.part_sets.get(over, [])
    if over > 0 and (why := model.no_set("PART", over)):
        model.leave(block, f"{why}, IRIGID")
    _start(model, 0, Start(rates.reals(_RATES), tuple(replaced), block))


def _of_nodes(block: Block, model: DeckModel) -> None:
    for row in (row_of(card, block, _NODE_START) for card in block.cards):
        node, line = row.whole("NID"), row.card.line
        rates = row.reals(_RATES)
        if node and row.whole("ICID"):
            model.leave(row.block, f"node {node}, in axes of its own, ICID", line)
        elif node:
            before = model.node_velocities.get(node)
            if before is not None and before.rates != rates:
                place = model.place(block, line)
                model.leave(before.block, f"node {node}: that of {place} comes later", before.line)
            model.node_velocities[node] = NodeStart(rates, row.block, line)


def _read_velocity_generation(head: Row, tail: Row, model: DeckModel) -> None:
    number, kind = head.wholes("ID STYP")
    omega, *velocity = head.reals("OMEGA VX VY VZ")
    parts = [number] if kind == 2 or number == 0 else model.part_sets.get(number, [])
    why = ""
    if omega:
        why = "a turn"
    elif number and kind not in (1, 2):
        why = "of a set of nodes"
    elif head.whole("ICID"):
        why = "in axes of its own, ICID"
    elif not parts:
        why = model.no_set("PART", number) or f"set of parts {number} is empty"
    if why:
        model.drop(head.block, why, head.card.line, [head.card, tail.card])
        return
    over = (0,) if tail.whole("IRIGID") == 1 else ()
    for part in parts:
        _start(model, part, Start((*velocity, 0.0, 0.0, 0.0), over, head.block))


def _gravity(block: Block, model: DeckModel) -> None:
    axis = "XYZ".find(block.keyword.removeprefix("LOAD_BODY_"))
    if axis < 0 or len(block.keyword) != len("LOAD_BODY_X") or not block.cards:
        model.drop(block)
        return
    if axis in model.gravity:
        _, _, before = model.gravity[axis]
        model.drop(before, f"again in {model.place(block)}, which counts")
    row = row_of(block.cards[0], block, _LOAD_BODY)
    model.gravity[axis] = row.whole("LCID"), row.real("SF"), block


def _termination(block: Block, model: DeckModel) -> None:
    (row,) = rows_of(block, block.cards, _ENDS)
    end = row.real("ENDTIM")
    if model.end and end != model.end:
        model.leave(block, f"ENDTIM {model.end:g} before")
    model.end = end


def _system(block: Block, model: DeckModel) -> None:
    """Read *DEFINE_COORDINATE_SYSTEM and _VECTOR, except those given in another system."""
    vector = block.keyword.removesuffix("_TITLE").endswith("_VECTOR")
    _, cards = block.title_and_cards()
    if vector:
        for row in (row_of(card, block, _VECTORS) for card in cards):
            axes = axes_of(row.reals("XX YX ZX"), row.reals("XV YV ZV"))
            model.systems |= {} if axes is None else {row.whole("CID"): axes}
        return
    for k in range(0, len(cards) - 1, 2):
        head, tail = rows_of(block, cards[k : k + 2], *_SYSTEM)
        origin = np.array(head.reals("XO YO ZO"))
        along, across = np.array(head.reals("XL YL ZL")), np.array(tail.reals("XP YP ZP"))
        axes = axes_of((along - origin).tolist(), (across - origin).tolist())
        if axes is None or head.whole("CIDL"):
            model.drop(block, "in another system, CIDL", head.card.line, [head.card, tail.card])
        else:
            model.systems[head.whole("CID")] = axes


def _states(block: Block, model: DeckModel) -> None:
    (row,) = rows_of(block, block.cards, _STATES)
    block.mark_read(*block.cards[1:])  # which results are in the files
    count = row.whole("NPLTC")
    model.states = model.end / count if count > 0 else row.real("DT")


_TERMINATION = "CONTROL_TERMINATION"
_READERS: dict[str, Callable[[Block, DeckModel], None]] = {
    **dict.fromkeys(_MESH, _mesh),
    "ELEMENT_MASS": _mass,
    "MAT_": _material,
    "CONTACT_": _contact,
    "BOUNDARY_PRESCRIBED_MOTION": _read_prescribed_motion,
    "BOUNDARY_SPC": _read_ties,
    "CONSTRAINED_EXTRA_NODES": _read_ties,
    "INITIAL_VELOCITY": _initial,
    "LOAD_BODY": _gravity,
    "DATABASE_BINARY_D3PLOT": _states,
    "DEFINE_COORDINATE_SYSTEM": _system,
    "DEFINE_COORDINATE_VECTOR": _system,
    _TERMINATION: _termination,
}
