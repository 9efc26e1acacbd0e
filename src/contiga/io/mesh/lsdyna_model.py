"""Contents of an LS-DYNA deck besides its mesh: rigid parts, contacts, motions, times.

Contents that are not understood are noted by keyword, with their lines. Card layouts: LS-DYNA
Keyword User's Manual, volumes I and II.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from contiga.io.mesh.lsdyna import mark_mesh_fields, read_lumped, read_part_masses
from contiga.io.mesh.lsdyna_cards import (
    Block,
    Card,
    define_once,
    layout,
    read_deck,
    row_of,
    rows_of,
    skip_unresolved,
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

_RIGID = ("RIGID", "020")
_OTHER_CONTACTS = ("TIED", "TIEBREAK", "2D", "DRAWBEAD")
_CONTACT_CARDS = (
    layout("SSID MSID SSTYP MSTYP SBOXID MBOXID ~SPR ~MPR"),
    layout("FS FD DC VC VDC PENCHK BT DT=1e20"),
    layout("SFS=1 SFM=1 SST MST SFST=1 SFMT=1 FSF=1 VSF=1"),
)
# Cards of some kinds of contact, before the optional ones: A, B, C … of the manual.
_CARDS_OF_KIND = {"ERODING": layout("ISYM EROSOP IADJ"), "CONSTRAINT": layout("KPF")}
_OPTIONAL_CARDS = (
    layout("SOFT SOFSCL=0.1 LCIDAB MAXPAR=1.025 SBOPT=2 DEPTH=2 ~BSORT ~FRCFRQ"),
    layout("PENMAX THKOPT SHLTHK SNLOG ISYM I2D3D SLDTHK SLDSTF"),
    layout("IGAP=1 IGNORE DPRFAC DTSTIF EDGEK FLANGL CID_RCF"),
    layout("Q2TRI DTPCHK SFNBR FNLSCL DNLSCL TCSO TIEDID SHLEDG"),
    layout("SHAREC CPARM8 IPBACK SRNDE FRICSF=1 ICOR FTORQ REGION"),
    layout("PSTIFF IGNROFF FSTOL=2 2DBINR SSFTYP SWTPR TETFAC"),
    layout("SHLOFF"),
)
_PRESCRIBED_MOTION = layout("PID DOF VAD LCID SF=1 VID DEATH=1e28 BIRTH")
_RIGID_VELOCITY = layout("PID VX VY VZ VXR VYR VZR ICID")
_VELOCITY_GENERATION = (
    layout("ID STYP=1 OMEGA VX VY VZ IVATN ICID"),
    layout("XC YC ZC NX NY NZ PHASE IRIGID"),
)
_VELOCITY = (
    layout("NSID NSIDEX BOXID IRIGID ICID"),
    layout("VX VY VZ VXR VYR VZR"),
    layout("VXE VYE VZE VXRE VYRE VZRE"),
)
_NODE_VELOCITY = layout("NID VX VY VZ VXR VYR VZR ICID")
_RATES = "VX VY VZ VXR VYR VZR"
_LOAD_BODY = layout("LCID SF=1 LCIDDR XC YC ZC CID")
_VECTORS = layout("CID XX YX ZX XV YV ZV NID")
_SYSTEM = layout("CID XO YO ZO XL YL ZL CIDL"), layout("XP YP ZP")
_TERMINATION = layout("ENDTIM ENDCYC DTMIN ENDENG ENDMAS=1e8 NOSOL")
_OUTPUT_STATES = layout("DT ~LCDT ~BEAM NPLTC ~PSETID ~CID")
_END_KEYWORD = "CONTROL_TERMINATION"

Reader = Callable[[Block, DeckModel], None]
_READERS: dict[str, Reader] = {}
"""Readers by keyword, or by its beginning followed by a star."""


def _reads(*keywords: str) -> Callable[[Reader], Reader]:
    """Return a decorator that makes a function the reader of `keywords`; "NAME*" is a prefix."""

    def register(reader: Reader) -> Reader:
        _READERS.update(dict.fromkeys(keywords, reader))
        return reader

    return register


def read_model(path: Path) -> DeckModel:
    """Read the contents of a deck besides its mesh.

    What is not understood is noted in `DeckModel.unknown`: keywords without a reader, features of
    those with one, and parameters (&) without a value, whose keywords are left out.

    Raises
    ------
    FileError
        Not a keyword deck, it cannot be read, or an included file is missing.
    MeshError
        A field that should be a number is not one. A part, section, material or curve is given
        twice, not alike.
    """
    blocks = read_deck(path)
    model = DeckModel(path, blocks)
    model.parts = read_parts(blocks, model.drop)
    model.curves = read_curves(blocks, model.drop_curve)
    model.tables = read_tables(blocks, model.drop)
    model.part_sets = read_sets(blocks, "PART", model.drop)
    model.node_sets = read_sets(blocks, "NODE", model.drop)
    model.other_sets = {set_of(block): block for block in blocks if is_other_set(block)}
    # The end is read first: it decides which entries end before the run does.
    for block in sorted(blocks, key=lambda block: not block.keyword.startswith(_END_KEYWORD)):
        is_read = is_curve(block) or is_table(block) or is_part(block) or is_section(block)
        if is_read or is_set(block, "NODE") or is_set(block, "PART"):
            continue
        if block.keyword == "TITLE":
            model.title = block.cards[0].text.strip() if block.cards else ""
        if block.keyword == "TITLE" or is_parameters(block):
            block.mark_read(*block.cards)
            continue
        reader = _READERS.get(block.keyword) or next(
            (
                reader
                for start, reader in _READERS.items()
                if start.endswith("*") and block.keyword.startswith(start[:-1])
            ),
            None,
        )
        if reader is None:
            model.drop(block)
            continue
        with skip_unresolved(block, model.drop):
            reader(block, model)
    for parameter in blocks[0].parameters.unresolved:
        model.leave(*parameter)
    model.motions = _usable_motions(model)
    return model


def _usable_motions(model: DeckModel) -> list[Prescribed]:
    """Return the motions of `model` that can be carried out; note the others and the reason.

    A curve must exist, have points, and times that do not fall; one with an unresolved parameter
    passes. The first motion of a part sets its kind, the first of a part and direction counts.
    """
    motions: list[Prescribed] = []
    kinds: dict[int, int] = {}
    first_motions: dict[tuple[int, int], Prescribed] = {}
    for motion in model.motions:
        curve = model.curves.get(motion.curve)
        problem = ""
        if curve is None and motion.curve not in model.unresolved_curves:
            problem = f"there is no curve {motion.curve}"
        elif curve is not None and len(curve.table) == 0:
            problem = f"curve {motion.curve} has no points"
        elif curve is not None and (np.diff(curve.table[:, 0]) < 0.0).any():
            problem = f"the times of curve {motion.curve} fall"
        elif kinds.setdefault(motion.part, motion.kind) != motion.kind:
            problem = f"VAD {motion.kind} beside VAD {kinds[motion.part]}"
        else:
            first = first_motions.setdefault((motion.part, motion.direction), motion)
            if first is not motion:
                place = model.place(first.block, first.line)
                problem = f"DOF {motion.direction} again: that of {place} stands"
        if problem:
            model.leave(motion.block, f"part {motion.part}, {problem}", motion.line)
        else:
            motions.append(motion)
    return motions


@_reads("NODE", "ELEMENT_SHELL*", "ELEMENT_SOLID*", "ELEMENT_TSHELL*")
def _read_mesh(block: Block, _: DeckModel) -> None:
    mark_mesh_fields(block)


@_reads("ELEMENT_MASS", "ELEMENT_MASS_NODE_SET")
def _read_lumped_masses(block: Block, model: DeckModel) -> None:
    for mass in read_lumped(block):
        model.masses.append(mass)
        if mass.of_set and (problem := model.no_set("NODE", mass.number)):
            model.leave(block, problem, mass.line)


@_reads("ELEMENT_MASS_PART")
def _read_part_masses(block: Block, model: DeckModel) -> None:
    model.part_masses.update(read_part_masses(block))


@_reads("MAT_*")
def _read_material(block: Block, model: DeckModel) -> None:
    """Add the material of a *MAT; drop one that is not known, or has neither law nor modulus.

    If a law cannot be made the reason is kept. Constraints of a rigid material in its own axes
    (CMO < 0) are noted. A number that other cards define is a `MeshError`.
    """
    has_title = block.keyword.endswith("_TITLE")
    kind = block.keyword.removeprefix("MAT_").removesuffix("_TITLE")
    cards = block.behind(has_title)
    if kind not in CARDS or not cards:
        model.drop(block)
        return
    rows = rows_of(block, cards, *CARDS[kind])
    law = SOFT[kind](rows) if kind in SOFT else None
    problem, law = (law, None) if isinstance(law, str) else ("", law)
    first = rows[0]
    if "E" not in first.layout.places and law is None:
        model.drop(block, problem)
        return
    density = first.real("RO")
    if law is not None:
        modulus, poisson = law.modulus, law.poisson
    else:
        modulus = first.real("E")
        poisson = first.real("PR") if "PR" in first.layout.places else 0.0
    rigid, constraints = kind in _RIGID, (0, 0)
    if rigid:
        code = rows[1].real("CMO")
        translations, rotations = map(int, rows[1].reals("CON1 CON2"))
        if code > 0:
            constraints = translations, rotations
        elif code < 0:
            model.leave(block, "held in axes of its own")
    number = first.whole("MID")
    define_once(model.parts.definitions, "material", number, block, cards)
    model.materials[number] = Material(
        density, modulus, poisson, rigid, constraints, block, law, problem
    )


@_reads("BOUNDARY_SPC*", "CONSTRAINED_EXTRA_NODES*")
def _read_ties(block: Block, model: DeckModel) -> None:
    """Add the ties without a problem, and note the others; drop keywords that are no ties."""
    if not is_tie(block):
        model.drop(block)
        return
    for tie in read_ties(block):
        if tie.problem:
            model.leave(block, f"{tie.label}, {tie.problem}", tie.line)
        else:
            model.ties.append(tie)


@_reads("CONTACT_*")
def _read_contact(block: Block, model: DeckModel) -> None:
    """Add a contact between surfaces, of nodes with a surface, or of a surface with itself.

    Tied, 2D and other kinds, and keywords of fewer than two cards, are dropped. Times of birth and
    death, friction by tables, and a decay that cannot be (FD above FS) are noted.
    """
    has_id = block.keyword.endswith(("_ID", "_TITLE"))
    kind = block.keyword.removesuffix("_ID").removesuffix("_TITLE")
    cards = block.behind(has_id)
    if (
        not kind.endswith(("SURFACE_TO_SURFACE", "NODES_TO_SURFACE", "SINGLE_SURFACE"))
        or any(word in kind for word in _OTHER_CONTACTS)
        or len(cards) < 2
    ):
        model.drop(block)
        return
    extra_layouts = [fields for word, fields in _CARDS_OF_KIND.items() if word in kind]
    sides, friction, scales, *_ = rows_of(
        block, cards, *_CONTACT_CARDS, *extra_layouts, *_OPTIONAL_CARDS
    )
    slave, master, slave_kind, master_kind = sides.wholes("SSID MSID SSTYP MSTYP")
    if kind.endswith("SINGLE_SURFACE"):
        master, master_kind = slave, slave_kind
    static, dynamic, decay = friction.reals("FS FD DC")
    birth, death = friction.reals("BT DT")
    if static < 0.0:
        model.leave(block, f"FS {static:g}, friction of parts or by a table")
    elif decay > 0.0 and not 0.0 <= dynamic <= static:
        model.leave(block, f"FD {dynamic:g} beside FS {static:g}, DC is left out")
    if birth > 0.0 or model.ends_after(death):
        model.leave(block, "BT and DT, it lasts all the time")
    pair = (slave_kind, slave), (master_kind, master)
    model.contacts.append(DeckContact(block, pair, (static, dynamic, decay), scales))


@_reads("BOUNDARY_PRESCRIBED_MOTION_RIGID", "BOUNDARY_PRESCRIBED_MOTION_RIGID_ID")
def _read_prescribed_motion(block: Block, model: DeckModel) -> None:
    """Add the translations of rigid parts; drop rotations and other kinds, with their cards.

    Times of birth above 0 and of death within the run are noted: motions last all the time.
    """
    has_id = block.keyword.endswith("_ID")
    cards = iter(block.cards)
    for card in cards:
        if has_id:
            block.mark_read(card)
            card = next(cards, Card("", 0))
        if not card.text.strip():
            continue
        row, line = row_of(card, block, _PRESCRIBED_MOTION), card.line
        part, direction, kind, curve = row.wholes("PID DOF VAD LCID")
        scale = row.real("SF")
        if direction not in (1, 2, 3) or kind not in (0, 1, 2):
            # Rotations about offset axes, and nodes besides nodes, have one more card.
            has_offset = abs(direction) in (9, 10, 11) or kind == 4
            offset = [next(cards, card)] if has_offset else []
            model.drop(block, f"part {part}, DOF {direction}, VAD {kind}", cards=[card, *offset])
            continue
        death, birth = row.reals("DEATH BIRTH")
        if model.ends_after(death):
            model.leave(block, f"part {part}, DEATH {death:g}: the motion goes on", line)
        if birth > 0.0:
            model.leave(block, f"part {part}, BIRTH {birth:g}: it moves before, too", line)
        model.motions.append(Prescribed(part, direction, kind, curve, scale, block, line))


@_reads("INITIAL_VELOCITY_RIGID_BODY")
def _read_rigid_velocity(block: Block, model: DeckModel) -> None:
    """Set the velocities of parts and replace their own rates; note those in other axes (ICID)."""
    for row in (row_of(card, block, _RIGID_VELOCITY) for card in block.cards):
        part, rates = row.whole("PID"), row.reals(_RATES)
        if row.whole("ICID"):
            model.leave(block, f"part {part}, in axes of its own, ICID", row.card.line)
        elif part:
            _set_velocity(model, part, Start(rates, (part,), block))


@_reads("INITIAL_VELOCITY_GENERATION")
def _read_velocity_generation(block: Block, model: DeckModel) -> None:
    """Set the velocity of a part, of each part of a set, or of all (number 0).

    Entries with a spin, of nodes, of a set that is missing or empty, or in axes of their own are
    dropped. IRIGID = 1 also replaces rates of *PART_INERTIA.
    """
    for k in range(0, len(block.cards) - 1, 2):
        head, tail = rows_of(block, block.cards[k : k + 2], *_VELOCITY_GENERATION)
        number, kind = head.wholes("ID STYP")
        omega, *velocity = head.reals("OMEGA VX VY VZ")
        parts = [number] if kind == 2 or number == 0 else model.part_sets.get(number, [])
        problem = ""
        if omega:
            problem = "a turn"
        elif number and kind not in (1, 2):
            problem = "of a set of nodes"
        elif head.whole("ICID"):
            problem = "in axes of its own, ICID"
        elif not parts:
            problem = model.no_set("PART", number) or f"set of parts {number} is empty"
        if problem:
            model.drop(block, problem, head.card.line, [head.card, tail.card])
            continue
        replaced = (0,) if tail.whole("IRIGID") == 1 else ()
        for part in parts:
            _set_velocity(model, part, Start((*velocity, 0.0, 0.0, 0.0), replaced, block))


@_reads("INITIAL_VELOCITY")
def _read_velocity(block: Block, model: DeckModel) -> None:
    """Set the velocity of all parts; one of a set of nodes, a box or other axes is dropped.

    Exempt nodes (NSIDEX) are noted, and get it too. IRIGID names the parts, or all if negative,
    whose rates of *PART_INERTIA it replaces.
    """
    if len(block.cards) < 2:
        model.drop(block)
        return
    head, rates, _ = rows_of(block, block.cards, *_VELOCITY)
    nodes, exempt, box, rigid, axes = head.wholes("NSID NSIDEX BOXID IRIGID ICID")
    if nodes or box or axes:
        only = "of a set of nodes" if nodes else f"in box {box} only, BOXID" if box else ""
        model.drop(block, only or "in axes of its own, ICID")
        return
    if exempt:
        model.leave(block, f"all but set of nodes {exempt}, NSIDEX: these, too")
    replaced = [0] * (rigid < 0) if rigid <= 0 else model.part_sets.get(rigid, [])
    if rigid > 0 and (problem := model.no_set("PART", rigid)):
        model.leave(block, f"{problem}, IRIGID")
    _set_velocity(model, 0, Start(rates.reals(_RATES), tuple(replaced), block))


def _set_velocity(model: DeckModel, part: int, start: Start) -> None:
    """Set the velocity of a part, or of all (0); a different earlier one is noted and replaced."""
    before = model.velocities.get(part)
    if before is not None and before.rates != start.rates:
        owner = f"part {part}" if part else "all"
        model.leave(before.block, f"{owner}: that of {model.place(start.block)} comes later")
    model.velocities[part] = start


@_reads("INITIAL_VELOCITY_NODE")
def _read_node_velocity(block: Block, model: DeckModel) -> None:
    """Set the velocities of nodes; a different earlier one of a node is noted and replaced.

    Velocities in other axes (ICID) are noted and left out, cards without a node skipped.
    """
    for row in (row_of(card, block, _NODE_VELOCITY) for card in block.cards):
        node, line = row.whole("NID"), row.card.line
        rates = row.reals(_RATES)
        if node and row.whole("ICID"):
            model.leave(block, f"node {node}, in axes of its own, ICID", line)
        elif node:
            before = model.node_velocities.get(node)
            if before is not None and before.rates != rates:
                place = model.place(block, line)
                model.leave(before.block, f"node {node}: that of {place} comes later", before.line)
            model.node_velocities[node] = NodeStart(rates, block, line)


@_reads("LOAD_BODY_X", "LOAD_BODY_Y", "LOAD_BODY_Z")
def _read_gravity(block: Block, model: DeckModel) -> None:
    """Set the gravity along an axis from the first card; drop an earlier keyword for that axis."""
    if not block.cards:
        model.drop(block)
        return
    axis = "XYZ".index(block.keyword[-1])
    if axis in model.gravity:
        _, _, before = model.gravity[axis]
        model.drop(before, f"again in {model.place(block)}, which counts")
    row = row_of(block.cards[0], block, _LOAD_BODY)
    model.gravity[axis] = row.whole("LCID"), row.real("SF"), block


@_reads(f"{_END_KEYWORD}*")
def _read_termination(block: Block, model: DeckModel) -> None:
    (row,) = rows_of(block, block.cards, _TERMINATION)
    end = row.real("ENDTIM")
    if model.end and end != model.end:
        model.leave(block, f"ENDTIM {model.end:g} before")
    model.end = end


@_reads("DEFINE_COORDINATE_SYSTEM*", "DEFINE_COORDINATE_VECTOR*")
def _read_system(block: Block, model: DeckModel) -> None:
    """Add the axes of *DEFINE_COORDINATE_SYSTEM and _VECTOR by number.

    Of the first, systems given in another one or by points on a line are dropped; of the second,
    those by parallel vectors are left out.
    """
    by_vectors = block.keyword.removesuffix("_TITLE").endswith("_VECTOR")
    _, cards = block.title_and_cards()
    if by_vectors:
        for row in (row_of(card, block, _VECTORS) for card in cards):
            axes = axes_of(row.reals("XX YX ZX"), row.reals("XV YV ZV"))
            model.systems |= {} if axes is None else {row.whole("CID"): axes}
        return
    for k in range(0, len(cards) - 1, 2):
        head, tail = rows_of(block, cards[k : k + 2], *_SYSTEM)
        origin = np.array(head.reals("XO YO ZO"))
        on_x, in_plane = np.array(head.reals("XL YL ZL")), np.array(tail.reals("XP YP ZP"))
        axes = axes_of((on_x - origin).tolist(), (in_plane - origin).tolist())
        if axes is None or head.whole("CIDL"):
            model.drop(block, "in another system, CIDL", head.card.line, [head.card, tail.card])
        else:
            model.systems[head.whole("CID")] = axes


@_reads("DATABASE_BINARY_D3PLOT*")
def _read_output_states(block: Block, model: DeckModel) -> None:
    """Set the time between written states: the end over their number, or else DT."""
    (row,) = rows_of(block, block.cards, _OUTPUT_STATES)
    block.mark_read(*block.cards[1:])  # which results are in the files
    count = row.whole("NPLTC")
    model.state_interval = model.end / count if count > 0 else row.real("DT")
