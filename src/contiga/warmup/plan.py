"""Hand out the kernels of a list to workers in an order in which they can be compiled.

All parts of a kernel are compiled before it is handed out, so that no worker waits for another one
while it compiles. Kernels that a run waits for go first, with their parts.
"""

from __future__ import annotations

from collections.abc import Sequence
from threading import Condition

from contiga.warmup.listing import Row


class Plan:
    """The state of the kernels of a list: compiled, being compiled, or ready to compile.

    Parameters
    ----------
    parts : kernels that each kernel calls; they stand before it
    """

    def __init__(self, parts: Sequence[Sequence[Row]]) -> None:
        self._parts = parts
        self._callers: list[list[Row]] = [[] for _ in parts]
        for row, parts_of_row in enumerate(parts):
            for part in parts_of_row:
                self._callers[part].append(row)
        self._n_missing = [len(parts_of_row) for parts_of_row in parts]
        """Number of parts of each kernel that are not compiled."""
        self._ready = {row for row, parts_of_row in enumerate(parts) if not parts_of_row}
        self._unfinished = set(range(len(parts)))
        self._urgent: list[Row] = []
        """Kernels that a run waits for."""
        self._ended = False
        self._changed = Condition()

    def take(self) -> Row | None:
        """Wait for a ready kernel and return its row; None if all are finished, or after `end`."""
        with self._changed:
            while self._unfinished and not self._ended:
                row = self._take_ready()
                if row is not None:
                    return row
                self._changed.wait()
            return None

    def take_towards(self, row: Row) -> Row | None:
        """Return the row of the next kernel for a worker that needs `row`.

        It is one of its parts or, if all of these are being compiled, any other that is ready; if
        none is, the worker waits. It is `row` itself when all its parts are compiled, and None if
        `row` is finished or after `end`. Until it returns, other workers prefer these parts, too.
        """
        with self._changed:
            self._urgent.append(row)
            try:
                while row in self._unfinished and not self._ended:
                    next_row = self._take_ready()
                    if next_row is not None:
                        return next_row
                    self._changed.wait()
                return None
            finally:
                self._urgent.remove(row)

    def done(self, row: Row) -> None:
        """Mark a kernel as finished, compiled or not: kernels that call it may become ready.

        A second time has no effect.
        """
        with self._changed:
            if row not in self._unfinished:
                return
            self._unfinished.remove(row)
            self._ready.discard(row)
            for caller in self._callers[row]:
                self._n_missing[caller] -= 1
                if self._n_missing[caller] == 0 and caller in self._unfinished:
                    self._ready.add(caller)
            self._changed.notify_all()

    def end(self) -> None:
        """Hand out no more kernels."""
        with self._changed:
            self._ended = True
            self._changed.notify_all()

    def _take_ready(self) -> Row | None:
        """Remove and return the first ready kernel; None if no kernel is ready.

        Urgent kernels and their parts precede all others. The caller holds the lock.
        """
        needed, stack = set(self._urgent), list(self._urgent)
        while stack:
            for part in self._parts[stack.pop()]:
                if part in self._unfinished and part not in needed:
                    needed.add(part)
                    stack.append(part)
        candidates = self._ready & needed or self._ready
        if not candidates:
            return None
        row = min(candidates)
        self._ready.remove(row)
        return row
