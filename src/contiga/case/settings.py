"""Settings that stand over those of a case file: ``body.head.motion.velocity = [0, 0, -5]``."""

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
# Shells take quotes away: a word or the name of a file is text without them, as is no number.
_WORD = re.compile(r"(?!(?:true|false|[-+]?(?:inf|nan))$)[A-Za-z_./~][\w./\\:~* -]*")
_EXAMPLE = "body.head.motion.velocity=[0, 0, -5], contact[0].law.damping=0.2"


def parse_settings(given: Iterable[str]) -> dict[str, Any]:
    """Settings by key from texts ``key=value``, the values written as in TOML.

    A word that is no value of TOML is text: ``time.step=auto``.

    Raises
    ------
    CaseError
        A text has no ``=``, or its value is no TOML; a key is given twice.

    >>> parse_settings(["time.end=20", "contact[0].law.elastic.0=[0, 0]", "title=drop"])
    {'time.end': 20, 'contact[0].law.elastic.0': [0, 0], 'title': 'drop'}
    """
    settings: dict[str, Any] = {}
    for text in given:
        key, equals, value = (part.strip() for part in text.partition("="))
        if not equals or not key:
            raise CaseError("must be KEY=VALUE", where="--set", found=text, allowed=_EXAMPLE)
        if key in settings:
            raise CaseError("is set twice", where=f"--set {key}", found=value)
        settings[key] = _value(key, value)
    return settings


def _value(key: str, text: str) -> Any:
    try:
        data = tomllib.loads(f"value = {text}")
    except ValueError as error:
        if _WORD.fullmatch(text):
            return text
        raise CaseError(
            "is not a value of TOML",
            where=f"--set {key}",
            found=text,
            allowed='such as 0.5, true, [0, 0, -5], "text" or { kind = "fixed" }',
        ) from error
    if len(data) > 1:
        raise CaseError("expected a single value", where=f"--set {key}", found=text)
    return data["value"]


def with_settings(data: Mapping[str, Any], settings: Mapping[str, Any]) -> dict[str, Any]:
    """The tables of a case with `settings` in place of what they say; `data` stays as it is.

    A key goes from table to table by dots: into a list by a place, ``contact[0]`` or
    ``contact.0``, or into one of named tables by a name, ``body.head``. The last key may be new;
    so may be tables on the way.

    Raises
    ------
    CaseError
        A key leads nowhere: a place or a name that is not there, or into what is no table.
    """
    changed = copy.deepcopy(dict(data))
    for key, value in settings.items():
        if not isinstance(key, str) or not _KEY.fullmatch(key):
            raise CaseError("is not a key of a case", where="set", found=key, allowed=_EXAMPLE)
        *way, last = [place or name for place, name in _STEP.findall(key)]
        here: Any = changed
        for i, step in enumerate(way):
            inner = _entry(here, step, key, way[:i])
            if isinstance(here, dict):
                here.setdefault(inner, {})
            here = here[inner]
        here[_entry(here, last, key, way)] = plain(value)
    return changed


def table_of_key(data: Mapping[str, Any], key: str) -> Mapping[str, Any]:
    """The innermost named table of a case that a key leads into; empty where it leads into none."""
    *way, _ = [place or name for place, name in _STEP.findall(key)]
    here: Any = data
    inner: Mapping[str, Any] = {}
    for i, step in enumerate(way):
        try:
            here = here[_entry(here, step, key, way[:i])]
        except (CaseError, KeyError):
            return {}
        inner = here if isinstance(here, Mapping) else inner
    return inner


def _entry(here: Any, step: str, key: str, way: list[str]) -> Any:
    """Where, in a table or a list, a step of the way leads: a key or a place."""
    if isinstance(here, dict):
        return step
    before = ".".join(way)
    if not isinstance(here, list):
        raise CaseError(
            "leads into something that is not a table", where=f"set {key}: {before}", found=here
        )
    names = [_name(table) for table in here]
    if step in names:
        return names.index(step)
    if step.isdecimal() and int(step) < len(here):
        return int(step)
    known = [name for name in names if name]
    places = f"{before}[0]" + (f" to {before}[{len(here) - 1}]" if len(here) > 1 else "")
    raise CaseError(
        f"there is no such entry of {before}",
        where=f"set {key}",
        found=step,
        allowed=", ".join([*known, *([places] if here else [])]) or "none: the list is empty",
        remedy=suggest(step, known),
    )


def _name(table: Any) -> str | None:
    """What a table is called: by its name, as results call it without one, or by its prefix."""
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
    """Numbers, lists and tables as a case file has them, of arrays too."""
    if isinstance(value, dict):
        return {key: plain(one) for key, one in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    if isinstance(value, tuple | list):
        return [plain(one) for one in value]
    return value
