"""Cache the result of a function for each object, as long as the object lives."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import TypeVar
from weakref import WeakKeyDictionary

Key = TypeVar("Key")
Result = TypeVar("Result")


def once(function: Callable[[Key], Result]) -> Callable[[Key], Result]:
    """Return `function` with a cache of its results by object.

    Objects must be hashable and are referenced weakly; a result None is computed again. Threads
    that call at the same time may each compute a result, of which the last is kept.

    >>> class Body:
    ...     pass
    >>> body, calls = Body(), []
    >>> number = once(lambda body: calls.append(body) or len(calls))
    >>> number(body), number(body), number(Body())
    (1, 1, 2)
    """
    results: WeakKeyDictionary[Key, Result] = WeakKeyDictionary()

    @wraps(function)
    def cached(key: Key) -> Result:
        result = results.get(key)
        if result is None:
            result = results[key] = function(key)
        return result

    return cached
