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
    """Return the mesh of an input file and of the files that it includes, with a group a set.

    If there are several instances, each is a group too, and the names of its sets begin with its
    name. Parts of a file without instances count as instances. Elements without a surface (beams,
    springs, masses) are left out; of a step only sets are read.

    Raises
    ------
    FileError
        Not an input file, or an included file is missing or includes itself.
    MeshError
        An unknown keyword, one that makes or moves nodes in a way that is not read, an unknown type
        of element, a number that is not one, an element of a node that does not exist, a part,
        instance or set that is not defined before its use, a number given twice with different
        contents.

    Warns
    -----
    ContigaWarning
        A set names members that do not exist, which are left out; a solver would move nodes onto a
        surface, and here they stay.
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
        """Parts by name in lower case."""
        self.instances: dict[str, Scope] = {"": Scope()}
        """Instances by name in lower case; "" is the deck, or the assembly, itself."""
        self.names: dict[str, str] = {}
        """Names of the instances as they are written."""
        self._scope = self.instances[""]
        self._instance: Keyword | None = None
        self._in_step = False

    def process(self, keyword: Keyword) -> None:
        """Carry out a keyword on the current scope: the deck itself, or the open part or instance.

        Within a step only sets are read. Keywords that neither make nor move nodes and elements
        have no effect.

        Raises
        ------
        MeshError
            An unknown keyword, which may make or move nodes; errors in data lines and options.

        Warns
        -----
        ContigaWarning
            By this keyword a solver would move nodes onto the surface they face.
        """
        match keyword.name:
            case "STEP" | "END STEP":
                self._in_step = keyword.name == "STEP"
            case "NSET" | "ELSET":
                self._read_set(keyword)
            case "ASSEMBLY" | "END ASSEMBLY":
                pass
            case _ if self._in_step:
                pass
            case "PART":
                self._scope = self.parts.setdefault(keyword.require("NAME").casefold(), Scope())
            case "INSTANCE":
                name, part = keyword.require("NAME"), keyword.options.get("PART", "")
                keyword.refuse_options_except("NAME", "PART")
                if part and part.casefold() not in self.parts:
                    raise MeshError("no part of that name", where=keyword.where, found=part)
                self._scope = self.parts[part.casefold()].copy() if part else Scope()
                self._instance = keyword
                self.instances[name.casefold()] = self._scope
                self.names[name.casefold()] = name
            case "END PART" | "END INSTANCE":
                if keyword.name == "END INSTANCE" and self._instance is not None:
                    place_instance(self._instance, self._scope)
                    self._instance = None
                self._scope = self.instances[""]
            case name if name in _READERS:
                _READERS[name](keyword, self._scope)
            case name if not touches_no_mesh(name):
                raise MeshError(
                    "a keyword that is not known here, and may make or move nodes",
                    where=keyword.where,
                    remedy="Leave it out if it does neither; else write nodes and elements in full",
                )
            case name if moves_to_contact(name, keyword.options):
                warnings.warn(
                    f"{keyword.where}: nodes stay where they are; the adjustment a solver makes of "
                    "them is not carried out",
                    ContigaWarning,
                    2,
                )

    def _read_set(self, keyword: Keyword) -> None:
        """Add the members of *NSET or *ELSET to a set of the current scope, new or existing.

        Members are numbers, ranges (GENERATE), other sets, and the nodes of a set of elements
        (*NSET, ELSET = …). Elements that are missing or have no nodes here give a warning.

        Raises
        ------
        MeshError
            A missing instance, a set that does not stand before, a text that is no number.
        """
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
            nodes: list[Label] = []
            missing: list[int] = []
            set_name = keyword.options["ELSET"]
            for label in self._labels_of_set(set_name, instance, False, keyword.where):
                scope = self.instances[label.instance] if label.instance else self._scope
                element = scope.elements.get(label.number)
                if element is None or not element.nodes:
                    missing.append(label.number)
                else:
                    nodes += (Label(label.instance, node) for node in element.nodes)
            label_of_missing = "elements that are not there, or whose nodes are not"
            for text in count_message(label_of_missing, missing):
                warnings.warn(f"{keyword.where}: {text}", ContigaWarning, 2)
            add_to_set(sets, name, nodes)
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
        """Yield the labels that a field names: a number, or the members of a set before this line.

        "name.…" with the name of an instance refers to that one in place of `instance`. A set that
        is not there is a `MeshError`, a number that is not one is not noticed here.
        """
        prefix, dot, name = text.rpartition(".")
        if dot and prefix.casefold() in self.instances:
            instance, text = prefix.casefold(), name
        if text.lstrip("+-").isdigit():
            yield Label(instance, parse_whole(text, line.where))
        else:
            yield from self._labels_of_set(text, instance, of_nodes, line.where)

    def _labels_of_set(self, name: str, instance: str, of_nodes: bool, where: str) -> list[Label]:
        """Return the members of a set of an instance, or of the current scope if that is "".

        It is a set of nodes if `of_nodes`, else of elements. Members without an instance of their
        own get `instance`.

        Raises
        ------
        MeshError
            There is no such set so far; the message lists those that are there.
        """
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

    def mesh(self) -> RawMesh:
        """Return the deck and its instances in one mesh.

        In a deck without instances all parts are in the mesh, where they are drawn; in any other
        one a part without an instance is not. Errors and warnings are those of `assemble_mesh`.
        """
        if len(self.instances) == 1:
            self.instances |= self.parts
            self.names |= {name: name for name in self.parts}
        return assemble_mesh(self.instances, self.names, self.where)
