"""Parts and faces of a CAD file: their labels, and selection by name or number.

A part is a solid, a shell that bounds none, or connected faces. Parts and faces are numbered from 1
in the order of the file.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from operator import index
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, get_args

import numpy as np

from contiga.errors import GeometryError
from contiga.io.naming import PartKeys, as_keys, closest, listed

if TYPE_CHECKING:
    from contiga.masters.body import Body


Solids = Literal["union", "separate", "refuse"]
"""Treatment of solids of a file that touch or overlap."""


class FaceLabel(NamedTuple):
    """Label of a face in the file."""

    number: int
    """Number of the face, from 1, in the file's order."""
    kind: str
    """Type of its surface: "plane", "cylinder", "B-spline" …"""
    name: str | None = None
    colour: str | None = None
    """Colour "#rrggbb"."""


class PartLabel(NamedTuple):
    """Label of a part in the file."""

    number: int
    """Number of the part, from 1, in the file's order."""
    kind: str
    """"solid", "shell" or "faces"."""
    faces: tuple[FaceLabel, ...]
    """Its faces in the file's order."""
    name: str | None = None
    """Its own name, or that of its product."""
    place: tuple[str, ...] = ()
    """Names of its instances, from the outermost assembly in."""
    aliases: tuple[str, ...] = ()
    """Other names that select it: products of its assemblies."""
    colour: str | None = None
    """Colour "#rrggbb"."""

    @property
    def all_names(self) -> list[str]:
        """All names that select it, each once: its own, its paths shortened from the left, others.

        A path joins the names of its instances by "/".
        """
        paths = ["/".join(self.place[k:]) for k in range(len(self.place))]
        names = [] if self.name is None else [self.name]
        return list(dict.fromkeys([*names, *paths, *self.place, *self.aliases]))

    @property
    def title(self) -> str:
        """Its title: its name and place, or its number."""
        return titled(self.name, "/".join(self.place)) or f"part {self.number}"


def titled(name: str | None, place: str) -> str:
    """Return name and place of a part: "bolt (left arm/bolt 2)".

    If one of them is empty, or both are equal, it is one alone.
    """
    if name is None or place in ("", name):
        return name or place
    return f"{name} ({place})"


class Choice(NamedTuple):
    """Selected parts and single faces; both None for everything."""

    parts: tuple[str | int, ...] | None = None
    faces: tuple[int, ...] | None = None

    @property
    def is_all(self) -> bool:
        """Whether all of the file is selected."""
        return self.parts is None and self.faces is None


ALL = Choice()


def checked_solids(solids: Solids | None) -> Solids | None:
    """Return `solids` if it is None or one of `Solids`; else raise an error.

    Raises
    ------
    GeometryError
        `solids` is something else.
    """
    if solids is not None and solids not in get_args(Solids):
        allowed = ", ".join(f'"{word}"' for word in get_args(Solids))
        raise GeometryError("no such choice", where="solids", found=solids, allowed=allowed)
    return solids


def choice_of(parts: PartKeys | None, faces: int | Iterable[int] | None) -> Choice:
    """Return the selection, checked as far as possible without the file.

    Raises
    ------
    GeometryError
        An empty choice, or an entry that is neither a name nor a number from 1 on.

    >>> choice_of("box", 3)
    Choice(parts=('box',), faces=(3,))
    """
    names: tuple[str | int, ...] | None = None
    if parts is not None:
        keys = _nonempty(as_keys(parts), "parts")
        names = tuple(key if isinstance(key, str) else _number(key, "parts") for key in keys)
    if faces is None:
        return Choice(names, None)
    numbers = [faces] if isinstance(faces, int | np.integer) else list(faces)
    return Choice(names, tuple(_number(key, "faces") for key in _nonempty(numbers, "faces")))


def _nonempty(keys: list[Any], where: str) -> list[Any]:
    if not keys:
        raise GeometryError(
            "chooses nothing", where=where, found=keys, remedy=f"Leave {where} out for all there is"
        )
    return keys


def _number(key: Any, where: str) -> int:
    """Return a whole number from 1 as an int; `GeometryError` for anything else, also True.

    `where`, "parts" or "faces", determines the message.
    """
    try:
        number = index(key)
    except TypeError:
        number = 0
    if number < 1 or isinstance(key, bool):
        raise GeometryError(
            "is not a part number or name" if where == "parts" else "is not a face number",
            where=where,
            found=key,
            allowed="whole numbers from 1" + (", and names" if where == "parts" else ""),
        )
    return number


class Inventory(NamedTuple):
    """The inventory of a file as its reader returns it."""

    body: Body
    """The whole file."""
    numbers: list[int]
    """Number of the face in the file for each patch of `body`."""
    parts: list[PartLabel]
    """All parts of the file."""
    apart: dict[int, Body]
    """Parts that share faces or edges with others, or meet others, alone, by number."""
    message: str = ""
    """Message about solids that touch or overlap, "" if none do."""


def chosen_faces(parts: Sequence[PartLabel], choice: Choice, where: str) -> set[int]:
    """Return the numbers of the faces of the selected parts, and of single selected faces.

    A name selects all parts that have it, in any case if none has it exactly. Of a file without
    faces nothing is selected, whatever the choice.

    Raises
    ------
    GeometryError
        A name or a number matches nothing; the message lists the parts or faces.
    """
    numbers = {face.number for part in parts for face in part.faces}
    if choice.is_all or not numbers:
        return numbers
    selected: set[int] = set()
    for key in choice.parts or ():
        if isinstance(key, int):
            matching = [part for part in parts if part.number == key]
        else:
            name = key.strip()
            folded = name.casefold()
            matching = [part for part in parts if name in part.all_names] or [
                part for part in parts if folded in map(str.casefold, part.all_names)
            ]
        if not matching:
            names = [name for part in parts for name in part.all_names]
            allowed = listed(f"{part.number} {part.title}" for part in parts)
            if not names:
                allowed = f"1{f' to {len(parts)}' * (len(parts) > 1)} (the file names no parts)"
            raise GeometryError(
                "no part of that number" if isinstance(key, int) else "no part of that name",
                where=where,
                found=key,
                allowed=allowed,
                remedy=closest(key, names),
            )
        selected |= {face.number for part in matching for face in part.faces}
    for number in choice.faces or ():
        if number not in numbers:
            raise GeometryError(
                "no face of that number",
                where=where,
                found=number,
                allowed=f"1 to {len(numbers)}",
                remedy="contiga info FILE --faces lists them",
            )
        selected.add(number)
    return selected
