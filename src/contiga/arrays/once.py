"""Keep what is computed once of an object, as long as that lives."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import TypeVar
from weakref import WeakKeyDictionary

Thing = TypeVar("Thing")
Answer = TypeVar("Answer")


def once(work: Callable[[Thing], Answer]) -> Callable[[Thing], Answer]:
    """`work`, done at the first call for each thing.

    >>> class Thing:
    ...     pass
    >>> thing, asked = Thing(), []
    >>> number = once(lambda thing: asked.append(thing) or len(asked))
    >>> number(thing), number(thing), number(Thing())
    (1, 1, 2)
    """
    kept: WeakKeyDictionary[Thing, Answer] = WeakKeyDictionary()

    @wraps(work)
    def answer(thing: Thing) -> Answer:
        known = kept.get(thing)
        if known is None:
            known = kept[thing] = work(thing)
        return known

    return answer
