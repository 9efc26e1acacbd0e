"""Memory that is given back is kept by the process, for the next step."""

from __future__ import annotations

import numpy as np

LARGEST = 31 * 2**20
"""Bytes: just below what glibc always asks the system for, and gives back to it."""


def keep_freed() -> None:
    """From now on, in this process, blocks of up to `LARGEST` bytes come out of memory it has.

    glibc takes the size of the largest block that it has given back to the system for what is large
    enough to be asked for there, at first 128 KiB, and gives back what lies free beyond twice that.
    Steps make arrays, and let them go: each would ask for all of them anew, page by page, which may
    take as long as tracking. Here one is let go of whose pages were never touched. Elsewhere than
    with glibc this does nothing. See mallopt(3), M_MMAP_THRESHOLD.
    """
    np.empty(LARGEST, np.uint8)
