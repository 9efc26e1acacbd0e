"""Parts of an LS-DYNA deck that deform in a case, too: what they are made of and held by."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

from contiga.arrays.layout import positive
from contiga.case.deck_parts import DeckParts
from contiga.errors import InputError
from contiga.io.mesh.lsdyna_deck import HeldNodes, Material
from contiga.io.mesh.lsdyna_sets import set_name
from contiga.io.mesh.raw import Group
from contiga.matter.foam import Foam
from contiga.matter.materials import Elastic, NeoHooke

_MATERIALS: dict[str, Callable[..., Any]] = {
    "elastic": Elastic,
    "neo-hooke": NeoHooke,
    "foam": Foam,
}


class SoftSlave(NamedTuple):
    """How a slave deforms."""

    motion: dict[str, Any]
    """Its table in the case."""
    source: str
    """Where in the deck it comes from."""


def deforming(parts: DeckParts, numbers: list[int]) -> SoftSlave | None:
    """How a slave of some parts deforms; None where they rest.

    They deform where all of them are of a material that is understood and a set of nodes holds
    some of them: what nothing holds would fly, and what is in two slaves would be there twice.
    """
    twice = [number for number in numbers if number in parts.in_several]
    if twice:
        return None  # what holds it is listed
    materials = [parts.material(number) for number in numbers]
    soft = [one for one in materials if one is not None and one.soft is not None]
    held = list(_held(parts, numbers))
    if not held or len(soft) < len(numbers):
        return None
    tables = [_made_of(parts, one) for one in soft]
    if any(table is None for table in tables):
        return None
    motion: dict[str, Any] = {"kind": "deform"}
    if len(numbers) == 1:
        motion |= tables[0] or {}
    else:
        motion["parts"] = [
            {"set": number} | (table or {}) for number, table in zip(numbers, tables, strict=True)
        ]
    parts.holding += held
    motion["fixed"] = [{"set": set_name(one.number), "hold": [*one.ways]} for one in held]
    velocity = parts.common_velocity(numbers)
    if velocity is not None:
        motion["velocity"] = velocity
    blocks = [one.block for one in soft]
    places = [f"*{block.keyword}, {parts.model.place(block)}" for block in blocks]
    notes = [one.soft.note for one in soft if one.soft is not None and one.soft.note]
    holds = [f"*{one.block.keyword}, {parts.model.place(one.block, one.line)}" for one in held]
    return SoftSlave(motion, "; ".join(dict.fromkeys([*places, *notes, *holds])))


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


def _held(parts: DeckParts, numbers: list[int]) -> Iterable[HeldNodes]:
    """What holds nodes of some parts."""
    own = {int(node) for number in numbers for node in parts.nodes_of(parts.groups[number])}
    for one in parts.model.held:
        group = next((g for g in parts.mesh.groups if g.name == set_name(one.number)), None)
        if group is not None and _nodes(group) & own:
            yield one


def _nodes(group: Group) -> set[int]:
    return set() if group.nodes is None else {int(node) for node in group.nodes}


def _made_of(parts: DeckParts, material: Material) -> dict[str, Any] | None:
    """`material` and `density`; None of a foam whose curve is not there."""
    soft = material.soft
    assert soft is not None
    table = dict(soft.table)
    if soft.curve:
        curve = parts.model.curve(soft.curve)
        if curve is None:
            parts.model.leave(material.block, f"there is no curve {soft.curve}")
            return None
        table["loading"] = curve.table
    try:
        positive(material.density, "density")
        _MATERIALS[table["kind"]](**{key: table[key] for key in table if key != "kind"})
    except InputError as error:
        parts.model.leave(material.block, f"{error.where} {error.what}")
        return None
    if soft.curve:
        table["loading"] = {"file": parts.file, "curve": soft.curve}
    return {"material": table, "density": material.density}
