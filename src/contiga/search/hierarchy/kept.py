"""Keep what is computed once from a body's tables, as long as they live.

What takes long is kept on the disk, too, by all that it is made of: the tables' arrays.
"""

from __future__ import annotations

import weakref
from collections.abc import Callable, Iterator
from typing import Any, Generic, TypeVar

import numpy as np

from contiga.arrays.digest import Digest
from contiga.arrays.disk_cache import DiskCache
from contiga.search.hierarchy.table_types import Tables

T = TypeVar("T")


class Kept(Generic[T]):
    """Answers of `build`, one for each body.

    They are in `disk` for other processes, where there is one and a body has `least` elements.
    """

    def __init__(
        self, build: Callable[..., T], disk: DiskCache | None = None, least: int = 0
    ) -> None:
        self._build, self._disk, self._least = build, disk, least
        self._kept: dict[int, T] = {}
        self._asked: dict[int, int] = {}

    def of(self, tables: Tables, *how: Any) -> T:
        """Return the answer for the body of `tables`, computed at the first call with `how`."""
        key = self._key(tables)
        if key not in self._kept:
            disk = self._disk if len(tables.elements.table) >= self._least else None
            self._kept[key] = (
                self._build(tables, *how)
                if disk is None
                else disk.kept(_digest_of(tables, how), lambda: self._build(tables, *how))
            )
        return self._kept[key]

    def if_worth(self, tables: Tables, asked: int, worth: int) -> T | None:
        """Return the value if it is there, or if `asked` with all asked before is `worth` it."""
        key = self._key(tables)
        if key not in self._kept:
            self._asked[key] += asked
            if self._asked[key] < worth:
                return None
        return self.of(tables)

    def _key(self, tables: Tables) -> int:
        # Tuples of tables are put together anew; the array of elements is one a body.
        elements = tables.elements.table
        key = id(elements)
        if key not in self._asked:
            self._asked[key] = 0
            weakref.finalize(elements, self._forget, key)
        return key

    def _forget(self, key: int) -> None:
        self._kept.pop(key, None)
        self._asked.pop(key, None)


def _digest_of(tables: Tables, how: tuple[Any, ...]) -> str:
    """Return a digest of all arrays and numbers of tables, and of `how`.

    It leaves out the leaves that guesses begin at and the neighbourhoods: those are filled in when
    they are asked for.
    """
    digest, seeds = Digest(), tables.seeds
    digest.text(repr(how))
    tables = tables._replace(seeds=seeds._replace(leaf=seeds.leaf[:0]))
    tables = tables._replace(neighbourhoods=tables.neighbourhoods[:0])
    for k, leaf in enumerate(_leaves(tables)):
        digest.arrays(str(k), np.asarray(leaf))
    return digest.hexdigest()


def _leaves(tables: Any) -> Iterator[Any]:
    """Yield the entries of named tuples in named tuples."""
    for part in tables:
        if isinstance(part, tuple):
            yield from _leaves(part)
        else:
            yield part
