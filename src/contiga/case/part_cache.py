"""A cache of bodies and slaves that several cases have in common."""

from __future__ import annotations

import warnings
from collections import OrderedDict
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, TypeVar

from contiga.case.spec import Spec
from contiga.errors import ContigaWarning

Part = TypeVar("Part")


class PartCache:
    """Cache of the parts made from tables of cases, and of everything derived from them.

    Bodies and slaves are never changed: a cached part has the same bits as a new one. A file that
    has changed since (its time or its size) is read again.

    Parameters
    ----------
    max_parts : largest number of cached parts; the least recently used are removed first

    >>> import contiga as cg
    >>> case, cache = cg.load_case("case.toml"), PartCache()
    >>> heads = [cg.build(case, parts=cache).bodies["head"].body for _ in range(2)]
    >>> heads[0] is heads[1]
    True
    """

    def __init__(self, max_parts: int = 32) -> None:
        self._max_parts = max_parts
        self._parts: OrderedDict[tuple[Any, ...], Any] = OrderedDict()

    def part(self, spec: Spec, name: str, unit: str, make: Callable[[], Part]) -> Part:
        """Return the part that `make` makes from a table, or the cached one of an equal table.

        Tables are equal if name, unit, all keys but `align`, `place` and `then`, and the files that
        they name are. An error of `make` is not cached.

        Warns
        -----
        ContigaWarning
            The warnings of `make`, at each call.
        """
        table = spec.model_dump(mode="python", exclude={"align", "place", "then"})
        key = (type(spec).__name__, name, unit, repr(table), tuple(_file_stamps(table)))
        if key not in self._parts:
            with warnings.catch_warnings(record=True) as caught:
                warnings.simplefilter("always", ContigaWarning)
                part = make()
            self._parts[key] = part, caught
        self._parts.move_to_end(key)
        while len(self._parts) > self._max_parts:
            self._parts.popitem(last=False)
        cached: Part
        cached, caught = self._parts[key]
        for warning in caught:
            warnings.warn_explicit(
                warning.message, warning.category, warning.filename, warning.lineno
            )
        return cached


def _file_stamps(value: Any) -> Iterator[tuple[str, int, int]]:
    """Yield path, modification time (ns) and size (bytes) of the absolute file paths in a table."""
    if isinstance(value, dict | list):
        for entry in value.values() if isinstance(value, dict) else value:
            yield from _file_stamps(entry)
    elif isinstance(value, str) and Path(value).is_absolute() and Path(value).is_file():
        stat = Path(value).stat()
        yield value, stat.st_mtime_ns, stat.st_size
