"""The process that compiles kernels: a row of the list a line on its standard input, JSON back.

It ends with its input, whatever it is at: with the process that started it, that is.
"""

from __future__ import annotations

import json
import os
import signal
import sys
import threading
from queue import SimpleQueue
from typing import Any, TextIO

from contiga.warmup.garbage import looked_for_seldom
from contiga.warmup.listing import listing

MODEST = 10
"""A run that needs all cores for its steps gets them first."""


def serve() -> None:
    """Compile what is asked for, one after the other."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the process that started this one
    if hasattr(os, "nice"):
        os.nice(MODEST)
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    nowhere = os.open(os.devnull, os.O_RDWR)
    for stream in (1, 2):  # what libraries print
        os.dup2(nowhere, stream)
    rows: SimpleQueue[int] = SimpleQueue()
    threading.Thread(target=_listen, args=(rows,), daemon=True).start()
    with looked_for_seldom():
        while True:
            tell(answers, **compiled(rows.get()))


def _listen(rows: SimpleQueue[int]) -> None:
    for line in sys.stdin:
        rows.put(int(line))
    os._exit(0)


def compiled(row: int) -> dict[str, Any]:
    """Have a kernel of the list; whether it was made, its file, and why it could not be had."""
    try:
        kernel = listing().compile(row)
    except Exception as failed:
        return {"error": f"{type(failed).__name__}: {failed}"}
    made = listing().arguments(row) in kernel.stats.cache_misses
    return {"made": made, "file": getattr(kernel._cache, "index", "")}


def tell(answers: TextIO, **what: object) -> None:
    """Write a line; where nobody reads any more, end."""
    try:
        answers.write(json.dumps(what) + "\n")
        answers.flush()
    except OSError:
        os._exit(0)
