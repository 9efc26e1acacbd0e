"""Named tuples of arrays that compiled kernels are handed by their place in memory.

numba hands a tuple by its members: each array is seven to eleven numbers, and the tables of a body
are forty arrays, so that every call from one kernel to the next would carry four hundred arguments
that the compiler has to take apart and put together again. Of a tuple marked here kernels get one
pointer. They read it as any other: `tables.elements.coefs`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

Class = TypeVar("Class", bound=type)

PASSED_BY_POINTER: set[type] = set()
"""Classes that are passed by pointer."""
_LISTENERS: list[Callable[[type], object]] = []


def pass_by_pointer(tuple_class: Class) -> Class:
    """Mark a class of named tuples; a decorator.

    Kernels may read the attributes of such a tuple, hand it on and put it into other tuples. They
    cannot make one, and must not return its arrays.
    """
    PASSED_BY_POINTER.add(tuple_class)
    for listener in _LISTENERS:
        listener(tuple_class)
    return tuple_class


def for_each_marked(listener: Callable[[type], object]) -> None:
    """Call `listener` with every class that is marked, now and from now on.

    So the compiler's type of a class is told where there is a compiler, and classes need none.
    """
    _LISTENERS.append(listener)
    for tuple_class in tuple(PASSED_BY_POINTER):
        listener(tuple_class)
