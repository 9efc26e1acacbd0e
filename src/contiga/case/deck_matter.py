"""Deforming parts of an LS-DYNA deck in a case: materials and constraints."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from contiga.arrays.layout import positive
from contiga.case.deck_parts import DeckParts
from contiga.case.deform_spec import DeformSpec
from contiga.case.points_spec import FilePoints
from contiga.case.problems import first_problem
from contiga.case.schema import SlaveSpec
from contiga.case.slave_motion import deforming_of
from contiga.dynamics.prescribed import Fixed
from contiga.errors import ContigaError, InputError
from contiga.io.mesh.lsdyna_deck import Material
from contiga.io.mesh.lsdyna_sets import set_name
from contiga.io.mesh.lsdyna_ties import NodeTie
from contiga.io.mesh.raw import Group
from contiga.matter.foam import Foam
from contiga.matter.materials import Elastic, NeoHooke
from contiga.matter.woven import Fabric

_SMOOTHED = 12
"""Steps over which strain rates are smoothed."""
_MATERIALS: dict[str, Callable[..., Any]] = {
    "elastic": Elastic,
    "neo-hooke": NeoHooke,
    "foam": Foam,
    "fabric": Fabric,
}


class SoftSlave(NamedTuple):
    """Deformation of a slave."""

    motion: dict[str, Any]
    """Its table in the case."""
    source: str
    """Place in the deck that it comes from."""
    hosts: list[int]
    """Rigid parts that carry nodes of it."""


class _Ties(NamedTuple):
    """Ties of the nodes of a slave."""

    fixed: list[dict[str, Any]]
    attached: list[dict[str, Any]]
    """Tables of the case."""
    hosts: list[int]
    """Rigid parts that carry nodes."""
    cards: list[NodeTie]
    sources: list[str]
    clashes: list[NodeTie]
    """Cards whose nodes move with another rigid part already."""


def deforming(parts: DeckParts, numbers: list[int]) -> SoftSlave | None:
    """Return the deformation of a slave of some parts; None if they rest.

    They deform where all of them are of a material that is understood and something holds some of
    their nodes: what nothing holds would fly, and what is in two slaves would be there twice.
    """
    if any(number in parts.in_several for number in numbers):
        return None  # its ties are reported
    materials = [one for number in numbers if (one := parts.material(number)) is not None]
    soft = [one for one in materials if one.soft is not None]
    ties = _ties_of(parts, numbers)
    for one in materials if ties.sources else ():
        if one.unmade:
            parts.model.leave(one.block, one.unmade)
    if len(soft) < len(numbers) or not (ties.sources or ties.clashes):
        return None
    if torn := _torn(parts, numbers):
        parts.model.leave(soft[0].block, torn)
        return None
    for tie in ties.clashes:
        why = f"{tie.nodes}: some go with a rigid part already, so all of the slave rests"
        parts.model.leave(tie.block, why, tie.line)
        parts.tied.add(tie.key)
    if ties.clashes:
        return None
    tables = [
        _material_table(parts, number, one) for number, one in zip(numbers, soft, strict=True)
    ]
    if any(table is None for table in tables):
        return None
    motion: dict[str, Any] = {"kind": "deform"}
    if len(numbers) == 1:
        motion |= tables[0] or {}
    else:
        motion["parts"] = [
            {"set": number} | (table or {}) for number, table in zip(numbers, tables, strict=True)
        ]
    masses = parts.masses(_nodes_of(parts, numbers), ties.hosts)
    held = {"fixed": ties.fixed, "attached": ties.attached, "masses": masses}
    motion |= {key: value for key, value in held.items() if value}
    if problem := _problem(parts, numbers, motion):
        parts.model.leave(soft[0].block, problem)
        return None
    parts.tied |= {tie.key for tie in ties.cards}
    parts.weighed.update(masses["nodes"] if masses else ())
    velocity = parts.common_velocity(numbers)
    if velocity is not None:
        motion["velocity"] = velocity
    places = [f"*{one.block.keyword}, {parts.model.place(one.block)}" for one in soft]
    notes = [one.soft.note for one in soft if one.soft is not None and one.soft.note]
    if any("filter" in (table or {})["material"] for table in tables):
        notes.append("its rates are smoothed over some steps, filter")
    if any(map(_bends, map(parts.is_shell, numbers), soft)):
        notes.append("its shells are membranes, without bending")
    if masses:
        notes.append(f"masses of {sum(masses['mass']):g} by *ELEMENT_MASS")
    source = "; ".join(dict.fromkeys([*places, *notes, *ties.sources]))
    return SoftSlave(motion, source, ties.hosts)


def _torn(parts: DeckParts, numbers: list[int]) -> str:
    """Name a part that deforms apart from the slave but shares its nodes; empty if none."""
    of_slave = _nodes_of(parts, numbers)
    for part in parts.groups:
        apart = part in numbers or parts.is_rigid(part)
        if not apart and (_nodes_of(parts, [part]) & of_slave).any():
            return f"part {part} shares nodes with it and is not of its slave, which rests"
    return ""


def _problem(parts: DeckParts, numbers: list[int], motion: dict[str, Any]) -> str:
    """Return why a slave cannot deform; empty if it can."""
    points = {"file": parts.file, "parts": numbers}
    table = {"name": parts.slave_name(tuple(numbers)), "points": points, "motion": motion}
    length, mass, time = parts.units
    units = {"length": length, "mass": mass, "time": time}
    context = {"folder": parts.folder, "units": units}
    try:
        spec = SlaveSpec.model_validate(table, context=context)
        assert isinstance(spec.points, FilePoints)
        assert isinstance(spec.motion, DeformSpec)
        slave = spec.points.slave(spec.name, length)
        deforming_of(spec, spec.motion, slave, lambda told: Fixed(), length)
    except ValidationError as error:
        return first_problem(error, table, "").what
    except ContigaError as error:
        return f"{error.what}, so the slave rests" if isinstance(error, InputError) else str(error)
    return ""


def in_several(
    slaves: Iterable[tuple[int, ...]], parts: DeckParts, sets: Iterable[int]
) -> set[int]:
    """Return the parts that are in several slaves, or share nodes with sets that are slaves."""
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
    """Return the ties of the nodes of some parts: rigid parts that share them, and cards."""
    of_slave = _nodes_of(parts, numbers)
    ties = _Ties([], [], [], [], [], [])
    host = np.full(len(of_slave), -1)
    for part in filter(parts.is_rigid, parts.groups):
        shared = _nodes_of(parts, [part]) & of_slave
        if shared.any():
            host[shared] = part
            ties.hosts.append(part)
            ties.attached.append({"set": part, "body": parts.name(part)})
            ties.sources.append(f"nodes shared with *PART {part}")
    for (name, ways, part), all_cards in _alike(parts.model.ties).items():
        there = _members(parts, name) & of_slave
        numbers_there = set(_numbers(parts)[there].tolist())
        cards = [tie for tie in all_cards if not tie.one or tie.number in numbers_there]
        if not there.any() or (part and not (part in parts.groups and parts.is_rigid(part))):
            continue
        if ((host[there] >= 0) & (host[there] != (part or -1))).any():
            ties.clashes.extend(cards)
            continue
        ties.cards.extend(cards)
        place = parts.model.place(cards[0].block, cards[0].line)
        ties.sources.append(f"*{cards[0].block.keyword}, {place}")
        if part:
            host[there] = part
            ties.hosts.extend([part] * (part not in ties.hosts))
            ties.attached.append({"set": name, "body": parts.name(part)})
        else:
            ties.fixed.append({"set": name, "hold": [*ways]})
    return ties


def _alike(ties: Iterable[NodeTie]) -> dict[tuple[str, str, int], list[NodeTie]]:
    """Group cards by their nodes and their effect on these; those that carry come first."""
    alike: dict[tuple[str, str, int], list[NodeTie]] = {}
    for tie in sorted(ties, key=lambda tie: tie.part == 0):
        alike.setdefault((tie.nodes, tie.ways, tie.part), []).append(tie)
    return alike


def _nodes_of(parts: DeckParts, numbers: list[int]) -> NDArray[np.bool_]:
    """Return a mask (n,) of the nodes of the mesh that elements of some parts have."""
    mask = np.zeros(len(parts.mesh.points), np.bool_)
    for number in numbers:
        mask[parts.nodes_of(parts.groups[number])] = True
    return mask


def _numbers(parts: DeckParts) -> NDArray[Any]:
    """Return the numbers (n,) of the mesh's nodes in the deck."""
    numbers = parts.mesh.node_ids
    return np.zeros(len(parts.mesh.points), np.int64) if numbers is None else numbers


