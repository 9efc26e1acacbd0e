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
    """Results of `build`, one for each body, as long as the body's array of elements lives.

    They are also in `disk`, if given, for bodies with at least `min_elements` elements.
    """

    def __init__(
        self, build: Callable[..., T], disk: DiskCache | None = None, min_elements: int = 0
    ) -> None:
        self._build, self._disk, self._min_elements = build, disk, min_elements
        self._results: dict[int, T] = {}
        self._uses: dict[int, int] = {}

    def of(self, tables: Tables, *args: Any) -> T:
        """Return the result for the body of `tables`; `args` are those of `build` after the tables.

        It is read from the disk, or built, at the first call for this body; later calls ignore
        `args`.
        """
        key = self._key(tables)
        if key in self._results:
            return self._results[key]
        if self._disk is None or len(tables.elements.table) < self._min_elements:
            self._results[key] = self._build(tables, *args)
            return self._results[key]
        # Seeds and neighbourhoods are no part of the digest: they are filled in later, on demand.
        stable = tables._replace(
            seeds=tables.seeds._replace(leaf=tables.seeds.leaf[:0]),
            neighbourhoods=tables.neighbourhoods[:0],
        )
        digest = Digest()
        digest.text(repr(args))
        for k, array in enumerate(_arrays(stable)):
            digest.arrays(str(k), np.asarray(array))
        result = self._disk.get_or_build(digest.hexdigest(), lambda: self._build(tables, *args))
        self._results[key] = result
        return result

    def if_pays(self, tables: Tables, n_queries: int, min_queries: int) -> T | None:
        """Return the result if it exists or pays, else None.

        It pays, and is built, once the sum of `n_queries` over all calls for this body reaches
        `min_queries`; each call without a result adds to that sum.
        """
        key = self._key(tables)
        if key not in self._results:
            self._uses[key] += n_queries
            if self._uses[key] < min_queries:
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


def _arrays(tables: Any) -> Iterator[Any]:
    """Yield the arrays in nested named tuples."""
    for part in tables:
        if isinstance(part, tuple):
            yield from _arrays(part)
        else:
            yield part
