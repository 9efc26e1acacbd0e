"""Plan what of a list of kernels can be compiled now, and hand it out to those who compile.

Whoever takes a kernel finds all its parts there, so nobody waits for another in the midst of one.
What a run waits for, and what that is built of, goes first.
"""

from __future__ import annotations

from collections.abc import Sequence, Set
from threading import Condition

from contiga.warmup.listing import Row


class Plan:
    """The state of the kernels: which are there, which are being made, and which could be.

    Parameters
    ----------
    parts : of each kernel, those that it is built of; they stand before it
    """

    def __init__(self, parts: Sequence[Sequence[Row]]) -> None:
        self._parts = parts
        self._builds: list[list[Row]] = [[] for _ in parts]
        for row, needed in enumerate(parts):
            for part in needed:
                self._builds[part].append(row)
        self._missing = [len(needed) for needed in parts]
        self._ready = {row for row, needed in enumerate(parts) if not needed}
        self._left = set(range(len(parts)))
        self._wanted: list[Row] = []
        self._ended = False
        self._changed = Condition()

    def take(self) -> Row | None:
        """A kernel to be compiled, as soon as there is one; None once none is left."""
        with self._changed:
            while self._left and not self._ended:
                ready = self._first(self._ready)
                if ready is not None:
                    return ready
                self._changed.wait()
            return None

    def take_towards(self, row: Row) -> Row | None:
        """Return the next kernel to compile for a worker that needs `row`.

        It is one of its parts or, if all of these are being compiled, any other, so that nobody
        waits.

        `row` itself where its turn has come, None where it is there by now.
        """
        with self._changed:
            self._wanted.append(row)
            try:
                while row in self._left and not self._ended:
                    ready = self._first(self._ready)
                    if ready is not None:
                        return ready
                    self._changed.wait()
                return None
            finally:
                self._wanted.remove(row)

    def done(self, row: Row) -> None:
        """A kernel is there, or cannot be made: what it is a part of may be."""
        with self._changed:
            if row not in self._left:
                return
            self._left.remove(row)
            self._ready.discard(row)
            for whole in self._builds[row]:
                self._missing[whole] -= 1
                if self._missing[whole] == 0 and whole in self._left:
                    self._ready.add(whole)
            self._changed.notify_all()

    def end(self) -> None:
        """From now on, nothing is handed out."""
        with self._changed:
            self._ended = True
            self._changed.notify_all()

    def _first(self, other: Set[Row]) -> Row | None:
        """Take what comes first of what can be made: what is wanted, or else one of `other`."""
        wanted = self._ready & self._needed() if self._wanted else set()
        among = wanted or other
        if not among:
            return None
        ready = min(among)
        self._ready.remove(ready)
        return ready

    def _needed(self) -> set[Row]:
        """Return what is wanted, and those of its parts that are not there."""
        needed, waiting = set(self._wanted), list(self._wanted)
        while waiting:
            for part in self._parts[waiting.pop()]:
                if part in self._left and part not in needed:
                    needed.add(part)
                    waiting.append(part)
        return needed
