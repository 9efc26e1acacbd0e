"""Records of arrays laid out in memory once, for kernels that are called all the time.

A call from Python looks at every array of the records it is handed, and lays them out anew: of the
tables of a body, forty arrays, that takes as long as to follow some ten points. A `Pinned` does
so once. Kernels are handed the place, a whole number, and read the record there by a `reader` of
its class, as they read one that they were passed by pointer (`contiga.pointer_records`).

Laid out is what numba has of arrays (its model of them: two owners, of which there are none here,
the numbers and bytes of one, where they are, shape and strides), floats, whole numbers, and records
that are by reference themselves, by their places.
"""

from __future__ import annotations

from collections.abc import Callable
from types import FunctionType
from typing import Any
from weakref import WeakValueDictionary

import numpy as np
from numba import typeof
from numba.core import types as numba_types
from numba.core.errors import TypingError
from numba.core.imputils import lower_builtin
from numba.core.typing.templates import AbstractTemplate, infer_global, signature

from contiga.jit import reference as reference  # the type of what is read
from contiga.pointer_records import PASSED_BY_POINTER

types: Any = numba_types
TYPES: dict[str, Any] = {}
"""numba's types of records, by the names of their classes, from the first one laid out on."""
AT_ADDRESS: WeakValueDictionary[int, Pinned] = WeakValueDictionary()
"""Where no kernel is compiled records are found by their places."""


_READ: dict[Callable[[int], Any], str] = {}
"""Classes by their readers."""


class Pinned:
    """A record in memory that stays for as long as this.

    The numbers in its arrays may change; arrays and numbers of its own may not.

    Parameters
    ----------
    record : a named tuple whose class is marked by `contiga.pointer_records.pass_by_pointer`

    Raises
    ------
    TypeError
        It is not by reference, or holds something else than arrays, numbers and such records;
        or its arrays are of other types than those of the first of its class, for which kernels
        are compiled.
    """

    def __init__(self, record: Any) -> None:
        kind = type(record)
        name, own = f"{kind.__module__}.{kind.__qualname__}", typeof(record)
        if kind not in PASSED_BY_POINTER:
            raise TypeError(f"{name} is not by reference")
        if TYPES.setdefault(name, own) != own:
            raise TypeError(f"another {name} had other types than {own}")
        self.record = record
        self._parts: list[Pinned] = []
        words = [word for value in record for word in self._words(value)]
        self._memory = np.array([word & (2**64 - 1) for word in words], np.uint64)
        self.address = int(self._memory.ctypes.data)
        AT_ADDRESS[self.address] = self

    def __reduce__(self) -> tuple[type[Pinned], tuple[Any]]:
        return Pinned, (self.record,)  # copies, and what is written to files, lie elsewhere

    def _words(self, value: Any) -> list[int]:
        """A member as it stands in memory, eight bytes each."""
        if isinstance(value, np.ndarray):
            return [
                0,
                0,
                value.size,
                value.itemsize,
                value.ctypes.data,
                *value.shape,
                *value.strides,
            ]
        if type(value) in PASSED_BY_POINTER:
            self._parts.append(Pinned(value))
            return [self._parts[-1].address]
        if isinstance(value, float):
            return [int(np.float64(value).view(np.int64))]
        if isinstance(value, (int, np.integer)) and not isinstance(value, bool):
            return [int(value)]
        raise TypeError(f"{type(value).__name__} cannot be laid out")


def reader(name: str) -> Callable[[int], Any]:
    """A function that kernels read records of the class `name` by, from their places.

    The name is the full one, with the module: kernels import no others. Before a kernel with a
    reader is compiled a record has to be laid out, as the first of a class tells its types.
    """

    def read(place: int) -> Any:
        """The record there."""
        return AT_ADDRESS[place].record

    class Read(AbstractTemplate):  # type: ignore[misc]
        """What numba asks for the type of a call."""

        key = read

        def generic(self, places: tuple[Any, ...], names: dict[str, Any]) -> Any:
            """A record by reference; nothing where no whole number is given."""
            if names or len(places) != 1 or not isinstance(places[0], types.Integer):
                return None
            if name not in TYPES:
                raise TypingError(f"no {name} has been laid out yet")
            return signature(TYPES[name], types.intp)

    infer_global(read, types.Function(Read))
    lower_builtin(read, types.intp)(_pointer)
    _READ[read] = name
    return read


def types_read(function: Any) -> tuple[tuple[str, str], ...]:
    """The classes that readers in the module of a kernel read, and the types of their records.

    What is compiled of the kernel depends on them, and its arguments do not tell.
    """
    found = {_READ[of] for of in function.__globals__.values() if is_reader(of)}
    return tuple((name, str(TYPES.get(name))) for name in sorted(found))


def is_reader(value: Any) -> bool:
    """Whether something is a function that `reader` has made."""
    return isinstance(value, FunctionType) and value in _READ


def _pointer(context: Any, builder: Any, asked: Any, places: tuple[Any, ...]) -> Any:
    """Code that takes a place for a pointer."""
    return builder.inttoptr(places[0], context.get_value_type(asked.return_type))
