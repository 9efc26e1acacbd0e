"""Parts and faces of a CAD file: what they are called, and choosing some by name or number.

A part is a solid, a shell that bounds none, or faces that hang together. Parts and faces are
numbered from 1 in the order of the file.
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
"""What becomes of solids of a file that touch or overlap."""


class FaceLabel(NamedTuple):
    """What a file says of a face."""

    number: int
    """From 1, in the file's order."""
    kind: str
    """Its surface: "plane", "cylinder", "B-spline" …"""
    name: str | None = None
    colour: str | None = None
    """"#rrggbb"."""


class PartLabel(NamedTuple):
    """What a file says of a part."""

    number: int
    """From 1, in the file's order."""
    kind: str
    """"solid", "shell" or "faces"."""
    faces: tuple[FaceLabel, ...]
    """In the file's order."""
    name: str | None = None
    """Its own name, or that of its product."""
    place: tuple[str, ...] = ()
    """Names of the instances on the way to it, from the outermost assembly in."""
    others: tuple[str, ...] = ()
    """What it answers to besides: products of the assemblies it stands in."""
    colour: str | None = None
    """"#rrggbb"."""

    @property
    def answers(self) -> list[str]:
        """All names that choose it; the way to it may be cut short from the left."""
        ways = ["/".join(self.place[k:]) for k in range(len(self.place))]
        names = [] if self.name is None else [self.name]
        return list(dict.fromkeys([*names, *ways, *self.place, *self.others]))

    @property
    def title(self) -> str:
        """What to call it: its name and where it stands, or its number."""
        return titled(self.name, "/".join(self.place)) or f"part {self.number}"


def titled(name: str | None, place: str) -> str:
    """A part by its name and where it stands: "bolt (left arm/bolt 2)"."""
    if name is None or place in ("", name):
        return name or place
    return f"{name} ({place})"


class Choice(NamedTuple):
    """Parts and single faces that are wanted; both None for all there is."""

    parts: tuple[str | int, ...] | None = None
    faces: tuple[int, ...] | None = None

    @property
    def everything(self) -> bool:
        """Whether all of the file is wanted."""
        return self.parts is None and self.faces is None


ALL = Choice()


def checked_solids(solids: Solids | None) -> Solids | None:
    """`solids`, if it is None or one of `Solids`.

    Raises
    ------
    GeometryError
        As said.
    """
    if solids is not None and solids not in get_args(Solids):
        allowed = ", ".join(f'"{word}"' for word in get_args(Solids))
        raise GeometryError("no such choice", where="solids", found=solids, allowed=allowed)
    return solids


def choice_of(parts: PartKeys | None, faces: int | Iterable[int] | None) -> Choice:
    """What is asked for, checked as far as it can be without the file.

    Raises
    ------
    GeometryError
        Nothing, or something that is neither a name nor a number.

    >>> choice_of("box", 3)
    Choice(parts=('box',), faces=(3,))
    """
    names = None if parts is None else tuple(_key(key) for key in _some(as_keys(parts), "parts"))
    if faces is None:
        return Choice(names, None)
    numbers = _some([faces] if isinstance(faces, int | np.integer) else list(faces), "faces")
    return Choice(names, tuple(_number(number, "faces") for number in numbers))


def _some(keys: list[Any], what: str) -> list[Any]:
    if not keys:
        raise GeometryError(
            "chooses nothing", where=what, found=keys, remedy=f"Leave {what} out for all there is"
        )
    return keys


def _key(key: Any) -> str | int:
    return key if isinstance(key, str) else _number(key, "parts")


def _number(number: Any, what: str) -> int:
    try:
        whole = index(number)
    except TypeError:
        whole = 0
    if whole < 1 or isinstance(number, bool):
        raise GeometryError(
            "is not a part number or name" if what == "parts" else "is not a face number",
            where=what,
            found=number,
            allowed="whole numbers from 1" + (", and names" if what == "parts" else ""),
        )
    return whole


class Inventory(NamedTuple):
    """What a reader hands back of a file that is to be listed."""

    body: Body
    """All of it."""
    numbers: list[int]
    """Which face of the file each patch of `body` is."""
    parts: list[PartLabel]
    apart: dict[int, Body]
    """By number the parts that share faces or edges with others, as they are alone."""
    said: str = ""
    """Of solids that touch or overlap, "" if none do."""


def chosen_faces(parts: Sequence[PartLabel], choice: Choice, where: str) -> set[int]:
    """Numbers of the faces of the parts chosen, and of the faces chosen beside them.

    Raises
    ------
    GeometryError
        A name or a number that fits nothing; the message lists what there is.
    """
    known = {face.number for part in parts for face in part.faces}
    if choice.everything or not known:
        return known
    wanted = {face.number for key in choice.parts or () for face in _faces_of(parts, key, where)}
    for number in choice.faces or ():
        if number not in known:
            raise GeometryError(
                "no face of that number",
                where=where,
                found=number,
                allowed=f"1 to {len(known)}",
                remedy="contiga info FILE --faces lists them",
            )
        wanted.add(number)
    return wanted


def _faces_of(parts: Sequence[PartLabel], key: str | int, where: str) -> list[FaceLabel]:
    matching = [part for part in parts if _fits(part, key)]
    if not matching and isinstance(key, str):
        folded = key.strip().casefold()
        matching = [part for part in parts if folded in map(str.casefold, part.answers)]
    if not matching:
        raise GeometryError(
            "no part of that number" if isinstance(key, int) else "no part of that name",
            where=where,
            found=key,
            allowed=listed(_labels(parts)),
            remedy=closest(key, [name for part in parts for name in part.answers]),
        )
    return [face for part in matching for face in part.faces]


def _fits(part: PartLabel, key: str | int) -> bool:
    return part.number == key if isinstance(key, int) else key.strip() in part.answers


def _labels(parts: Sequence[PartLabel]) -> list[str]:
    unnamed = all(not part.answers for part in parts)
    if unnamed:
        numbers = "1" if len(parts) == 1 else f"1 to {len(parts)}"
        return [f"{numbers} (the file names no parts)"]
    return [f"{part.number} {part.title}" for part in parts]
