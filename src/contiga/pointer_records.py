"""Named tuples of arrays that compiled kernels get by pointer.

numba passes a tuple by its members: each array is seven to eleven numbers, and the tables of a body
are forty arrays, so that every call from one kernel to the next would pass four hundred arguments
that the compiler has to unpack and pack again. Kernels get one pointer to a tuple marked here, and
read it as any other: `tables.elements.coefs`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

Class = TypeVar("Class", bound=type)

PASSED_BY_POINTER: set[type] = set()
"""Classes that are passed by pointer."""
_LISTENERS: list[Callable[[type], object]] = []


def pass_by_pointer(tuple_class: Class) -> Class:
    """Mark a class of named tuples and return it; a decorator.

    Kernels may read the attributes of such a tuple, pass it on and put it into other tuples. They
    cannot create one, and must not return its arrays.
    """
    PASSED_BY_POINTER.add(tuple_class)
    for listener in _LISTENERS:
        listener(tuple_class)
    return tuple_class


def for_each_marked(listener: Callable[[type], object]) -> None:
    """Call `listener` with every marked class, including classes that are marked later.

    The compiler registers its type of a class by this, so that records do not import the compiler.
    """
    _LISTENERS.append(listener)
    for tuple_class in tuple(PASSED_BY_POINTER):
        listener(tuple_class)
