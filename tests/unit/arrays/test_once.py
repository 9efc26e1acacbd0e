"""What is worked out once of a thing."""

from __future__ import annotations

import gc
import weakref

from contiga.arrays.once import once


class Thing:
    pass


def test_work_is_done_once_a_thing_and_forgotten_with_it() -> None:
    asked = []

    @once
    def number(thing: Thing) -> int:
        """Which one it is."""
        asked.append(id(thing))
        return len(asked)

    one, other = Thing(), Thing()
    assert [number(one), number(other), number(one)] == [1, 2, 1]
    assert number.__doc__ == "Which one it is."
    gone = weakref.ref(one)
    del one
    gc.collect()
    assert gone() is None
