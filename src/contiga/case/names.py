"""Checks of the names by which parts of a case call each other."""

from __future__ import annotations

from collections import Counter

from contiga.case.spec import suggest
from contiga.errors import CaseError


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
    """Refuse a slave that is called as a body is."""
    if name in others:
        raise CaseError("a body and a slave must not have the same name", where=where, found=name)


def check_defined(where: str, name: str, kind: str, defined: list[str], other: list[str]) -> None:
    """Refuse a name that is none of the `defined` ones of a `kind`; `other` are of another."""
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
