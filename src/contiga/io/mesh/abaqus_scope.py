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
from contiga.io.mesh.deck_text import Position, orthonormal_axes, parse_whole
from contiga.records import FloatArray
from contiga.slaves.cells import N_NODES


class Label(NamedTuple):
    """A node or an element: its number and its instance."""

    instance: str
    """Instance in lower case; "" for the instance where the label stands."""
    number: int


class Element(NamedTuple):
    """An element in the deck."""

    kind: str
    """Kind of its cell, "" without a surface."""
    nodes: list[int]
    """Its nodes in the scope of the element; empty for a point or line that names nodes of others.

    Such nodes are written with the name of their instance.
    """
    where: str
    """File and line."""


@dataclass
class NamedSet:
    """Nodes or elements under a name."""

    name: str
    """Name as first written."""
    labels: dict[Label, None] = field(default_factory=dict)
    """Members, each once, in the order in which they were added."""


Sets = dict[str, NamedSet]
"""Sets by name in lower case."""


@dataclass
class Scope:
    """Nodes, elements and sets that are numbered together."""

    nodes: dict[int, Position] = field(default_factory=dict)
    elements: dict[int, Element] = field(default_factory=dict)
    node_sets: Sets = field(default_factory=dict)
    element_sets: Sets = field(default_factory=dict)
    system: tuple[FloatArray, FloatArray] | None = None
    """Origin (3,) and axes (3, 3) as rows of the *SYSTEM in force."""

    def copy(self) -> Scope:
        """Return a copy that can be extended without changing this one, without its `system`."""
        sets = [
            {key: NamedSet(each.name, dict(each.labels)) for key, each in by_name.items()}
            for by_name in (self.node_sets, self.element_sets)
        ]
        return Scope(dict(self.nodes), dict(self.elements), sets[0], sets[1])

    def add_node(self, number: int, position: Position, where: str) -> None:
        """Add a node.

        Raises
        ------
        MeshError
            The number exists at another position.
        """
        if self.nodes.setdefault(number, position) != position:
            raise MeshError(
                "a node is given twice, in different places",
                where=where,
                found=f"node {number}",
                allowed="each node number once",
            )

    def add_element(self, number: int, element: Element) -> None:
        """Add an element.

        Raises
        ------
        MeshError
            The number exists with another kind of cell or other nodes.
        """
        first = self.elements.setdefault(number, element)
        if (first.kind, first.nodes) != (element.kind, element.nodes):
            raise MeshError(
                "an element is given twice",
                where=element.where,
                found=f"element {number}",
                allowed="each element number once",
            )


def add_to_set(sets: Sets, name: str, labels: Iterable[Label]) -> None:
    """Add labels to the set of a name in any case, which is made if it does not exist.

    An empty name adds nothing.
    """
    if name:
        sets.setdefault(name.casefold(), NamedSet(name)).labels.update(dict.fromkeys(labels))


def local_labels(numbers: Iterable[int]) -> Iterator[Label]:
    """Yield the labels of numbers in this scope."""
    return (Label("", number) for number in numbers)


def read_nodes(keyword: Keyword, scope: Scope) -> None:
    """Add the nodes of *NODE to a scope, and to the set that NSET names.

    Their coordinates, rectangular, cylindrical or spherical (SYSTEM = R, C, S), are those of the
    *SYSTEM in force; missing ones are 0.

    Raises
    ------
    MeshError
        Another option or system, a text that is no number, a number at two positions.
    """
    keyword.refuse_options_except("NSET", "SYSTEM", "INPUT")
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
    add_to_set(scope.node_sets, keyword.options.get("NSET", ""), local_labels(numbers))


def _cartesian(scope: Scope, kind: str, coordinates: Position) -> Position:
    """Return coordinates of a kind (R, C or S, angles in degrees) as x, y, z of the part.

    The *SYSTEM in force is applied to them.
    """
    a, b, c = coordinates
    if kind != "R":
        azimuth = math.radians(b)
        if kind == "C":  # radius, angle about z, z
            coordinates = (a * math.cos(azimuth), a * math.sin(azimuth), c)
        else:  # radius, angle about z, angle from the x-y plane
            elevation = math.radians(c)
            flat = a * math.cos(elevation)
            coordinates = (
                flat * math.cos(azimuth),
                flat * math.sin(azimuth),
                a * math.sin(elevation),
            )
    if scope.system is None:
        return coordinates
    origin, axes = scope.system
    x, y, z = (origin + np.array(coordinates) @ axes).tolist()
    return x, y, z


