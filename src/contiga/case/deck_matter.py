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
from contiga.case.problems import first_error
from contiga.case.schema import SlaveSpec
from contiga.case.slave_motion import deforming_of
from contiga.dynamics.prescribed import Fixed
from contiga.errors import ContigaError, InputError
from contiga.io.mesh.lsdyna_deck import Material
from contiga.io.mesh.lsdyna_sets import set_name
from contiga.io.mesh.lsdyna_ties import NodeTie
from contiga.matter.foam import Foam
from contiga.matter.materials import Elastic, NeoHooke
from contiga.matter.woven import Fabric

_FILTER_STEPS = 12
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


def soft_slave(parts: DeckParts, numbers: list[int]) -> SoftSlave | None:
    """Return the deformation of a slave of some parts; None if they rest.

    They deform if each material is understood, some nodes are held (else they would fly off), no
    part is in another slave or shares nodes with a deforming part outside, no tie clashes with a
    rigid part, and the case accepts the result. The reason why parts rest is noted in the model;
    ties and lumped masses that the slave takes are marked in `parts`.
    """
    if any(number in parts.shared_parts for number in numbers):
        return None  # its ties are reported
    model = parts.model
    materials = [m for number in numbers if (m := parts.material(number)) is not None]
    soft = [material for material in materials if material.soft is not None]
    ties = _ties_of(parts, numbers)
    for material in materials if ties.sources else ():
        if material.no_law_reason:
            model.leave(material.block, material.no_law_reason)
    if len(soft) < len(numbers) or not (ties.sources or ties.clashes):
        return None
    nodes = _nodes_of(parts, numbers)
    for part in parts.groups:
        is_apart = part not in numbers and not parts.is_rigid(part)
        if is_apart and (_nodes_of(parts, [part]) & nodes).any():
            shared = f"part {part} shares nodes with it and is not of its slave, which rests"
            model.leave(soft[0].block, shared)
            return None
    for tie in ties.clashes:
        clash = f"{tie.nodes}: some go with a rigid part already, so all of the slave rests"
        model.leave(tie.block, clash, tie.line)
        parts.used_ties.add(tie.key)
    if ties.clashes:
        return None
    # Each part notes its own fault, so all tables are made before the slave is given up.
    tables_or_none = [
        _material_table(parts, n, material) for n, material in zip(numbers, soft, strict=True)
    ]
    tables = [table for table in tables_or_none if table is not None]
    if len(tables) < len(tables_or_none):
        return None
    motion: dict[str, Any] = {"kind": "deform"}
    if len(numbers) == 1:
        motion |= tables[0]
    else:
        motion["parts"] = [
            {"set": number} | table for number, table in zip(numbers, tables, strict=True)
        ]
    masses = parts.masses(nodes, ties.hosts)
    nodal = {"fixed": ties.fixed, "attached": ties.attached, "masses": masses}
    motion |= {key: value for key, value in nodal.items() if value}
    if fault := _fault_of(parts, numbers, motion):
        model.leave(soft[0].block, fault)
        return None
    parts.used_ties |= {tie.key for tie in ties.cards}
    parts.nodes_with_mass.update(masses["nodes"] if masses else ())
    velocity = parts.common_velocity(numbers)
    if velocity is not None:
        motion["velocity"] = velocity
    places = [f"*{m.block.keyword}, {model.place(m.block)}" for m in soft]
    notes = [m.soft.note for m in soft if m.soft is not None and m.soft.note]
    if any("filter" in table["material"] for table in tables):
        notes.append("its rates are smoothed over some steps, filter")
    if any(
        parts.is_shell(number) and material.soft is not None and not material.soft.membrane
        for number, material in zip(numbers, soft, strict=True)
    ):
        notes.append("its shells are membranes, without bending")
    if masses:
        notes.append(f"masses of {sum(masses['mass']):g} by *ELEMENT_MASS")
    source = "; ".join(dict.fromkeys([*places, *notes, *ties.sources]))
    return SoftSlave(motion, source, ties.hosts)


def _fault_of(parts: DeckParts, numbers: list[int], motion: dict[str, Any]) -> str:
    """Return why the case refuses a slave with this motion; empty if it does not.

    The slave is built from its file, without contacts, as in a run.
    """
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
        deforming_of(spec, spec.motion, slave, lambda motion_spec: Fixed(), length)
    except ValidationError as error:
        return first_error(error, table, "").what
    except ContigaError as error:
        return f"{error.what}, so the slave rests" if isinstance(error, InputError) else str(error)
    return ""


