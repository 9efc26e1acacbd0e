"""Checks of the names by which parts of a case refer to each other."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from contiga.case.spec import suggest
from contiga.dynamics.springs import GROUND
from contiga.errors import CaseError

EITHER = "body or slave"
_REFERENCES = {
    "contact": {"master": "body", "slave": "slave"},
    "load": {"body": "body"},
    "spring": {"between": EITHER},
    "joint": {"between": "body"},
    "gas": {"slave": "slave"},
    "sensor": {"body": "body", "between": "body"},
}
"""Keys of tables that name a body or a slave, with the kind of part."""


def check_unique(key: str, names: list[str]) -> None:
    """Refuse a name that two tables of `key` have; the CaseError is at the last of them."""
    for name, count in Counter(names).items():
        if count > 1:
            last = len(names) - 1 - names[::-1].index(name)
            raise CaseError(
                f"the name is used {count} times",
                where=f"{key}[{last}].name",
                found=name,
                allowed="each name once",
            )


def check_apart(key: str, name: str, names: list[str], rule: str) -> None:
    """Refuse a name that is among the names of another kind of part."""
    if name in names:
        raise CaseError(rule, where=key, found=name)


def check_defined(
    key: str, name: str, kind: str, names: list[str], names_of_other_kind: list[str]
) -> None:
    """Refuse a name that is not among the names of a `kind` of part.

    The CaseError suggests the closest name, or says that the name is of the other kind.
    """
    if name in names:
        return
    remedy = suggest(name, names)
    if name in names_of_other_kind:
        remedy = f"{name!r} is a {'slave' if kind == 'body' else 'body'}"
    raise CaseError(
        f"no {kind} of this name is defined",
        where=key,
        found=name,
        allowed=_quoted(names),
        remedy=remedy,
    )


def check_fires(key: str, name: str, triggers: list[str], sensors: list[str]) -> None:
    """Refuse a trigger that is not among the sensors with a trigger."""
    if name in triggers:
        return
    is_sensor = name in sensors
    raise CaseError(
        "this sensor has no trigger" if is_sensor else "no sensor of this name is defined",
        where=key,
        found=name,
        allowed=_quoted(triggers) or "a sensor with a trigger",
        remedy="Give it trigger = { above = … }" if is_sensor else suggest(name, triggers),
    )


def _quoted(names: Sequence[str]) -> str:
    return ", ".join(f'"{name}"' for name in names)


class UnresolvedName(NamedTuple):
    """An unresolved reference: a table that names a part which does not exist."""

    key: str
    row: int
    error: CaseError


def unresolved_names(
    data: Mapping[str, Any], places: Sequence[tuple[int | str, ...]]
) -> list[UnresolvedName]:
    """Return unresolved references to bodies and slaves in a case that also has other errors.

    `places` are the places of these errors. Nothing is returned if the names of bodies and slaves
    cannot be known, because their names or whole tables are wrong.
    """
    if any(len(place) < 2 or place[-1] == "name" for place in places):
        return []
    bodies, slaves, belts = (
        [table.get("name") for table in data.get(kind) or [] if isinstance(table, Mapping)]
        for kind in ("body", "slave", "belt")
    )
    slaves += belts
    if None in bodies + slaves:
        return []
    # By kind: allowed names, and names of another kind that may be given by mistake.
    names_by_kind: dict[str, tuple[Any, Any]] = {
        "body": (bodies, slaves),
        "slave": (slaves, bodies),
        EITHER: (bodies + slaves, []),
    }
    unresolved = []
    for key, kinds in _REFERENCES.items():
        for i, table in enumerate(data.get(key) or []):
            for name, kind, place in _references_in(table, kinds, f"{key}[{i}]"):
                if name == GROUND and key in ("spring", "joint"):
                    continue
                try:
                    check_defined(place, name, kind, *names_by_kind[kind])
                except CaseError as error:
                    unresolved.append(UnresolvedName(key, i, error))
    return unresolved


def _references_in(
    table: Any, kinds: Mapping[str, str], start: str
) -> Iterator[tuple[str, str, str]]:
    """Yield the names in a table, the kind of part they name, and their keys from `start` on."""
    for key, kind in kinds.items():
        value = table.get(key) if isinstance(table, Mapping) else None
        if isinstance(value, str):
            yield value, kind, f"{start}.{key}"
        for k, name in enumerate(value if isinstance(value, list) else ()):
            if isinstance(name, str):
                yield name, kind, f"{start}.{key}[{k}]"
