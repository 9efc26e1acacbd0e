"""One line on the error stream of a process when its first kernel is compiled.

Compiling takes seconds to minutes, in which a script or a notebook would seem to hang. The line is
not printed if the stream is neither a terminal nor a notebook, in child processes, and if `SWITCH`
is set. Commands print messages of their own, and call `suppress_notice`.
"""

from __future__ import annotations

import multiprocessing
import os
import sys

from contiga.display import is_read_along
from contiga.jit.folder import kernel_folder

SWITCH = "CONTIGA_QUIET"
"""Environment variable; any value except 0 suppresses the line."""

_is_notified = False


def notify_once() -> None:
    """Print that kernels are compiled, on the first call in a process, unless it is to be quiet."""
    global _is_notified
    if _is_notified:
        return
    _is_notified = True
    if (
        os.environ.get(SWITCH, "0") not in ("", "0")
        or multiprocessing.parent_process() is not None
        or not is_read_along(sys.stderr)
    ):
        return
    scope = "for this process only" if kernel_folder() is None else "once for all projects"
    print(
        f"contiga compiles kernels, {scope}: up to a minute or two ({SWITCH}=1 hides this)",
        file=sys.stderr,
        flush=True,
    )


def suppress_notice() -> None:
    """Suppress the line in this process."""
    global _is_notified
    _is_notified = True
