"""The process that compiles kernels: it reads rows of the list, one a line, and replies in JSON.

It ends at once when its standard input ends, and so with the process that started it.
"""

from __future__ import annotations

import json
import os
import signal
import sys
import threading
from queue import SimpleQueue
from typing import Any

from contiga.warmup.garbage import rare_collections
from contiga.warmup.listing import listing

NICENESS = 10
"""Priority below that of a run, which needs all cores for its steps."""


def serve() -> None:
    """Compile the requested kernels, one after the other, until the process ends; never return.

    Its priority is low, it ignores Ctrl-C, and both output streams are closed to libraries: replies
    go to a copy of the standard output.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the process that started this one
    if hasattr(os, "nice"):
        os.nice(NICENESS)
    replies = os.fdopen(os.dup(1), "w", encoding="utf-8")
    null = os.open(os.devnull, os.O_RDWR)
    for stream in (1, 2):  # output of libraries
        os.dup2(null, stream)
    rows: SimpleQueue[int] = SimpleQueue()
    threading.Thread(target=_listen, args=(rows,), daemon=True).start()
    with rare_collections():
        while True:
            reply = compile_row(rows.get())
            try:
                replies.write(json.dumps(reply) + "\n")
                replies.flush()
            except OSError:  # nobody reads any more
                os._exit(0)


def _listen(rows: SimpleQueue[int]) -> None:
    """Queue the rows of the standard input; end the process when the input ends."""
    for line in sys.stdin:
        rows.put(int(line))
    os._exit(0)


def compile_row(row: int) -> dict[str, Any]:
    """Compile a kernel of the list; return fields of `Progress`.

    They are `is_compiled` (False if it was read from the cache) and `file` (its cache index file,
    or ""); or `error`, as no error of compiling is raised.
    """
    try:
        kernel = listing().compile(row)
    except Exception as error:
        return {"error": f"{type(error).__name__}: {error}"}
    is_compiled = listing().arguments(row) in kernel.stats.cache_misses
    return {"is_compiled": is_compiled, "file": getattr(kernel._cache, "index", "")}
