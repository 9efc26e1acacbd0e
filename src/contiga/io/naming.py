"""Parts of files by name or number: what a key may be, and how a message lists what there is."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from difflib import get_close_matches

import numpy as np

PartKeys = str | int | Sequence[str | int]
"""One name or number, or several."""

SHOWN = 40
"""Names a message lists at most."""


def as_keys(keys: PartKeys) -> list[str | int]:
    """The names and numbers, one or several, as a list."""
    return [keys] if isinstance(keys, str | int | np.integer) else list(keys)


def listed(labels: Iterable[str]) -> str:
    """`labels` in a row, the first `SHOWN` of them."""
    rows = list(dict.fromkeys(labels))
    more = f" and {len(rows) - SHOWN} more" if len(rows) > SHOWN else ""
    return ", ".join(rows[:SHOWN]) + more


def closest(key: object, names: Iterable[str]) -> str | None:
    """A question after the closest of `names`, None where nothing is close.

    >>> closest("Boxx", ["box", "pin"])
    "Did you mean 'box'?"
    """
    name = closest_name(key, names)
    return None if name is None else f"Did you mean {name!r}?"


def closest_name(key: object, names: Iterable[str]) -> str | None:
    """The closest of `names`, None where nothing is close."""
    by_fold = {name.casefold(): name for name in names}
    close = get_close_matches(str(key).casefold(), by_fold, n=1, cutoff=0.6)
    return by_fold[close[0]] if close else None
