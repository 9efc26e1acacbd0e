"""Cache results that are computed once from a body's tables, as long as these live.

Results that take long are also cached on the disk, by a digest of the tables' arrays.
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


class TableCache(Generic[T]):
    """Results of `build`, one for each body.

    They are also in `disk`, if given, for bodies with at least `min_elements` elements.
    """

    def __init__(
        self, build: Callable[..., T], disk: DiskCache | None = None, min_elements: int = 0
    ) -> None:
        self._build, self._disk, self._min_elements = build, disk, min_elements
        self._results: dict[int, T] = {}
        self._uses: dict[int, int] = {}

    def of(self, tables: Tables, *how: Any) -> T:
        """Return the result for the body of `tables`, computed at the first call with `how`."""
        key = self._key(tables)
        if key not in self._results:
            if self._disk is None or len(tables.elements.table) < self._min_elements:
                self._results[key] = self._build(tables, *how)
            else:
                digest = _digest_of(tables, how)
                self._results[key] = self._disk.get_or_build(
                    digest, lambda: self._build(tables, *how)
                )
        return self._results[key]

    def if_pays(self, tables: Tables, asked: int, worth: int) -> T | None:
        """Return the result if it exists, or if the sum of `asked` over all calls is `worth` it."""
        key = self._key(tables)
        if key not in self._results:
            self._uses[key] += asked
            if self._uses[key] < worth:
                return None
        return self.of(tables)

    def _key(self, tables: Tables) -> int:
        # Tuples of tables are rebuilt, but a body has one array of elements.
        elements = tables.elements.table
        key = id(elements)
        if key not in self._uses:
            self._uses[key] = 0
            for cache in (self._results, self._uses):
                weakref.finalize(elements, cache.pop, key, None)
        return key


def _digest_of(tables: Tables, how: tuple[Any, ...]) -> str:
    """Return a digest of `how` and of tables, except for seeds and neighbourhoods.

    Seeds and neighbourhoods are left out: they are filled in later, on demand.
    """
    digest, seeds = Digest(), tables.seeds
    digest.text(repr(how))
    tables = tables._replace(seeds=seeds._replace(leaf=seeds.leaf[:0]))
    tables = tables._replace(neighbourhoods=tables.neighbourhoods[:0])
    for k, array in enumerate(_arrays(tables)):
        digest.arrays(str(k), np.asarray(array))
    return digest.hexdigest()


def _arrays(tables: Any) -> Iterator[Any]:
    """Yield the arrays in nested named tuples."""
    for part in tables:
        if isinstance(part, tuple):
            yield from _arrays(part)
        else:
            yield part
