"""Order in which the bodies and slaves of a case are placed relative to each other."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Protocol

from contiga.case.placed_spec import Placed
from contiga.case.points_spec import BodyPoints
from contiga.errors import CaseError


class PlacedPart(Protocol):
    """A body or a slave of a case."""

    @property
    def source(self) -> Placed:
        """Table of its shape, which places it."""

    @property
    def source_key(self) -> str:
        """The key of the table `source` in the case file."""


def references(part: PlacedPart) -> Iterator[tuple[str, str]]:
    """Yield the keys of a body or slave that name parts it is placed by, and the names."""
    key, source = part.source_key, part.source
    if isinstance(source, BodyPoints):
        yield f"{key}.body", source.body
    if source.align is not None and source.align.to is not None:
        yield f"{key}.align.to", source.align.to
    if source.place is not None:
        yield f"{key}.place.on", source.place.on


def order_of(parts: Mapping[str, PlacedPart]) -> list[str]:
    """Return the names so that each follows the parts it is placed by; else in file order.

    Raises
    ------
    CaseError
        Parts are placed by one another in a circle; the message names it.
    """
    order: list[str] = []

    def visit(name: str, path: tuple[str, ...]) -> None:
        if name in path:
            circle = " by ".join([*path[path.index(name) :], name])
            raise CaseError(
                "bodies and slaves are placed by one another in a circle",
                found=circle,
                allowed="one of them that stands by itself",
            )
        if name not in order:
            for _, reference in references(parts[name]):
                visit(reference, (*path, name))
            order.append(name)

    for name in parts:
        visit(name, ())
    return order
