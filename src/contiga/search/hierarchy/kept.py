"""What is worked out once of a body's tables, and kept as long as they live."""

from __future__ import annotations

import weakref
from collections.abc import Callable
from typing import Any, Generic, TypeVar

from contiga.search.hierarchy.table_types import Tables

T = TypeVar("T")


class Kept(Generic[T]):
    """Answers of `build`, one for each body."""

    def __init__(self, build: Callable[..., T]) -> None:
        self._build = build
        self._kept: dict[int, T] = {}
        self._asked: dict[int, int] = {}

    def of(self, tables: Tables, *how: Any) -> T:
        """That of the body which `tables` are of, worked out at the first call, with `how`."""
        key = self._key(tables)
        if key not in self._kept:
            self._kept[key] = self._build(tables, *how)
        return self._kept[key]

    def there(self, tables: Tables) -> T | None:
        """The same if it is there."""
        return self._kept.get(id(tables.elements.table))

    def if_worth(self, tables: Tables, asked: int, worth: int) -> T | None:
        """The same if it is there, or `asked` with all that was asked before is `worth` it."""
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
