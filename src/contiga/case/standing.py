"""Order in which the bodies and slaves of a case are placed relative to each other."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from contiga.case.points_spec import BodyPoints
from contiga.case.spec import Spec
from contiga.errors import CaseError


def references(part: Spec) -> Iterator[tuple[str, str]]:
    """Yield the keys of a body or slave that name parts it is placed by, and the names."""
    key = "geometry" if getattr(part, "points", None) is None else "points"
    placed = getattr(part, key)
    if isinstance(placed, BodyPoints):
        yield f"{key}.body", placed.body
    if placed.align is not None and placed.align.to is not None:
        yield f"{key}.align.to", placed.align.to
    if placed.place is not None:
        yield f"{key}.place.on", placed.place.on


def order_of(parts: Mapping[str, Spec]) -> list[str]:
    """Return the names, each after those it is placed by, otherwise in the order of the file.

    Raises
    ------
    CaseError
        Parts are placed by one another in a circle; the message names it.
    """
    order: list[str] = []

    def visit(name: str, way: tuple[str, ...]) -> None:
        if name in way:
            circle = " by ".join([*way[way.index(name) :], name])
            raise CaseError(
                "bodies and slaves are placed by one another in a circle",
                found=circle,
                allowed="one of them that stands by itself",
            )
        if name not in order:
            for _, other in references(parts[name]):
                visit(other, (*way, name))
            order.append(name)

    for name in parts:
        visit(name, ())
    return order
