"""Names of parts: allowed names in a run, and selection and lists of names in files."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from difflib import get_close_matches

import numpy as np

from contiga.errors import InputError

PartKeys = str | int | Sequence[str | int]
"""One name or number, or several."""

SHOWN = 40
"""Largest number of names in a message."""

NAME = re.compile(r"\w[\w\-]*(?: [\w\-]+)*")
"""Pattern of names, which become heads of columns, groups and parts of files."""
NAMES = "letters, digits, single spaces, _ and -, the first a letter or digit"


def check_name(name: object, where: str) -> None:
    """Refuse an invalid name of a body, slave, contact, spring or sensor.

    Raises
    ------
    InputError
        It is no text, empty, or has characters that `NAME` excludes.
    """
    if not isinstance(name, str) or not NAME.fullmatch(name):
        raise InputError("is not a name", where=where, found=name, allowed=NAMES)


def as_keys(keys: PartKeys) -> list[str | int]:
    """Return one name or number as a list of it, several as a new list."""
    return [keys] if isinstance(keys, str | int | np.integer) else list(keys)


def listed(labels: Iterable[str]) -> str:
    """Return the first `SHOWN` different labels as one text, and how many more there are."""
    names = list(dict.fromkeys(labels))
    more = f" and {len(names) - SHOWN} more" if len(names) > SHOWN else ""
    return ", ".join(names[:SHOWN]) + more


def closest(key: object, names: Iterable[str]) -> str | None:
    """Return a question that suggests the closest of `names`, None if none is close.

    >>> closest("Boxx", ["box", "pin"])
    "Did you mean 'box'?"
    """
    name = closest_name(key, names)
    return None if name is None else f"Did you mean {name!r}?"


def closest_name(key: object, names: Iterable[str]) -> str | None:
    """Return the name most like `key` by `difflib`, in any case; None if none is 60 % like it."""
    by_fold = {name.casefold(): name for name in names}
    close = get_close_matches(str(key).casefold(), by_fold, n=1, cutoff=0.6)
    return by_fold[close[0]] if close else None
