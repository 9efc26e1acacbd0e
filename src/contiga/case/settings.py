"""Settings that override a case file: ``body.head.motion.velocity = [0, 0, -5]``."""

from __future__ import annotations

import copy
import re
import tomllib
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from contiga.case.spec import suggest
from contiga.errors import CaseError

_KEY = re.compile(r"[^.\[\]]+(\[\d+\])*(\.[^.\[\]]+(\[\d+\])*)*")
_STEP = re.compile(r"\[(\d+)\]|([^.\[\]]+)")
# Shells remove quotes: a word or file name is text without them, unless it is a number.
_WORD = re.compile(r"(?!(?:true|false|[-+]?(?:inf|nan))$)[A-Za-z_./~][\w./\\:~* -]*")
_EXAMPLE = "body.head.motion.velocity=[0, 0, -5], contact[0].law.damping=0.2"


def parse_settings(texts: Iterable[str]) -> dict[str, Any]:
    """Return settings by key from texts ``key=value``, whose values are written as in TOML.

    A word that is no value of TOML is text: ``time.step=auto``.

    Raises
    ------
    CaseError
        A text has no ``=``, or its value is no TOML; a key is given twice.

    >>> parse_settings(["time.end=20", "contact[0].law.elastic.0=[0, 0]", "title=drop"])
    {'time.end': 20, 'contact[0].law.elastic.0': [0, 0], 'title': 'drop'}
    """
    settings: dict[str, Any] = {}
    for text in texts:
        key, equals, value = (part.strip() for part in text.partition("="))
        where = f"--set {key}"
        if not equals or not key:
            raise CaseError("must be KEY=VALUE", where="--set", found=text, allowed=_EXAMPLE)
        if key in settings:
            raise CaseError("is set twice", where=where, found=value)
        try:
            data = tomllib.loads(f"value = {value}")
        except ValueError as error:
            if not _WORD.fullmatch(value):
                raise CaseError(
                    "is not a value of TOML",
                    where=where,
                    found=value,
                    allowed='such as 0.5, true, [0, 0, -5], "text" or { kind = "fixed" }',
                ) from error
            data = {"value": value}
        if len(data) > 1:
            raise CaseError("expected a single value", where=where, found=value)
        settings[key] = data["value"]
    return settings


def with_settings(data: Mapping[str, Any], settings: Mapping[str, Any]) -> dict[str, Any]:
    """Return the tables of a case with `settings` in place of its values; `data` is not changed.

    A key goes from table to table by dots: into a list by a place, ``contact[0]`` or
    ``contact.0``, or into one of named tables by a name, ``body.head``. The last key may be new;
    so may be tables on the way.

    Raises
    ------
    CaseError
        A key leads nowhere: there is no such place or name, or a value on the way is no table.
    """
    changed = copy.deepcopy(dict(data))
    for key, value in settings.items():
        if not isinstance(key, str) or not _KEY.fullmatch(key):
            raise CaseError("is not a key of a case", where="set", found=key, allowed=_EXAMPLE)
        *path, last = [place or name for place, name in _STEP.findall(key)]
        table: Any = changed
        for i, step in enumerate(path):
            entry = _entry(table, step, key, path[:i])
            if isinstance(table, dict):
                table.setdefault(entry, {})
            table = table[entry]
        table[_entry(table, last, key, path)] = plain(value)
    return changed


def table_of_key(data: Mapping[str, Any], key: str) -> Mapping[str, Any]:
    """Return the innermost table around the value of a key, below the case itself; empty without.

    It is empty, too, if a step before the last leads nowhere; the last step is not checked.
    """
    *path, _ = [place or name for place, name in _STEP.findall(key)]
    value: Any = data
    table: Mapping[str, Any] = {}
    for i, step in enumerate(path):
        try:
            value = value[_entry(value, step, key, path[:i])]
        except (CaseError, KeyError):
            return {}
        table = value if isinstance(value, Mapping) else table
    return table


def _entry(value: Any, step: str, key: str, path: list[str]) -> Any:
    """Return the key or index to which the step after `path` leads in a table or a list.

    In a list a name precedes a place. Keys of tables need not exist.

    Raises
    ------
    CaseError
        The value is neither, or the list has no such name or place.
    """
    if isinstance(value, dict):
        return step
    place = ".".join(path)
    if not isinstance(value, list):
        raise CaseError(
            "leads into something that is not a table", where=f"set {key}: {place}", found=value
        )
    labels = [_name(table) for table in value]
    if step in labels:
        return labels.index(step)
    if step.isdecimal() and int(step) < len(value):
        return int(step)
    names = [name for name in labels if name]
    places = f"{place}[0]" + (f" to {place}[{len(value) - 1}]" if len(value) > 1 else "")
    raise CaseError(
        f"there is no such entry of {place}",
        where=f"set {key}",
        found=step,
        allowed=", ".join([*names, *([places] if value else [])]) or "none: the list is empty",
        remedy=suggest(step, names),
    )


def _name(table: Any) -> str | None:
    """Return the name of a table: its `name`, else "<master>-<slave>", its prefix, or its ends.

    None if it has none of these.
    """
    if not isinstance(table, dict):
        return None
    if isinstance(table.get("name"), str):
        return str(table["name"])
    if "master" in table and "slave" in table:
        return f"{table['master']}-{table['slave']}"
    if isinstance(table.get("prefix"), str):
        return table["prefix"].strip(" _-") or None
    between = table.get("between")
    return "-".join(map(str, between)) if isinstance(between, list) else None


def plain(value: Any) -> Any:
    """Return numbers, lists and tables as a case file has them, arrays included."""
    if isinstance(value, dict):
        return {key: plain(entry) for key, entry in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    if isinstance(value, tuple | list):
        return [plain(entry) for entry in value]
    return value
