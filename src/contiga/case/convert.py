"""Cases from LS-DYNA keyword decks: rigid parts become masters, their partners slaves.

The case can be read and changed by hand; cards that are not understood are listed, not guessed.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from contiga.case.deck_matter import SoftSlave, shared_parts, soft_slave
from contiga.case.deck_parts import DeckParts
from contiga.case.schema import parse_case
from contiga.case.toml import value_text
from contiga.errors import FileError, InputError
from contiga.io.mesh.lsdyna_deck import DeckContact, DeckModel
from contiga.io.mesh.lsdyna_model import read_model
from contiga.io.mesh.lsdyna_sets import set_name
from contiga.io.units import base_factor

_REST_COMMENT = "Deforms in the deck; here its points rest, and give way by the law of the contact."
_NODE_SET = 4
"""SSTYP of a side that is a set of nodes."""
_MAX_STATES = 200
"""Largest number of states that a case writes."""


class Converted(NamedTuple):
    """A case made of a deck."""

    text: str
    """TOML with comments."""
    contacts: int
    bodies: int
    """Number of its contacts, and of its bodies."""
    unknown: dict[str, list[int]]
    """Keywords that were not understood, and their lines."""


_Soft = dict[tuple[int, ...], SoftSlave | None]
"""Deformations of slaves, by their parts."""


class _Pair(NamedTuple):
    """One contact of the case: a rigid part and the slave that may touch it."""

    master: int
    parts: tuple[int, ...]
    """Parts of the slave; none for a set of nodes, or the rigid one they belong to."""
    nodes: int
    """The set of nodes; 0 if the slave is parts."""
    contact: DeckContact
    swapped: bool
    """Whether the master is on the first side of the deck's contact."""


def convert(deck: str | Path, units: tuple[str, str, str], folder: str | Path) -> Converted:
    """Return a case made from a keyword deck, its counts, and keywords that are not understood.

    Parameters
    ----------
    deck : the keyword file
    units : length, mass and time unit of its numbers; decks name none
    folder : where the case will stand, so that it finds the deck

    Raises
    ------
    FileError, MeshError
        The deck cannot be read, has no contact with a rigid part that is understood, or has a
        free rigid part without a mass.
    UnitError
        A name in `units` is no unit of its dimension.
    CaseError
        The case that was made is refused when it is parsed, as a check.
    """
    for unit, dimension in zip(units, ("length", "mass", "time"), strict=True):
        base_factor(unit, dimension, "--units")
    model = read_model(Path(deck))
    parts = DeckParts(model, Path(folder), units)
    pairs = _pairs(model, parts)
    if not pairs:
        raise FileError(
            "there is no contact with a rigid part that is understood",
            where=str(deck),
            found=", ".join(f"{len(lines)} {name}" for name, lines in sorted(model.unknown.items()))
            or "no *CONTACT",
            allowed="*CONTACT_…SURFACE_TO_SURFACE, …NODES_TO_SURFACE or …SINGLE_SURFACE between "
            "parts, sets of parts or of nodes, one side of *MAT_RIGID",
        )
    parts.shared_parts = shared_parts(
        [pair.parts for pair in pairs if not pair.nodes and not _owners(pair, parts)],
        parts,
        [pair.nodes for pair in pairs if pair.nodes and not _owners(pair, parts)],
    )
    head = _head(model, units)
    slaves = dict.fromkeys(pair.parts for pair in pairs if not _owners(pair, parts))
    soft = {slave: soft_slave(parts, list(slave)) for slave in slaves if slave}
    bodies = {part for pair in pairs for part in (pair.master, *_owners(pair, parts))}
    bodies |= {host for slave in soft.values() if slave is not None for host in slave.hosts}
    tables = [*_bodies(sorted(bodies), parts), *_contacts(pairs, parts, soft)]
    parts.leave_nodes()
    parts.leave_ties()
    parts.leave_masses(bodies)
    model.leave_unread()
    foot = []
    if model.unknown:
        foot = ["", "# Not understood, and left out:"]
        for name, lines in sorted(model.unknown.items()):
            numbers = ", ".join(map(str, lines[:5])) + ", …" * (len(lines) > 5)
            foot.append(f"# {len(lines):4d} {name}, line {numbers}")
        foot.append("")
    text = "\n".join([*head, *tables]) + "\n" + "\n".join(foot)
    parse_case(text, Path(folder) / "case.toml")
    return Converted(text, len(pairs), len(bodies), model.unknown)


def _owners(pair: _Pair, parts: DeckParts) -> list[int]:
    """Return the rigid parts that the points of a slave move with; none if it deforms or rests."""
    return [part for part in pair.parts if parts.is_rigid(part)]


