"""Abaqus input files, and those of CalculiX: nodes, elements and sets, parts placed by instances.

Keywords that make or move nodes and elements are carried out, or refused by name and line; all
others are passed over. Keywords: Abaqus Keywords Reference Guide.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator
from pathlib import Path

from contiga.errors import ContigaWarning, MeshError
from contiga.io.mesh.abaqus_cards import Keyword, Line, read_keywords
from contiga.io.mesh.abaqus_elements import moves_to_contact, touches_no_mesh
from contiga.io.mesh.abaqus_mesh import assemble_mesh, count_message
from contiga.io.mesh.abaqus_scope import (
    Label,
    Scope,
    add_to_set,
    numbered_fields,
    place_instance,
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

_READERS: dict[str, Callable[[Keyword, Scope], None]] = {
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
        A keyword that makes or moves nodes in a way that is not carried out, an unknown type of
        element, a number that is not one, an element of a node that does not exist.
    """
    deck = _Deck(path)
    for keyword in read_keywords(path):
        deck.process(keyword)
    return deck.mesh()


class _Deck:
    """The contents of a deck up to the current keyword."""

    def __init__(self, path: Path) -> None:
        self.where = str(path)
        self.parts: dict[str, Scope] = {}
        self.instances: dict[str, Scope] = {"": Scope()}
        """Instances by name in lower case; "" is the deck, or the assembly, itself."""
        self.names: dict[str, str] = {}
        """Names of the instances as they are written."""
        self._scope = self.instances[""]
        self._instance: Keyword | None = None
        self._in_step = False

    def process(self, keyword: Keyword) -> None:
        """Process a keyword."""
        name = keyword.name
        if name in ("STEP", "END STEP"):
            self._in_step = name == "STEP"
        elif name in ("NSET", "ELSET"):
            self._read_set(keyword)
        elif self._in_step or name in ("ASSEMBLY", "END ASSEMBLY"):
            return
        elif name == "PART":
            self._scope = self.parts.setdefault(keyword.require("NAME").casefold(), Scope())
        elif name == "INSTANCE":
            self._begin_instance(keyword)
        elif name in ("END PART", "END INSTANCE"):
            if name == "END INSTANCE" and self._instance is not None:
                place_instance(self._instance, self._scope)
                self._instance = None
            self._scope = self.instances[""]
        elif name in _READERS:
            _READERS[name](keyword, self._scope)
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

    def _begin_instance(self, keyword: Keyword) -> None:
        name, part = keyword.require("NAME"), keyword.options.get("PART", "")
        keyword.refuse_options_except("NAME", "PART")
        if part and part.casefold() not in self.parts:
            raise MeshError("no part of that name", where=keyword.where, found=part)
        self._scope = self.parts[part.casefold()].copy() if part else Scope()
        self._instance = keyword
        self.instances[name.casefold()] = self._scope
        self.names[name.casefold()] = name

    def _read_set(self, keyword: Keyword) -> None:
        """Read *NSET and *ELSET: numbers, ranges, other sets; sets given twice add up."""
        of_nodes = keyword.name == "NSET"
        name = keyword.require(keyword.name)
        instance = keyword.options.get("INSTANCE", "").casefold()
        if instance not in self.instances:
            raise MeshError(
                "no instance of that name", where=keyword.where, found=keyword.options["INSTANCE"]
            )
        sets = self._scope.node_sets if of_nodes else self._scope.element_sets
        add_to_set(sets, name, ())
        if of_nodes and keyword.options.get("ELSET"):
            elements = self._labels_of_set(keyword.options["ELSET"], instance, False, keyword.where)
            add_to_set(sets, name, self._nodes_of_elements(elements, keyword.where))
        for line in keyword.lines:
            if "GENERATE" not in keyword.options:
                for text in filter(None, line.fields):
                    add_to_set(sets, name, self._labels(text, instance, of_nodes, line))
                continue
            first, last, step, *_ = (*numbered_fields(line), "", "")
            start = parse_whole(first, line.where)
            end = parse_whole(last or first, line.where)
            stride = parse_whole(step or "1", line.where)
            if stride < 1:
                raise MeshError("a step must be positive", where=line.where, found=stride)
            numbers = range(start, end + 1, stride)
            add_to_set(sets, name, (Label(instance, number) for number in numbers))

    def _labels(self, text: str, instance: str, of_nodes: bool, line: Line) -> Iterator[Label]:
        """Yield the labels that a field of a set names: a number or a set, maybe of an instance."""
        prefix, dot, name = text.rpartition(".")
        if dot and prefix.casefold() in self.instances:
            instance, text = prefix.casefold(), name
        if text.lstrip("+-").isdigit():
            yield Label(instance, parse_whole(text, line.where))
        else:
            yield from self._labels_of_set(text, instance, of_nodes, line.where)

    def _labels_of_set(self, name: str, instance: str, of_nodes: bool, where: str) -> list[Label]:
        """Return the labels of an existing set, relative to the scope of a new set."""
        scope = self.instances[instance] if instance else self._scope
        sets = scope.node_sets if of_nodes else scope.element_sets
        if name.casefold() not in sets:
            raise MeshError(
                "no set of that name before this line",
                where=where,
                found=name,
                allowed=", ".join(each.name for each in sets.values()) or "no set so far",
            )
        labels = sets[name.casefold()].labels
        return [label if label.instance else Label(instance, label.number) for label in labels]

    def _nodes_of_elements(self, elements: list[Label], where: str) -> list[Label]:
        nodes: list[Label] = []
        missing: list[int] = []
        for label in elements:
            scope = self.instances[label.instance] if label.instance else self._scope
            element = scope.elements.get(label.number)
            if element is None or not element.nodes:
                missing.append(label.number)
            else:
                nodes += (Label(label.instance, node) for node in element.nodes)
        for text in count_message("elements that are not there, or whose nodes are not", missing):
            warnings.warn(f"{where}: {text}", ContigaWarning, 2)
        return nodes

    def mesh(self) -> RawMesh:
        """Return all instances in one mesh; parts without an instance stay where they are drawn."""
        if len(self.instances) == 1:
            self.instances |= self.parts
            self.names |= {name: name for name in self.parts}
        return assemble_mesh(self.instances, self.names, self.where)