def read_system(keyword: Keyword, scope: Scope) -> None:
    """Set `scope.system` for the next nodes by *SYSTEM: origin, point on x, one in the x-y plane.

    A keyword without numbers ends the system in force. An origin alone translates. Without the
    third point y is horizontal, ez × x.

    Raises
    ------
    MeshError
        Any option, a text that is no number, points on one line.
    """
    keyword.refuse_options_except()
    numbers = [number for line in keyword.lines[:2] for number in reals(line, 6)]
    if not numbers:
        scope.system = None
        return
    a, b, c = np.array((numbers + [0.0] * 12)[:9]).reshape(3, 3)
    n_fields = [len(trimmed_fields(line)) for line in keyword.lines[:2]]
    if n_fields[0] <= 3:  # an origin alone translates
        scope.system = (a, np.eye(3))
        return
    in_plane = c - a if len(n_fields) > 1 else np.cross([0.0, 0.0, 1.0], b - a)
    scope.system = (a, np.array(orthonormal_axes(b - a, in_plane, keyword.where)))


def read_elements(keyword: Keyword, scope: Scope) -> None:
    """Add the elements of *ELEMENT to a scope, and to the set that ELSET names.

    Elements without a surface (beams, springs, masses) are stored too, for sets of their nodes.

    Raises
    ------
    MeshError
        Another option, an unknown type, too few or too many nodes, a text that is no number, a
        number with two different elements.
    """
    keyword.refuse_options_except("TYPE", "ELSET", "INPUT")
    name = keyword.require("TYPE")
    kind = cell_of(name)
    if kind is None:
        raise MeshError(
            "a type of element that is not known here",
            where=keyword.where,
            found=f"TYPE={name}",
            allowed="shells, membranes, rigid and plane elements; bricks, wedges, tetrahedra and "
            "pyramids; beams, trusses, springs, masses, which have no surface",
        )
    count = N_NODES.get(kind, 0)
    numbers = []
    lines = iter(keyword.lines)
    for line in lines:
        fields = numbered_fields(line)
        # An element without a surface has any number of nodes, on one line.
        while count and len(fields) <= count:
            more = next(lines, None)
            if more is None:
                break
            fields += trimmed_fields(more)
        if count and len(fields) != count + 1:
            raise MeshError(
                f"an element of {count} nodes",
                where=line.where,
                found=f"{len(fields) - 1} numbers",
                allowed=f"its number and {count} of nodes",
            )
        number = parse_whole(fields[0], line.where)
        # Points and lines may have nodes of an instance, by name.
        by_name = not kind and not all(text.isdigit() for text in fields[1:])
        nodes = [] if by_name else [parse_whole(text, line.where) for text in fields[1:]]
        scope.add_element(number, Element(kind, nodes, line.where))
        numbers.append(number)
    add_to_set(scope.element_sets, keyword.options.get("ELSET", ""), local_labels(numbers))


def trimmed_fields(line: Line) -> list[str]:
    """Return the fields of a line without empty ones at its end."""
    fields = list(line.fields)
    while fields and not fields[-1]:
        fields.pop()
    return fields


def numbered_fields(line: Line) -> list[str]:
    """Return the fields of a line without empty ones at its end; the first holds the number.

    Raises
    ------
    MeshError
        The first field is blank; whether it is a number is not checked.
    """
    fields = trimmed_fields(line)
    if not fields or not fields[0]:
        raise MeshError("a line without its first number", where=line.where, found=line.fields)
    return fields


def read_ngen(keyword: Keyword, scope: Scope) -> None:
    """Add the nodes of *NGEN: between two existing ones, evenly spaced on a straight line.

    A line has first, last, and the step of the numbers, 1 if omitted. NSET gets the two ends too.

    Raises
    ------
    MeshError
        Another option or field, a step that does not lead from the first number to the last, a
        missing end, a number that exists at another position.
    """
    keyword.refuse_options_except("NSET")
    for line in keyword.lines:
        first, *options = (parse_whole(text, line.where) for text in numbered_fields(line))
        last, step = (*options, 1)[:2] if options else (first, 1)
        count, remainder = divmod(last - first, step) if step else (0, 1)
        if len(options) > 2 or remainder or count < 1:
            raise MeshError("not two nodes and an even step", where=line.where, found=line.fields)
        a, b = (np.array(_node(scope, number, line.where)) for number in (first, last))
        numbers = range(first, last + (1 if step > 0 else -1), step)
        for k, number in enumerate(numbers):
            x, y, z = (a + (b - a) * (k / count)).tolist()
            if number not in (first, last):
                scope.add_node(number, (x, y, z), line.where)
        add_to_set(scope.node_sets, keyword.options.get("NSET", ""), local_labels(numbers))


def read_ncopy(keyword: Keyword, scope: Scope) -> None:
    """Add the nodes of *NCOPY with SHIFT: MULTIPLE copies of OLD SET, each moved by the vector.

    Copy k has numbers higher by k · CHANGE NUMBER and is moved by k times the vector; all copies
    go to NEW SET.

    Raises
    ------
    MeshError
        Another option, a rotation, a missing set or option, a number that exists at another
        position.
    """
    keyword.refuse_options_except("CHANGE NUMBER", "OLD SET", "NEW SET", "SHIFT", "MULTIPLE")
    step = parse_whole(keyword.require("CHANGE NUMBER"), keyword.where)
    n_copies = parse_whole(keyword.options.get("MULTIPLE", "1"), keyword.where)
    rows = [reals(line, 7) for line in keyword.lines]
    if "SHIFT" not in keyword.options or not rows or any(any(row) for row in rows[1:]):
        raise MeshError(
            "nodes are copied in a way that is not carried out",
            where=keyword.where,
            allowed="SHIFT by a vector, without a turn",
        )
    shift = np.array(rows[0][:3])
    originals = _numbers_of_set(scope.node_sets, keyword.require("OLD SET"), keyword.where)
    for k in range(1, n_copies + 1):
        for number in originals:
            x, y, z = (np.array(_node(scope, number, keyword.where)) + k * shift).tolist()
            scope.add_node(number + k * step, (x, y, z), keyword.where)
        name = keyword.options.get("NEW SET", "")
        add_to_set(scope.node_sets, name, local_labels(number + k * step for number in originals))