def _members(parts: DeckParts, name: str) -> NDArray[np.bool_]:
    """Return a mask (n,) of the nodes of the mesh that are in a set."""
    mask = np.zeros(len(parts.mesh.points), np.bool_)
    group = next((g for g in parts.mesh.groups if g.name == name), None)
    if group is not None and group.nodes is not None:
        mask[group.nodes] = True
    return mask


def _nodes(group: Group) -> set[int]:
    return set() if group.nodes is None else {int(node) for node in group.nodes}


def _bends(shell: bool, material: Material) -> bool:
    return shell and material.soft is not None and not material.soft.membrane


def _material_table(parts: DeckParts, number: int, material: Material) -> dict[str, Any] | None:
    """Return `material`, `density` and, for shells, `thickness`; None if it makes no material."""
    soft = material.soft
    assert soft is not None
    curves = dict(soft.curves)
    by_rate = sorted(parts.model.tables.get(soft.by_rate, []))
    if by_rate:
        curves["loading"] = by_rate[0][1]
    elif soft.by_rate:
        parts.model.leave(material.block, f"there is no table {soft.by_rate}")
        return None
    for curve in (*curves.values(), *(curve for _, curve in by_rate)):
        if parts.model.curve(curve) is None:
            parts.model.leave(material.block, f"there is no curve {curve}")
            return None

    def filled(table_of: Callable[[int], Any]) -> dict[str, Any]:
        """Return the table with its curves."""
        table = soft.table | {key: table_of(curve) for key, curve in curves.items()}
        if len(by_rate) > 1:
            table["rates"] = [
                {"rate": rate, "loading": table_of(curve)} for rate, curve in by_rate[1:]
            ]
            table["filter"] = _filter(parts, number, material)
        return table

    made: dict[str, Any] = {}
    try:
        positive(material.density, "density")
        made["density"] = parts.density(number)
        table = filled(lambda curve: parts.model.curves[curve].table)
        rates = tuple((one["rate"], one["loading"]) for one in table.pop("rates", ()))
        kind = table.pop("kind")
        _MATERIALS[kind](**table, **({"rates": rates} if rates else {}))
        if parts.is_shell(number):
            made["thickness"] = parts.thickness(number)
    except InputError as error:
        parts.model.leave(material.block, f"{error.where} {error.what}")
        return None
    return {"material": filled(lambda curve: {"file": parts.file, "curve": curve})} | made


def _filter(parts: DeckParts, number: int, material: Material) -> float:
    """Return the smoothing time of rates: some steps of about facet size over wave speed."""
    speed = (material.modulus / material.density) ** 0.5
    return float(f"{_SMOOTHED * parts.size_of_facets([number]) / speed:.3g}")