def _pairs(model: DeckModel, parts: DeckParts) -> list[_Pair]:
    """Return the contacts of the case; contacts of the deck that give none are noted in `model`."""
    pairs: list[_Pair] = []
    for contact in model.contacts:
        sides = [_parts_of_side(*side, parts) for side in contact.sides]
        reason = next((side for side in sides if isinstance(side, str)), "")
        new_pairs: list[_Pair] = []
        if not reason:
            first, second = (side for side in sides if not isinstance(side, str))
            new_pairs = list(_pairs_of(contact, first, second, parts))
        if not new_pairs:
            model.drop(contact.block, reason or "no rigid part on either side")
        pairs += new_pairs
    return pairs


def _parts_of_side(kind: int, number: int, parts: DeckParts) -> list[int] | str | None:
    """Return the parts on a side, None for a set of nodes, or a text: why it is not understood.

    `kind` is the side's SSTYP: 2 a set of parts, 3 a part, 4 a set of nodes, 5 all parts, 6 all but
    a set of parts; number 0 means all parts, too. Only parts that have elements are returned.
    """
    model, all_parts = parts.model, list(parts.groups)
    if kind == _NODE_SET:
        return model.no_set("NODE", number) or None
    if kind == 5 or number == 0:
        return all_parts
    if kind == 3:
        return [part for part in all_parts if part == number]
    if kind in (2, 6):
        part_set = model.part_sets.get(number, [])
        members = [part for part in all_parts if (part in part_set) != (kind == 6)]
        return model.no_set("PART", number) or members
    return f"SSTYP {kind}, a side of segments or elements"


def _pairs_of(
    contact: DeckContact, first: list[int] | None, second: list[int] | None, parts: DeckParts
) -> Iterator[_Pair]:
    """Yield the contacts of each rigid master: with all deforming parts, and each other rigid part.

    A side of a contact is a list of parts, or None for a set of nodes. Deforming parts of the other
    side are one slave; a pair of rigid parts gives one contact, whichever sides it is on. A set of
    nodes touches the rigid parts of the other side that it does not belong to.
    """
    if first is None or second is None:
        swapped = first is not None
        nodes = contact.sides[1 if swapped else 0][1]
        owner = parts.owner(nodes)
        for master in (first if swapped else second) or ():
            if parts.is_rigid(master) and master != owner:
                yield _Pair(master, () if owner is None else (owner,), nodes, contact, swapped)
        return
    for master in filter(parts.is_rigid, dict.fromkeys([*second, *first])):
        partners = {*(first if master in second else ()), *(second if master in first else ())}
        soft = tuple(part for part in parts.groups if part in partners and not parts.is_rigid(part))
        if soft:
            yield _Pair(master, soft, 0, contact, master not in second)
    paired: set[frozenset[int]] = set()
    for master in filter(parts.is_rigid, second):
        for slave in filter(parts.is_rigid, first):
            if slave != master and frozenset((master, slave)) not in paired:
                paired.add(frozenset((master, slave)))
                yield _Pair(master, (slave,), 0, contact, swapped=False)


def _head(model: DeckModel, units: tuple[str, str, str]) -> list[str]:
    """Return the lines of title, units, time, gravity and output.

    Gravity by a curve that is missing or not constant is noted and left out. A deck without an end
    gets `model.end` = 1; fields are written at 200 times at most.
    """
    length, mass, time = map(value_text, units)
    lines = [
        f"# Made of {model.path.name} by contiga convert; the units are those that were given.",
        f"title = {value_text(model.title or model.path.stem)}",
        f"units = {{ length = {length}, mass = {mass}, time = {time} }}",
        "",
        "[time]",
    ]
    if model.end > 0.0:
        lines.append(f"end = {value_text(model.end)}  # *CONTROL_TERMINATION")
    else:
        model.end = 1.0
        lines.append("end = 1.0  # the deck has no *CONTROL_TERMINATION: set it")
    lines.append('step = "auto"')
    gravity, sources = [0.0, 0.0, 0.0], []
    for axis, (number, scale, block) in sorted(model.gravity.items()):
        curve = model.curve(number)
        table = np.zeros((0, 2)) if curve is None else curve.table
        if len(table) == 0 or np.ptp(table[:, 1]) > 0.0:
            fault = "its curve is missing" if len(table) == 0 else "its curve is not constant"
            model.drop(block, fault)
            continue
        gravity[axis] = -scale * float(table[0, 1])
        place = f"*{block.keyword}, {model.place(block)}"
        sources.append(f"# {place}: the base accelerates the other way")
    if sources:
        lines += ["", "[world]", *sources, f"gravity = {value_text(gravity)}"]
    interval = max(model.state_interval, model.end / _MAX_STATES)
    source = "  # *DATABASE_BINARY_D3PLOT" if interval == model.state_interval else ""
    return [*lines, "", "[output]", f"interval = {value_text(interval)}{source}"]


