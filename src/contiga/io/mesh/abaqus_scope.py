"""Nodes, elements and sets of a part, an instance or an Abaqus deck itself, by number."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from contiga.errors import MeshError
from contiga.io.mesh.abaqus_cards import Keyword, Line, reals
from contiga.io.mesh.abaqus_elements import cell_of
from contiga.io.mesh.deck_text import parse_whole
from contiga.records import FloatArray
from contiga.slaves.cells import N_NODES

Place = tuple[float, float, float]


class Label(NamedTuple):
    """A node or an element: its number and its instance."""

    instance: str
    """Instance in lower case; "" for that of the label's place."""
    number: int


class Element(NamedTuple):
    """An element in the deck."""

    kind: str
    """Its cell, "" without a surface."""
    nodes: list[int]
    """Its nodes; None for a point or line that names some by their instance."""
    where: str


@dataclass
class NamedSet:
    """Nodes or elements under a name."""

    name: str
    """Name as first written."""
    labels: dict[Label, None] = field(default_factory=dict)


Sets = dict[str, NamedSet]
"""Sets by name in lower case."""


@dataclass
class Scope:
    """Nodes, elements and sets that are numbered together."""

    nodes: dict[int, Place] = field(default_factory=dict)
    elements: dict[int, Element] = field(default_factory=dict)
    node_sets: Sets = field(default_factory=dict)
    element_sets: Sets = field(default_factory=dict)
    system: tuple[FloatArray, FloatArray] | None = None
    """Origin (3,) and axes (3, 3) as rows of the *SYSTEM in force."""

    def copy(self) -> Scope:
        """Return a copy that can be extended without changing this one."""
        sets = [
            {key: NamedSet(one.name, dict(one.labels)) for key, one in named.items()}
            for named in (self.node_sets, self.element_sets)
        ]
        return Scope(dict(self.nodes), dict(self.elements), sets[0], sets[1])

    def add_node(self, number: int, place: Place, where: str) -> None:
        """Add a node; one given twice must have the same place."""
        if self.nodes.setdefault(number, place) != place:
            raise MeshError(
                "a node is given twice, in different places",
                where=where,
                found=f"node {number}",
                allowed="each node number once",
            )

    def add_element(self, number: int, element: Element) -> None:
        """Add an element; one given twice must be equal."""
        known = self.elements.setdefault(number, element)
        if (known.kind, known.nodes) != (element.kind, element.nodes):
            raise MeshError(
                "an element is given twice",
                where=element.where,
                found=f"element {number}",
                allowed="each element number once",
            )


def put(sets: Sets, name: str, labels: Iterable[Label]) -> None:
    """Add labels to a set, which is made if it does not exist."""
    if name:
        sets.setdefault(name.casefold(), NamedSet(name)).labels.update(dict.fromkeys(labels))


def own(numbers: Iterable[int]) -> Iterator[Label]:
    """Yield the labels of numbers in this scope."""
    return (Label("", number) for number in numbers)


def read_nodes(keyword: Keyword, scope: Scope) -> None:
    """Read *NODE: number and coordinates, in its own system (SYSTEM) within that of *SYSTEM."""
    keyword.understood("NSET", "SYSTEM", "INPUT")
    kind = keyword.options.get("SYSTEM", "R").upper()[:1]
    if kind not in ("R", "C", "S"):
        raise MeshError(
            "not a system of coordinates", where=keyword.where, found=kind, allowed="R, C, S"
        )
    numbers = []
    for line in keyword.lines:
        number = parse_whole(line.fields[0], line.where)
        a, b, c = reals(line._replace(fields=line.fields[1:]), 3)
        scope.add_node(number, _cartesian(scope, kind, (a, b, c)), line.where)
        numbers.append(number)
    put(scope.node_sets, keyword.options.get("NSET", ""), own(numbers))


def _cartesian(scope: Scope, kind: str, given: Place) -> Place:
    """Return coordinates in the axes of the part; angles are in degrees."""
    a, b, c = given
    if kind != "R":
        turn = math.radians(b)
        if kind == "C":  # radius, angle about z, z
            given = (a * math.cos(turn), a * math.sin(turn), c)
        else:  # radius, angle about z, angle from the x-y plane
            rise = math.radians(c)
            flat = a * math.cos(rise)
            given = (flat * math.cos(turn), flat * math.sin(turn), a * math.sin(rise))
    if scope.system is None:
        return given
    origin, axes = scope.system
    x, y, z = (origin + np.array(given) @ axes).tolist()
    return x, y, z


