"""Parts of an LS-DYNA deck that deform in a case, too: what they are made of and held by."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

from contiga.arrays.layout import positive
from contiga.case.deck_parts import DeckParts
from contiga.errors import InputError
from contiga.io.mesh.lsdyna_deck import Material
from contiga.io.mesh.lsdyna_sets import set_name
from contiga.io.mesh.lsdyna_ties import NodeTie
from contiga.io.mesh.raw import Group
from contiga.matter.foam import Foam
from contiga.matter.materials import Elastic, NeoHooke
from contiga.matter.woven import Fabric

_MATERIALS: dict[str, Callable[..., Any]] = {
    "elastic": Elastic,
    "neo-hooke": NeoHooke,
    "foam": Foam,
    "fabric": Fabric,
}


class SoftSlave(NamedTuple):
    """How a slave deforms."""

    motion: dict[str, Any]
    """Its table in the case."""
    source: str
    """Where in the deck it comes from."""
    hosts: list[int]
    """Rigid parts that carry nodes of it."""


class _Ties(NamedTuple):
    """What holds nodes of a slave."""

    fixed: list[dict[str, Any]]
    attached: list[dict[str, Any]]
    """Tables of the case."""
    hosts: list[int]
    """Rigid parts that carry nodes."""
    cards: list[NodeTie]
    sources: list[str]


def deforming(parts: DeckParts, numbers: list[int]) -> SoftSlave | None:
    """How a slave of some parts deforms; None where they rest.

    They deform where all of them are of a material that is understood and something holds some of
    their nodes: what nothing holds would fly, and what is in two slaves would be there twice.
    """
    if any(number in parts.in_several for number in numbers):
        return None  # what holds it is listed
    materials = [parts.material(number) for number in numbers]
    soft = [one for one in materials if one is not None and one.soft is not None]
    ties = _ties_of(parts, numbers)
    if not ties.sources or len(soft) < len(numbers):
        return None
    tables = [_made_of(parts, number, one) for number, one in zip(numbers, soft, strict=True)]
    if any(table is None for table in tables):
        return None
    motion: dict[str, Any] = {"kind": "deform"}
    if len(numbers) == 1:
        motion |= tables[0] or {}
    else:
        motion["parts"] = [
            {"set": number} | (table or {}) for number, table in zip(numbers, tables, strict=True)
        ]
    parts.tied += ties.cards
    held = {"fixed": ties.fixed, "attached": ties.attached}
    motion |= {key: value for key, value in held.items() if value}
    velocity = parts.common_velocity(numbers)
    if velocity is not None:
        motion["velocity"] = velocity
    places = [f"*{one.block.keyword}, {parts.model.place(one.block)}" for one in soft]
    notes = [one.soft.note for one in soft if one.soft is not None and one.soft.note]
    if any(map(_bends, map(parts.is_shell, numbers), soft)):
        notes.append("its shells are membranes, without bending")
    source = "; ".join(dict.fromkeys([*places, *notes, *ties.sources]))
    return SoftSlave(motion, source, ties.hosts)


def in_several(
    slaves: Iterable[tuple[int, ...]], parts: DeckParts, sets: Iterable[int]
) -> set[int]:
    """Parts that are in several slaves of parts, or have nodes of sets that are slaves."""
    different = list(dict.fromkeys(slaves))
    several = {
        part
        for k, one in enumerate(different)
        for part in one
        if any(part in other for other in different[:k])
    }
    chosen = {set_name(number) for number in sets}
    nodes = {node for group in parts.mesh.groups if group.name in chosen for node in _nodes(group)}
    if nodes:
        several |= {
            part
            for part, group in parts.groups.items()
            if nodes & {int(node) for node in parts.nodes_of(group)}
        }
    return several


def _ties_of(parts: DeckParts, numbers: list[int]) -> _Ties:
    """What holds nodes of some parts: rigid parts they share nodes with, and cards."""
    own = _nodes_of(parts, numbers)
    ties = _Ties([], [], [], [], [])
    carried: dict[int, set[int]] = {}
    for part in filter(parts.is_rigid, parts.groups):
        shared = _nodes_of(parts, [part]) & own
        if shared:
            carried[part] = shared
            ties.attached.append({"set": part, "body": parts.name(part)})
            ties.sources.append(f"nodes shared with *PART {part}")
    for (name, ways, part), cards in _alike(parts.model.ties).items():
        there = _members(parts, name) & own
        if not there or (part and not (part in parts.groups and parts.is_rigid(part))):
            continue
        done = bool(part) and there <= carried.get(part, set())
        if not done and any(there & nodes for nodes in carried.values()):
            why = f"{name}: some go with a rigid part already"
            parts.model.leave(cards[0].block, why, cards[0].line)
            continue
        ties.cards.extend(cards)
        place = parts.model.place(cards[0].block, cards[0].line)
        ties.sources.append(f"*{cards[0].block.keyword}, {place}")
        if part and not done:
            carried[part] = carried.get(part, set()) | there
            ties.attached.append({"set": name, "body": parts.name(part)})
        elif not part:
            ties.fixed.append({"set": name, "hold": [*ways]})
    ties.hosts.extend(carried)
    return ties


def _alike(ties: Iterable[NodeTie]) -> dict[tuple[str, str, int], list[NodeTie]]:
    """Cards by the nodes they are of and what becomes of these."""
    alike: dict[tuple[str, str, int], list[NodeTie]] = {}
    for tie in ties:
        alike.setdefault((tie.nodes, tie.ways, tie.part), []).append(tie)
    return alike


def _nodes_of(parts: DeckParts, numbers: list[int]) -> set[int]:
    return {int(node) for number in numbers for node in parts.nodes_of(parts.groups[number])}


def _members(parts: DeckParts, name: str) -> set[int]:
    """Nodes of a set."""
    group = next((g for g in parts.mesh.groups if g.name == name), None)
    return set() if group is None else _nodes(group)


def _nodes(group: Group) -> set[int]:
    return set() if group.nodes is None else {int(node) for node in group.nodes}


def _bends(shell: bool, material: Material) -> bool:
    return shell and material.soft is not None and not material.soft.membrane


def _made_of(parts: DeckParts, number: int, material: Material) -> dict[str, Any] | None:
    """`material`, `density` and of shells `thickness`; None of what makes no material."""
    soft = material.soft
    assert soft is not None
    table = dict(soft.table)
    for key, curve in soft.curves.items():
        points = parts.model.curve(curve)
        if points is None:
            parts.model.leave(material.block, f"there is no curve {curve}")
            return None
        table[key] = points.table
    made: dict[str, Any] = {"density": material.density}
    try:
        positive(material.density, "density")
        _MATERIALS[table["kind"]](**{key: table[key] for key in table if key != "kind"})
        if parts.is_shell(number):
            made["thickness"] = positive(parts.thickness(number), "the thickness of its shells")
    except InputError as error:
        parts.model.leave(material.block, f"{error.where} {error.what}")
        return None
    table |= {key: {"file": parts.file, "curve": curve} for key, curve in soft.curves.items()}
    return {"material": table} | made
