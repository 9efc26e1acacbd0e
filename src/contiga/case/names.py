"""Checks of the names by which parts of a case refer to each other."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from contiga.case.spec import suggest
from contiga.dynamics.springs import GROUND
from contiga.errors import CaseError

EITHER = "body or slave"
# Keys of tables that name a body or a slave, with the kind of part.
_NAMING = {
    "contact": {"master": "body", "slave": "slave"},
    "load": {"body": "body"},
    "spring": {"between": EITHER},
    "joint": {"between": "body"},
    "gas": {"slave": "slave"},
    "sensor": {"body": "body", "between": "body"},
}


def check_unique(key: str, names: list[str]) -> None:
    """Refuse a name that two tables of `key` have."""
    for name, count in Counter(names).items():
        if count > 1:
            last = len(names) - 1 - names[::-1].index(name)
            raise CaseError(
                f"the name is used {count} times",
                where=f"{key}[{last}].name",
                found=name,
                allowed="each name once",
            )


def check_apart(where: str, name: str, others: list[str]) -> None:
    """Refuse a slave that has the name of a body."""
    if name in others:
        raise CaseError("a body and a slave must not have the same name", where=where, found=name)


def check_defined(where: str, name: str, kind: str, defined: list[str], other: list[str]) -> None:
    """Refuse a name that is not `defined` for a `kind`; `other` names are of another kind."""
    if name in defined:
        return
    remedy = suggest(name, defined)
    if name in other:
        remedy = f"{name!r} is a {'slave' if kind == 'body' else 'body'}"
    raise CaseError(
        f"no {kind} of this name is defined",
        where=where,
        found=name,
        allowed=", ".join(f'"{known}"' for known in defined),
        remedy=remedy,
    )


def check_fires(where: str, name: str, fire: list[str], sensors: list[str]) -> None:
    """Refuse a trigger that is not among the sensors that `fire`."""
    if name in fire:
        return
    there = name in sensors
    raise CaseError(
        "this sensor has no trigger" if there else "no sensor of this name is defined",
        where=where,
        found=name,
        allowed=", ".join(f'"{known}"' for known in fire) or "a sensor with a trigger",
        remedy="Give it trigger = { above = … }" if there else suggest(name, fire),
    )


class Misnamed(NamedTuple):
    """An unresolved reference: a table that names a part which does not exist."""

    key: str
    row: int
    error: CaseError


def misnamed(data: Mapping[str, Any], places: Sequence[tuple[int | str, ...]]) -> list[Misnamed]:
    """Find unresolved references to bodies and slaves in a case that also has other errors.

    `places` are the places of these errors, so that the parts there do not count against the
    others.

    None where it cannot be known: where tables or names of bodies and slaves are themselves wrong.
    """
    bodies, slaves, belts = (_names_of(data.get(kind)) for kind in ("body", "slave", "belt"))
    slaves += belts
    unknown = any(len(place) < 2 or place[-1] == "name" for place in places)
    if unknown or None in bodies + slaves:
        return []
    # Names that are allowed, and others that may be given by mistake.
    known = {"body": (bodies, slaves), "slave": (slaves, bodies), EITHER: (bodies + slaves, [])}
    faults = []
    for key, keys in _NAMING.items():
        for i, table in enumerate(data.get(key) or []):
            for name, kind, where in _names_in(table, keys, f"{key}[{i}]"):
                names, other = known[kind]
                if name == GROUND and key in ("spring", "joint"):
                    continue
                try:
                    check_defined(where, name, kind, names, other)
                except CaseError as error:
                    faults.append(Misnamed(key, i, error))
    return faults


def _names_of(tables: Any) -> list[Any]:
    """Return the names of bodies or slaves; None for one without a name."""
    return [table.get("name") for table in tables or [] if isinstance(table, Mapping)]


def _names_in(table: Any, keys: Mapping[str, str], where: str) -> Iterator[tuple[str, str, str]]:
    """Yield the names in a table, the kind of part they name, and their keys."""
    for key, kind in keys.items():
        value = table.get(key) if isinstance(table, Mapping) else None
        if isinstance(value, str):
            yield value, kind, f"{where}.{key}"
        elif isinstance(value, list):
            texts = [(k, one) for k, one in enumerate(value) if isinstance(one, str)]
            yield from ((one, kind, f"{where}.{key}[{k}]") for k, one in texts)
