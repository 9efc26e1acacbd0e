"""Bodies and slaves that one case after another has in common, read and built once."""

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
    """Keeps what was made of a table of a case, with all that was built of it since.

    Bodies and slaves are never changed: what is kept gives the same bits as what is made anew. A
    file that has changed since (its time or its size) is read again.

    Parameters
    ----------
    most : parts kept; those not asked for the longest are let go first

    >>> import contiga as cg
    >>> case, cache = cg.load_case("case.toml"), PartCache()
    >>> heads = [cg.build(case, parts=cache).bodies["head"].body for _ in range(2)]
    >>> heads[0] is heads[1]
    True
    """

    def __init__(self, most: int = 32) -> None:
        self._most = most
        self._kept: OrderedDict[tuple[Any, ...], Any] = OrderedDict()

    def part(self, spec: Spec, name: str, unit: str, make: Callable[[], Part]) -> Part:
        """What `make` gives of a table, or gave before for the same one.

        Warns
        -----
        ContigaWarning
            What `make` warned of, each time.
        """
        said = spec.model_dump(mode="python", exclude={"align", "place", "then"})
        key = (type(spec).__name__, name, unit, repr(said), tuple(_stamps(said)))
        if key not in self._kept:
            with warnings.catch_warnings(record=True) as caught:
                warnings.simplefilter("always", ContigaWarning)
                made = make()
            self._kept[key] = made, caught
        self._kept.move_to_end(key)
        while len(self._kept) > self._most:
            self._kept.popitem(last=False)
        part: Part
        part, findings = self._kept[key]
        for one in findings:
            warnings.warn_explicit(one.message, one.category, one.filename, one.lineno)
        return part


def _stamps(said: Any) -> Iterator[tuple[str, int, int]]:
    """Times and sizes of the files that a table names, which a case has absolute."""
    if isinstance(said, dict):
        for value in said.values():
            yield from _stamps(value)
    elif isinstance(said, list):
        for value in said:
            yield from _stamps(value)
    elif isinstance(said, str) and Path(said).is_absolute() and Path(said).is_file():
        stat = Path(said).stat()
        yield said, stat.st_mtime_ns, stat.st_size