def read_system(keyword: Keyword, scope: Scope) -> None:
    """Read *SYSTEM: an origin, a point on x and one in the x-y plane, for the next nodes."""
    keyword.understood()
    numbers = [number for line in keyword.lines[:2] for number in reals(line, 6)]
    if not numbers:
        scope.system = None
        return
    a, b, c = np.array((numbers + [0.0] * 12)[:9]).reshape(3, 3)
    given = [len(filled(line)) for line in keyword.lines[:2]]
    if given[0] <= 3:  # an origin alone moves
        scope.system = (a, np.eye(3))
        return
    along = b - a
    across = c - a if len(given) > 1 else np.cross([0.0, 0.0, 1.0], along)
    normal = np.cross(along, across)
    if not np.linalg.norm(normal) > 1e-12 * np.linalg.norm(along) * np.linalg.norm(across):
        raise MeshError("the three points of a system lie on a line", where=keyword.where)
    x, z = along / np.linalg.norm(along), normal / np.linalg.norm(normal)
    scope.system = (a, np.array([x, np.cross(z, x), z]))


def read_elements(keyword: Keyword, scope: Scope) -> None:
    """Read *ELEMENT: number and nodes, over as many lines as needed."""
    keyword.understood("TYPE", "ELSET", "INPUT")
    name = keyword.need("TYPE")
    kind = cell_of(name)
    if kind is None:
        raise MeshError(
            "a type of element that is not known here",
            where=keyword.where,
            found=f"TYPE={name}",
            allowed="shells, membranes, rigid and plane elements; bricks, wedges, tetrahedra and "
            "pyramids; beams, trusses, springs, masses, which have no surface",
        )
    numbers = []
    for fields, where in _records(keyword, N_NODES.get(kind, 0)):
        number = parse_whole(fields[0], where)
        # Points and lines may stand on nodes of an instance, by name.
        named = not kind and not all(text.isdigit() for text in fields[1:])
        nodes = [] if named else [parse_whole(text, where) for text in fields[1:]]
        scope.add_element(number, Element(kind, nodes, where))
        numbers.append(number)
    put(scope.element_sets, keyword.options.get("ELSET", ""), own(numbers))


def _records(keyword: Keyword, count: int) -> Iterator[tuple[list[str], str]]:
    """Yield number and `count` nodes of each element; one per line if the count is unknown."""
    lines = iter(keyword.lines)
    for line in lines:
        fields = numbered(line)
        while count and len(fields) <= count:
            more = next(lines, None)
            if more is None:
                break
            fields += filled(more)
        if count and len(fields) != count + 1:
            raise MeshError(
                f"an element of {count} nodes",
                where=line.where,
                found=f"{len(fields) - 1} numbers",
                allowed=f"its number and {count} of nodes",
            )
        yield fields, line.where


def filled(line: Line) -> list[str]:
    """Return the fields of a line without empty ones at its end."""
    fields = list(line.fields)
    while fields and not fields[-1]:
        fields.pop()
    return fields


def numbered(line: Line) -> list[str]:
    """Return the fields of a line that begins with a number.

    Raises
    ------
    MeshError
        It is left out.
    """
    fields = filled(line)
    if not fields or not fields[0]:
        raise MeshError("a line without its first number", where=line.where, found=line.fields)
    return fields


def read_ngen(keyword: Keyword, scope: Scope) -> None:
    """Read *NGEN: nodes between two, in even steps along a straight line."""
    keyword.understood("NSET")
    for line in keyword.lines:
        first, *others = (parse_whole(text, line.where) for text in numbered(line))
        last, step = (*others, 1)[:2] if others else (first, 1)
        count, rest = divmod(last - first, step) if step else (0, 1)
        if len(others) > 2 or rest or count < 1:
            raise MeshError("not two nodes and an even step", where=line.where, found=line.fields)
        a, b = (np.array(_node(scope, number, line.where)) for number in (first, last))
        numbers = range(first, last + (1 if step > 0 else -1), step)
        for k, number in enumerate(numbers):
            x, y, z = (a + (b - a) * (k / count)).tolist()
            if number not in (first, last):
                scope.add_node(number, (x, y, z), line.where)
        put(scope.node_sets, keyword.options.get("NSET", ""), own(numbers))


