"""One line on the error stream of a process when its first kernel is compiled.

Compiling takes seconds to minutes, in which a script or a notebook would seem to hang. The line is
left out where the stream is neither a terminal nor a notebook, in processes that another one
started, and where `SWITCH` is set. Commands have messages of their own, and call `leave_out`.
"""

from __future__ import annotations

import multiprocessing
import os
import sys

from contiga.display import is_read_along
from contiga.jit.folder import kernel_folder

SWITCH = "CONTIGA_QUIET"
"""Environment variable; any value but 0 leaves the line out."""

_said = False


def say_once() -> None:
    """Print that kernels are compiled, on the first call in a process."""
    global _said
    if _said:
        return
    _said = True
    if (
        os.environ.get(SWITCH, "0") not in ("", "0")
        or multiprocessing.parent_process() is not None
        or not is_read_along(sys.stderr)
    ):
        return
    how_long = "for this process only" if kernel_folder() is None else "once for all projects"
    print(
        f"contiga compiles kernels, {how_long}: up to a minute or two ({SWITCH}=1 hides this)",
        file=sys.stderr,
        flush=True,
    )


def leave_out() -> None:
    """Suppress the line in this process."""
    global _said
    _said = True
