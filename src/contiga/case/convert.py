"""Cases from LS-DYNA keyword decks: rigid parts become masters, their partners slaves.

What is written can be read and changed by hand; what is not understood is listed, not guessed.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from contiga.case.deck_matter import SoftSlave, deforming, in_several
from contiga.case.deck_parts import DeckParts
from contiga.case.schema import parse_case
from contiga.case.toml import value_text
from contiga.errors import FileError, InputError
from contiga.io.mesh.lsdyna_deck import DeckContact, DeckModel
from contiga.io.mesh.lsdyna_model import read_model
from contiga.io.mesh.lsdyna_sets import set_name
from contiga.io.units import base_factor

_RESTS = "Deforms in the deck; here its points rest, and give way by the law of the contact."
_NODES = 4
"""Kind of a side that is a set of nodes."""
_STATES = 200
"""Largest number of states that a case writes."""


class Converted(NamedTuple):
    """A case made of a deck."""

    text: str
    """TOML with comments."""
    contacts: int
    bodies: int
    unknown: dict[str, list[int]]
    """Keywords that were not understood, and their lines."""


_Soft = dict[tuple[int, ...], SoftSlave | None]
"""How slaves deform, by their parts."""


class _Pair(NamedTuple):
    """One contact of the case: a rigid part and what may touch it."""

    master: int
    parts: tuple[int, ...]
    """Parts of the slave; none for a set of nodes, or the rigid one they belong to."""
    nodes: int
    """The set of nodes; 0 if the slave is parts."""
    of: DeckContact
    swapped: bool


def convert(deck: str | Path, units: tuple[str, str, str], folder: str | Path) -> Converted:
    """Return a case made from a keyword deck.

    Parameters
    ----------
    deck : the keyword file
    units : length, mass and time unit of its numbers; decks name none
    folder : where the case will stand, so that it finds the deck

    Raises
    ------
    FileError, MeshError
        The deck cannot be read, or no contact in it is one with a rigid part.
    UnitError
        A unit is none.
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
    parts.in_several = in_several(
        [pair.parts for pair in pairs if not pair.nodes and not _owners(pair, parts)],
        parts,
        [pair.nodes for pair in pairs if pair.nodes and not _owners(pair, parts)],
    )
    head = _head(model, units)
    slaves = dict.fromkeys(pair.parts for pair in pairs if not _owners(pair, parts))
    soft = {slave: deforming(parts, list(slave)) for slave in slaves if slave}
    bodies = {part for pair in pairs for part in (pair.master, *_owners(pair, parts))}
    bodies |= {host for one in soft.values() if one is not None for host in one.hosts}
    tables = [*_bodies(sorted(bodies), parts), *_contacts(pairs, parts, soft)]
    text = "\n".join([*head, *tables])
    parts.leave_nodes()
    parts.leave_ties()
    parts.leave_masses(bodies)
    model.leave_unread()
    text += "\n" + "\n".join(_foot(model))
    parse_case(text, Path(folder) / "case.toml")
    return Converted(text, len(pairs), len(bodies), model.unknown)


def _owners(pair: _Pair, parts: DeckParts) -> list[int]:
    """Return the rigid parts that the points of a slave move with."""
    return [part for part in pair.parts if parts.is_rigid(part)]


def _pairs(model: DeckModel, parts: DeckParts) -> list[_Pair]:
    pairs: list[_Pair] = []
    for contact in model.contacts:
        why = next(filter(None, (_no_side(side, model) for side in contact.sides)), "")
        sides = [] if why else [_members(side, model, parts) for side in contact.sides]
        contacts = [] if why else list(_of_contact(contact, sides, parts))
        if not contacts:
            model.drop(contact.block, why or "no rigid part on either side")
        pairs += contacts
    return pairs


def _no_side(side: tuple[int, int], model: DeckModel) -> str:
    """Return why a side is not understood; empty if it is."""
    kind, number = side
    if kind == _NODES:
        return model.no_set("NODE", number)
    if kind in (3, 5) or number == 0:
        return ""
    if kind in (2, 6):
        return model.no_set("PART", number)
    return f"SSTYP {kind}, a side of segments or elements"


def _members(side: tuple[int, int], model: DeckModel, parts: DeckParts) -> list[int] | None:
    """Return the parts on a side that have elements; None for a set of nodes."""
    kind, number = side
    if kind == _NODES:
        return None
    every = list(parts.groups)
    if kind == 5 or number == 0:
        return every
    named = model.part_sets.get(number, []) if kind in (2, 6) else [number] * (kind == 3)
    return [part for part in every if (part in named) != (kind == 6)] if kind in (2, 3, 6) else []


def _of_contact(
    contact: DeckContact, sides: list[list[int] | None], parts: DeckParts
) -> Iterator[_Pair]:
    """Yield the contacts of each rigid master: with all deforming parts, and other rigid parts."""
    a, b = sides
    if a is None or b is None:
        nodes, others = (contact.sides[0][1], b) if a is None else (contact.sides[1][1], a)
        owner = parts.owner(nodes)
        for master in others or ():
            if parts.is_rigid(master) and master != owner:
                owners = () if owner is None else (owner,)
                yield _Pair(master, owners, nodes, contact, a is not None)
        return
    for master in filter(parts.is_rigid, dict.fromkeys([*b, *a])):
        met = {*(a if master in b else ()), *(b if master in a else ())}
        soft = tuple(part for part in parts.groups if part in met and not parts.is_rigid(part))
        if soft:
            yield _Pair(master, soft, 0, contact, master not in b)
    paired: set[frozenset[int]] = set()
    for master in filter(parts.is_rigid, b):
        for slave in filter(parts.is_rigid, a):
            if slave != master and frozenset((master, slave)) not in paired:
                paired.add(frozenset((master, slave)))
                yield _Pair(master, (slave,), 0, contact, swapped=False)