def shared_parts(
    slaves: Iterable[tuple[int, ...]], parts: DeckParts, sets: Iterable[int]
) -> set[int]:
    """Return the parts that are in several slaves, or share nodes with sets that are slaves."""
    distinct = list(dict.fromkeys(slaves))
    several = {
        part
        for k, slave in enumerate(distinct)
        for part in slave
        if any(part in earlier for earlier in distinct[:k])
    }
    names = {set_name(number) for number in sets}
    nodes = {
        int(node)
        for group in parts.mesh.groups
        if group.name in names and group.nodes is not None
        for node in group.nodes
    }
    if nodes:
        several |= {
            part
            for part, group in parts.groups.items()
            if nodes & {int(node) for node in parts.nodes_of(group)}
        }
    return several


def _ties_of(parts: DeckParts, numbers: list[int]) -> _Ties:
    """Return the ties of the nodes of some parts: rigid parts that share them, and cards.

    Cards with the same nodes and effect give one entry. A card whose nodes move with another rigid
    part already is a clash; cards that attach nodes to a part that is not rigid are skipped.
    """
    nodes = _nodes_of(parts, numbers)
    ids = parts.mesh.node_ids
    node_ids = np.zeros(len(nodes), np.int64) if ids is None else ids
    ties = _Ties([], [], [], [], [], [])
    host = np.full(len(nodes), -1)
    for part in filter(parts.is_rigid, parts.groups):
        shared = _nodes_of(parts, [part]) & nodes
        if shared.any():
            host[shared] = part
            ties.hosts.append(part)
            ties.attached.append({"set": part, "body": parts.name(part)})
            ties.sources.append(f"nodes shared with *PART {part}")
    # Cards by their nodes and their effect on these; cards that attach nodes to parts come first.
    cards_by_effect: dict[tuple[str, str, int], list[NodeTie]] = {}
    for tie in sorted(parts.model.ties, key=lambda tie: tie.part == 0):
        cards_by_effect.setdefault((tie.nodes, tie.directions, tie.part), []).append(tie)
    for (name, directions, part), all_cards in cards_by_effect.items():
        members = np.zeros(len(nodes), np.bool_)
        group = next((g for g in parts.mesh.groups if g.name == name), None)
        if group is not None and group.nodes is not None:
            members[group.nodes] = True
        members &= nodes
        ids_of_members = set(node_ids[members].tolist())
        cards = [tie for tie in all_cards if not tie.is_single or tie.number in ids_of_members]
        if not members.any() or (part and not (part in parts.groups and parts.is_rigid(part))):
            continue
        if ((host[members] >= 0) & (host[members] != (part or -1))).any():
            ties.clashes.extend(cards)
            continue
        ties.cards.extend(cards)
        place = parts.model.place(cards[0].block, cards[0].line)
        ties.sources.append(f"*{cards[0].block.keyword}, {place}")
        if part:
            host[members] = part
            ties.hosts.extend([part] * (part not in ties.hosts))
            ties.attached.append({"set": name, "body": parts.name(part)})
        else:
            ties.fixed.append({"set": name, "hold": [*directions]})
    return ties


def _nodes_of(parts: DeckParts, numbers: list[int]) -> NDArray[np.bool_]:
    """Return a mask (n,) of the nodes of the mesh that elements of some parts have."""
    mask = np.zeros(len(parts.mesh.points), np.bool_)
    for number in numbers:
        mask[parts.nodes_of(parts.groups[number])] = True
    return mask


def _material_table(parts: DeckParts, number: int, material: Material) -> dict[str, Any] | None:
    """Return `material`, `density` and, for shells, `thickness`; None if one of them is wrong.

    The reason is then noted in the model. The material is made once, as a check.
    """
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

    def with_curves(table_of: Callable[[int], Any]) -> dict[str, Any]:
        """Return the material's table with its curves; with a filter if it has several rates."""
        table = soft.table | {key: table_of(curve) for key, curve in curves.items()}
        if len(by_rate) > 1:
            table["rates"] = [
                {"rate": rate, "loading": table_of(curve)} for rate, curve in by_rate[1:]
            ]
            # Rates are smoothed over some steps of about facet size over wave speed.
            speed = (material.modulus / material.density) ** 0.5
            table["filter"] = float(f"{_FILTER_STEPS * parts.size_of_facets([number]) / speed:.3g}")
        return table

    properties: dict[str, Any] = {}
    try:
        positive(material.density, "density")
        properties["density"] = parts.density(number)
        table = with_curves(lambda curve: parts.model.curves[curve].table)
        rates = tuple((row["rate"], row["loading"]) for row in table.pop("rates", ()))
        kind = table.pop("kind")
        _MATERIALS[kind](**table, **({"rates": rates} if rates else {}))
        if parts.is_shell(number):
            properties["thickness"] = parts.thickness(number)
    except InputError as error:
        parts.model.leave(material.block, f"{error.where} {error.what}")
        return None
    return {
        "material": with_curves(lambda curve: {"file": parts.file, "curve": curve})
    } | properties