def read_elgen(keyword: Keyword, scope: Scope) -> None:
    """Add the elements of *ELGEN: copies of one in a row, of the row in a layer, of the layers.

    A line has the element, then up to three of (count, step of nodes, step of elements), 1 if
    omitted; the count includes the original. ELSET gets the original too.

    Raises
    ------
    MeshError
        Another option, a missing element, a number that exists with another element.
    """
    keyword.refuse_options_except("ELSET")
    for line in keyword.lines:
        master, *options = (parse_whole(text or "1", line.where) for text in numbered_fields(line))
        steps = [(*options[k : k + 3], 1, 1)[:3] for k in range(0, len(options), 3)]
        shifts = {0: 0}
        for count, node_step, step in steps:
            shifts = {
                shift + k * step: node_shift + k * node_step
                for shift, node_shift in shifts.items()
                for k in range(max(count, 1))
            }
        _copy_elements(scope, [master], shifts, keyword.options.get("ELSET", ""), line.where)


def read_elcopy(keyword: Keyword, scope: Scope) -> None:
    """Add the elements of *ELCOPY: a copy of OLD SET with shifted numbers, on shifted nodes.

    The copies go to NEW SET.

    Raises
    ------
    MeshError
        Another option, a missing set, element or option, a number that exists with another
        element.
    """
    keyword.refuse_options_except("OLD SET", "NEW SET", "ELEMENT SHIFT", "SHIFT NODES")
    shift, node_shift = (
        parse_whole(keyword.require(option), keyword.where)
        for option in ("ELEMENT SHIFT", "SHIFT NODES")
    )
    originals = _numbers_of_set(scope.element_sets, keyword.require("OLD SET"), keyword.where)
    new_set = keyword.options.get("NEW SET", "")
    _copy_elements(scope, originals, {shift: node_shift}, new_set, keyword.where)


def _copy_elements(
    scope: Scope, masters: list[int], shifts: dict[int, int], name: str, where: str
) -> None:
    """Add a copy of each of `masters` for each shift of its number, on shifted nodes.

    `shifts` has the shift of the node numbers by that of the element numbers; (0, 0) stands for
    the original, which only joins the set `name`. A missing master is a `MeshError`.
    """
    for number in masters:
        element = scope.elements.get(number)
        if element is None:
            raise MeshError("no element of that number", where=where, found=number)
        for shift, node_shift in shifts.items():
            if shift or node_shift:
                nodes = [node + node_shift for node in element.nodes]
                scope.add_element(number + shift, Element(element.kind, nodes, where))
        add_to_set(scope.element_sets, name, local_labels(number + shift for shift in shifts))


def _node(scope: Scope, number: int, where: str) -> Position:
    if number not in scope.nodes:
        raise MeshError("no node of that number", where=where, found=number)
    return scope.nodes[number]


def _numbers_of_set(sets: Sets, name: str, where: str) -> list[int]:
    """Return the numbers of a set, without their instances; a missing set is a `MeshError`."""
    if name.casefold() not in sets:
        raise MeshError("no set of that name", where=where, found=name)
    return [label.number for label in sets[name.casefold()].labels]


def place_instance(keyword: Keyword, scope: Scope) -> None:
    """Move the nodes of an instance by its data lines: a translation, then a rotation.

    The second line has two points of the axis and an angle in degrees. Without lines nothing moves.

    Raises
    ------
    MeshError
        A text is no number, or the two points of the axis coincide.
    """
    rows = [reals(line, 7) for line in keyword.lines]
    if not rows or not scope.nodes:
        return
    points = np.array(list(scope.nodes.values())) + rows[0][:3]
    if len(rows) > 1:
        a, b = np.array(rows[1][:3]), np.array(rows[1][3:6])
        axis = b - a
        if not np.linalg.norm(axis) > 0.0:
            raise MeshError("the axis of a turn has no length", where=keyword.lines[1].where)
        x, y, z = axis / np.linalg.norm(axis)
        angle = math.radians(rows[1][6])
        K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        rotation = np.eye(3) + math.sin(angle) * K + (1.0 - math.cos(angle)) * K @ K  # Rodrigues
        points = a + (points - a) @ rotation.T
    scope.nodes = dict(zip(scope.nodes, map(tuple, points.tolist()), strict=True))