def _bodies(numbers: list[int], parts: DeckParts) -> Iterator[str]:
    """Yield the lines of bodies: geometry, motion, and a mass if forces move them."""
    model = parts.model
    for part in numbers:
        material = parts.material(part)
        assert material is not None
        yield from ("", "[[body]]")
        yield f"# *PART {part}, *{material.block.keyword} in {model.place(material.block)}"
        yield f"name = {value_text(parts.name(part))}"
        yield f"geometry = {value_text(parts.geometry(part))}"
        if "orient" in parts.geometry(part):
            yield "# Shells at their middle surface; flip = true where the other side is free."
        motion = parts.prescribed_motion(part, model.end)
        if motion is not None:
            places = [model.place(m.block, m.line) for m in model.motions if m.part == part]
            effect = "go on as they start" if "velocity" in motion else "stand still"
            source = f"*BOUNDARY_PRESCRIBED_MOTION_RIGID, {', '.join(places)}"
            yield f"# {source}; its other ways {effect}"
            yield f"motion = {value_text(motion)}"
            continue
        motion = parts.free_motion(part)
        if motion is None:
            yield "# CON1 and CON2 of its material hold it."
            continue
        mass, comment = parts.mass(part)
        yield f"mass = {value_text(mass)}  # {comment}"
        yield f"motion = {value_text(motion)}"


def _contacts(pairs: list[_Pair], parts: DeckParts, soft: _Soft) -> Iterator[str]:
    """Yield the lines of the contacts; the lines of a slave come before its first contact.

    A slave without facets gets an area of 1 a node, to be set by hand. A contact whose default name
    is taken gets a number. Friction needs a static coefficient above zero.
    """
    slaves: set[str] = set()
    titles: set[str] = set()
    for pair in pairs:
        owner = next(iter(_owners(pair, parts)), None)
        selection: list[str | int]
        if pair.nodes:
            slave, selection = parts.nodes_name(pair.nodes), [set_name(pair.nodes)]
        elif owner is not None:
            slave, selection = f"{parts.name(owner)} points", [owner]
        else:
            slave, selection = parts.slave_name(pair.parts), list(pair.parts)
        if slave not in slaves:
            slaves.add(slave)
            yield from ("", "[[slave]]", f"name = {value_text(slave)}")
            yield f"points = {value_text({'file': parts.file, 'parts': selection})}"
            deformation = soft.get(pair.parts)
            if owner is not None:
                motion = {"kind": "attached", "body": parts.name(owner)}
                yield f"motion = {value_text(motion)}"
            elif deformation is None:
                yield f"# {_REST_COMMENT}"
            else:
                yield f"# {deformation.source}"
                yield f"motion = {value_text(deformation.motion)}"
        contact = pair.contact
        yield from ("", "[[contact]]")
        swap = "; its sides are swapped, as masters are rigid" if pair.swapped else ""
        yield f"# *{contact.block.keyword}, {parts.model.place(contact.block)}{swap}"
        title = f"{parts.name(pair.master)}-{slave}"
        if title in titles:
            yield f"name = {value_text(f'{title} {len(titles)}')}"
        titles.add(title)
        yield f"master = {value_text(parts.name(pair.master))}"
        yield f"slave = {value_text(slave)}"
        part = pair.parts[0] if pair.parts else parts.part_of(pair.nodes)
        scale = contact.scales.real("SFM" if pair.swapped else "SFS")
        yield parts.law(selection, part, scale)
        if not parts.has_facets(selection):
            yield 'area = { kind = "constant", value = 1.0 }  # of each node: set it'
        static, dynamic, decay = contact.friction
        if static > 0.0:
            scale = contact.scales.real("FSF")
            friction: dict[str, Any] = {"kind": "coulomb", "static": scale * static}
            if decay > 0.0 and 0.0 <= scale * dynamic <= scale * static:
                friction |= {"dynamic": scale * dynamic, "decay": decay}
            source = "FS, FD, DC" + ", FSF" * (scale != 1.0)
            yield f"friction = {value_text(friction)}  # {source}"


def parse_units(text: str) -> tuple[str, str, str]:
    """Return the length, mass and time unit of a text such as ``mm,kg,ms``, unchecked.

    Raises
    ------
    InputError
        They are not three words.

    >>> parse_units("mm, kg, ms")
    ('mm', 'kg', 'ms')
    """
    units = tuple(unit.strip() for unit in text.split(","))
    if len(units) != 3 or not all(units):
        raise InputError(
            "must be three units", where="--units", found=text, allowed="length,mass,time: mm,kg,ms"
        )
    return units[0], units[1], units[2]