def _head(model: DeckModel, units: tuple[str, str, str]) -> list[str]:
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
    lines += ['step = "auto"', *_gravity(model), "", "[output]"]
    interval = max(model.states, model.end / _STATES)
    source = "  # *DATABASE_BINARY_D3PLOT" if interval == model.states else ""
    return [*lines, f"interval = {value_text(interval)}{source}"]


def _gravity(model: DeckModel) -> list[str]:
    gravity, lines = [0.0, 0.0, 0.0], []
    for axis, (number, scale, block) in sorted(model.gravity.items()):
        curve = model.curve(number)
        table = np.zeros((0, 2)) if curve is None else curve.table
        if len(table) == 0 or np.ptp(table[:, 1]) > 0.0:
            why = "its curve is missing" if len(table) == 0 else "its curve is not constant"
            model.drop(block, why)
            continue
        gravity[axis] = -scale * float(table[0, 1])
        place = f"*{block.keyword}, {model.place(block)}"
        lines.append(f"# {place}: the base accelerates the other way")
    return ["", "[world]", *lines, f"gravity = {value_text(gravity)}"] if lines else []


def _bodies(numbers: list[int], parts: DeckParts) -> Iterator[str]:
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
        motion = parts.prescribed(part, model.end)
        if motion is not None:
            places = [model.place(m.block, m.line) for m in model.motions if m.part == part]
            others = "go on as they start" if "velocity" in motion else "stand still"
            source = f"*BOUNDARY_PRESCRIBED_MOTION_RIGID, {', '.join(places)}"
            yield f"# {source}; its other ways {others}"
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
    written: set[str] = set()
    names: set[str] = set()
    for pair in pairs:
        slave, chosen, owner = _slave(pair, parts)
        if slave not in written:
            written.add(slave)
            motion = None if owner is None else parts.name(owner)
            yield from _slave_table(slave, chosen, parts.file, motion, soft.get(pair.parts))
        yield from ("", "[[contact]]")
        swap = "; its sides are swapped, as masters are rigid" if pair.swapped else ""
        yield f"# *{pair.of.block.keyword}, {parts.model.place(pair.of.block)}{swap}"
        title = f"{parts.name(pair.master)}-{slave}"
        if title in names:
            yield f"name = {value_text(f'{title} {len(names)}')}"
        names.add(title)
        yield f"master = {value_text(parts.name(pair.master))}"
        yield f"slave = {value_text(slave)}"
        inner = pair.parts[0] if pair.parts else parts.part_of(pair.nodes)
        scale = pair.of.scales.real("SFM" if pair.swapped else "SFS")
        yield parts.law(chosen, inner, scale)
        if not parts.has_facets(chosen):
            yield 'area = { kind = "constant", value = 1.0 }  # of each node: set it'
        yield from _friction(pair.of)


def _slave(pair: _Pair, parts: DeckParts) -> tuple[str, list[str | int], int | None]:
    """Return the name of a slave, its selection from the mesh, and the rigid part it moves with."""
    owner = next(iter(_owners(pair, parts)), None)
    if pair.nodes:
        return parts.nodes_name(pair.nodes), [set_name(pair.nodes)], owner
    if owner is not None:
        return f"{parts.name(owner)} points", [owner], owner
    return parts.slave_name(pair.parts), list(pair.parts), None


def _slave_table(
    name: str,
    chosen: list[str | int],
    file: str,
    owner: str | None,
    soft: SoftSlave | None,
) -> Iterator[str]:
    yield from ("", "[[slave]]", f"name = {value_text(name)}")
    yield f"points = {value_text({'file': file, 'parts': chosen})}"
    if owner is not None:
        yield f"motion = {value_text({'kind': 'attached', 'body': owner})}"
    elif soft is None:
        yield f"# {_RESTS}"
    else:
        yield f"# {soft.source}"
        yield f"motion = {value_text(soft.motion)}"


def _friction(contact: DeckContact) -> Iterator[str]:
    static, dynamic, decay = contact.friction
    if static <= 0.0:
        return
    scale = contact.scales.real("FSF")
    static, dynamic = scale * static, scale * dynamic
    friction: dict[str, Any] = {"kind": "coulomb", "static": static}
    if decay > 0.0 and 0.0 <= dynamic <= static:
        friction |= {"dynamic": dynamic, "decay": decay}
    yield f"friction = {value_text(friction)}  # FS, FD, DC{', FSF' * (scale != 1.0)}"


def _foot(model: DeckModel) -> list[str]:
    if not model.unknown:
        return []
    listed = [
        f"# {len(lines):4d} {name}, line {', '.join(map(str, lines[:5]))}{', …' * (len(lines) > 5)}"
        for name, lines in sorted(model.unknown.items())
    ]
    return ["", "# Not understood, and left out:", *listed, ""]


def parse_units(text: str) -> tuple[str, str, str]:
    """Return the length, mass and time unit of a text such as ``mm,kg,ms``.

    Raises
    ------
    InputError
        They are not three.

    >>> parse_units("mm, kg, ms")
    ('mm', 'kg', 'ms')
    """
    units = tuple(unit.strip() for unit in text.split(","))
    if len(units) != 3 or not all(units):
        raise InputError(
            "must be three units", where="--units", found=text, allowed="length,mass,time: mm,kg,ms"
        )
    return units[0], units[1], units[2]
