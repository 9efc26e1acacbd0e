"""Abaqus input files, and those of CalculiX: nodes, elements and sets, parts placed by instances.

What makes or moves nodes and elements is carried out or refused by name and line; what does
neither is passed over. Keywords: Abaqus Keywords Reference Guide.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator
from pathlib import Path

from contiga.errors import ContigaWarning, MeshError
from contiga.io.mesh.abaqus_cards import Keyword, Line, read_keywords
from contiga.io.mesh.abaqus_elements import moves_to_contact, touches_no_mesh
from contiga.io.mesh.abaqus_mesh import assembled, count_message
from contiga.io.mesh.abaqus_scope import (
    Label,
    Scope,
    moved,
    numbered,
    put,
    read_elcopy,
    read_elements,
    read_elgen,
    read_ncopy,
    read_ngen,
    read_nodes,
    read_system,
)
from contiga.io.mesh.deck_text import parse_whole
from contiga.io.mesh.raw import RawMesh

SUFFIXES = (".inp",)

_MAKERS: dict[str, Callable[[Keyword, Scope], None]] = {
    "NODE": read_nodes,
    "ELEMENT": read_elements,
    "SYSTEM": read_system,
    "NGEN": read_ngen,
    "NCOPY": read_ncopy,
    "ELGEN": read_elgen,
    "ELCOPY": read_elcopy,
}


def read_abaqus(path: Path) -> RawMesh:
    """Return the mesh of an input file with its included files; groups by the names of its sets.

    Raises
    ------
    FileError
        Not an input file, or an included file is missing.
    MeshError
        A keyword that makes or moves nodes in a way that is not carried out, a type of element
        that is not known, a number that is none, an element of a node that is not there.
    """
    deck = _Deck(path)
    for keyword in read_keywords(path):
        deck.take(keyword)
    return deck.mesh()


class _Deck:
    """A deck as far as it has been read."""

    def __init__(self, path: Path) -> None:
        self.where = str(path)
        self.parts: dict[str, Scope] = {}
        self.instances: dict[str, Scope] = {"": Scope()}
        """Instances by name in lower case; "" is the deck, or the assembly, itself."""
        self.names: dict[str, str] = {}
        self._scope = self.instances[""]
        self._instance: Keyword | None = None
        self._in_step = False

    def take(self, keyword: Keyword) -> None:
        """Process a keyword."""
        name = keyword.name
        structure = {
            "PART": self._part,
            "END PART": self._end_part,
            "INSTANCE": self._begin_instance,
            "END INSTANCE": self._end_instance,
        }
        if name in ("STEP", "END STEP"):
            self._in_step = name == "STEP"
        elif name in ("NSET", "ELSET"):
            self._set(keyword)
        elif self._in_step or name in ("ASSEMBLY", "END ASSEMBLY"):
            return
        elif name in structure:
            structure[name](keyword)
        elif name in _MAKERS:
            _MAKERS[name](keyword, self._scope)
        elif not touches_no_mesh(name):
            raise MeshError(
                "a keyword that is not known here, and may make or move nodes",
                where=keyword.where,
                remedy="Leave it out if it does neither; else write nodes and elements in full",
            )
        elif moves_to_contact(name, keyword.options):
            warnings.warn(
                f"{keyword.where}: nodes stay where they are; the adjustment a solver makes of "
                "them is not carried out",
                ContigaWarning,
                2,
            )

    def _part(self, keyword: Keyword) -> None:
        self._scope = self.parts.setdefault(keyword.need("NAME").casefold(), Scope())

    def _end_part(self, _: Keyword) -> None:
        self._scope = self.instances[""]

    def _begin_instance(self, keyword: Keyword) -> None:
        name, part = keyword.need("NAME"), keyword.options.get("PART", "")
        keyword.understood("NAME", "PART")
        if part and part.casefold() not in self.parts:
            raise MeshError("no part of that name", where=keyword.where, found=part)
        self._scope = self.parts[part.casefold()].copy() if part else Scope()
        self._instance = keyword
        self.instances[name.casefold()] = self._scope
        self.names[name.casefold()] = name

    def _end_instance(self, _: Keyword) -> None:
        if self._instance is not None:
            moved(self._instance, self._scope)
        self._scope, self._instance = self.instances[""], None

    def _set(self, keyword: Keyword) -> None:
        """Read *NSET and *ELSET: numbers, ranges, other sets; sets given twice add up."""
        nodes = keyword.name == "NSET"
        name = keyword.need(keyword.name)
        instance = keyword.options.get("INSTANCE", "").casefold()
        if instance not in self.instances:
            raise MeshError(
                "no instance of that name", where=keyword.where, found=keyword.options["INSTANCE"]
            )
        sets = self._scope.node_sets if nodes else self._scope.element_sets
        put(sets, name, ())
        if nodes and keyword.options.get("ELSET"):
            elements = self._labels_of_set(keyword.options["ELSET"], instance, False, keyword.where)
            put(sets, name, self._nodes_of(elements, keyword.where))
        for line in keyword.lines:
            if "GENERATE" in keyword.options:
                put(sets, name, (Label(instance, number) for number in _range(line)))
            else:
                for text in filter(None, line.fields):
                    put(sets, name, self._labels(text, instance, nodes, line))

    def _labels(self, text: str, instance: str, nodes: bool, line: Line) -> Iterator[Label]:
        """Yield the labels that a field of a set names: a number or a set, maybe of an instance."""
        front, dot, rest = text.rpartition(".")
        if dot and front.casefold() in self.instances:
            instance, text = front.casefold(), rest
        if text.lstrip("+-").isdigit():
            yield Label(instance, parse_whole(text, line.where))
        else:
            yield from self._labels_of_set(text, instance, nodes, line.where)

    def _labels_of_set(self, name: str, instance: str, nodes: bool, where: str) -> list[Label]:
        """Return the labels of an existing set, seen from the place of a new set."""
        scope = self.instances[instance] if instance else self._scope
        sets = scope.node_sets if nodes else scope.element_sets
        if name.casefold() not in sets:
            raise MeshError(
                "no set of that name before this line",
                where=where,
                found=name,
                allowed=", ".join(one.name for one in sets.values()) or "no set so far",
            )
        labels = sets[name.casefold()].labels
        return [label if label.instance else Label(instance, label.number) for label in labels]

    def _nodes_of(self, elements: list[Label], where: str) -> list[Label]:
        labels: list[Label] = []
        without: list[int] = []
        for label in elements:
            scope = self.instances[label.instance] if label.instance else self._scope
            element = scope.elements.get(label.number)
            if element is None or not element.nodes:
                without.append(label.number)
            else:
                labels += (Label(label.instance, node) for node in element.nodes)
        for text in count_message("elements that are not there, or whose nodes are not", without):
            warnings.warn(f"{where}: {text}", ContigaWarning, 2)
        return labels

    def mesh(self) -> RawMesh:
        """Return all instances in one mesh; parts without an instance stay where they are drawn."""
        if len(self.instances) == 1:
            self.instances |= self.parts
            self.names |= {name: name for name in self.parts}
        return assembled(self.instances, self.names, self.where)


def _range(line: Line) -> range:
    """Return the range of a line of GENERATE: first, last (default: first) and step."""
    first, last, step, *_ = (*numbered(line), "", "")
    begin = parse_whole(first, line.where)
    end = parse_whole(last or first, line.where)
    by = parse_whole(step or "1", line.where)
    if by < 1:
        raise MeshError("a step must be positive", where=line.where, found=by)
    return range(begin, end + 1, by)