def read_ncopy(keyword: Keyword, scope: Scope) -> None:
    """Read *NCOPY with SHIFT: a moved copy of a set of nodes, with higher numbers."""
    keyword.understood("CHANGE NUMBER", "OLD SET", "NEW SET", "SHIFT", "MULTIPLE")
    keyword.options.setdefault("MULTIPLE", "1")
    step = parse_whole(keyword.need("CHANGE NUMBER"), keyword.where)
    many = parse_whole(keyword.options["MULTIPLE"], keyword.where)
    rows = [reals(line, 7) for line in keyword.lines]
    if "SHIFT" not in keyword.options or not rows or any(any(row) for row in rows[1:]):
        raise MeshError(
            "nodes are copied in a way that is not carried out",
            where=keyword.where,
            allowed="SHIFT by a vector, without a turn",
        )
    shift = np.array(rows[0][:3])
    old = _of_set(scope.node_sets, keyword.need("OLD SET"), keyword.where)
    for k in range(1, many + 1):
        for number in old:
            x, y, z = (np.array(_node(scope, number, keyword.where)) + k * shift).tolist()
            scope.add_node(number + k * step, (x, y, z), keyword.where)
        name = keyword.options.get("NEW SET", "")
        put(scope.node_sets, name, own(number + k * step for number in old))


def read_elgen(keyword: Keyword, scope: Scope) -> None:
    """Read *ELGEN: copies of an element along a row, of the row over a layer, of layers."""
    keyword.understood("ELSET")
    for line in keyword.lines:
        master, *rest = (parse_whole(text or "1", line.where) for text in numbered(line))
        steps = [(*rest[k : k + 3], 1, 1)[:3] for k in range(0, len(rest), 3)]
        made = {0: 0}
        for count, node_step, step in steps:
            made = {
                base + k * step: nodes + k * node_step
                for base, nodes in made.items()
                for k in range(max(count, 1))
            }
        _copy_elements(scope, [master], made, keyword.options.get("ELSET", ""), line.where)


def read_elcopy(keyword: Keyword, scope: Scope) -> None:
    """Read *ELCOPY: a copy of a set of elements on nodes of other numbers."""
    keyword.understood("OLD SET", "NEW SET", "ELEMENT SHIFT", "SHIFT NODES")
    step, nodes = (
        parse_whole(keyword.need(o), keyword.where) for o in ("ELEMENT SHIFT", "SHIFT NODES")
    )
    old = _of_set(scope.element_sets, keyword.need("OLD SET"), keyword.where)
    _copy_elements(scope, old, {step: nodes}, keyword.options.get("NEW SET", ""), keyword.where)


def _copy_elements(
    scope: Scope, masters: list[int], made: dict[int, int], name: str, where: str
) -> None:
    """Add copies of elements; `made` adds to their numbers and to those of their nodes."""
    for number in masters:
        element = scope.elements.get(number)
        if element is None:
            raise MeshError("no element of that number", where=where, found=number)
        for by, nodes in made.items():
            moved = [node + nodes for node in element.nodes]
            if by or nodes:
                scope.add_element(number + by, Element(element.kind, moved, where))
        put(scope.element_sets, name, own(number + by for by in made))


def _node(scope: Scope, number: int, where: str) -> Place:
    if number not in scope.nodes:
        raise MeshError("no node of that number", where=where, found=number)
    return scope.nodes[number]


def _of_set(sets: Sets, name: str, where: str) -> list[int]:
    """Return the numbers of a set of a part."""
    if name.casefold() not in sets:
        raise MeshError("no set of that name", where=where, found=name)
    return [label.number for label in sets[name.casefold()].labels]


def moved(keyword: Keyword, scope: Scope) -> None:
    """Place an instance: translate it by the first line, then rotate it about an axis."""
    rows = [reals(line, 7) for line in keyword.lines]
    if not rows or not scope.nodes:
        return
    points = np.array(list(scope.nodes.values())) + rows[0][:3]
    if len(rows) > 1:
        a, b = np.array(rows[1][:3]), np.array(rows[1][3:6])
        along = b - a
        if not np.linalg.norm(along) > 0.0:
            raise MeshError("the axis of a turn has no length", where=keyword.lines[1].where)
        points = a + (points - a) @ _turn(along, math.radians(rows[1][6])).T
    scope.nodes = dict(zip(scope.nodes, map(tuple, points.tolist()), strict=True))


def _turn(axis: FloatArray, angle: float) -> FloatArray:
    """Return the rotation (3, 3) about an axis through the origin (Rodrigues)."""
    x, y, z = axis / np.linalg.norm(axis)
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + math.sin(angle) * K + (1.0 - math.cos(angle)) * K @ K
