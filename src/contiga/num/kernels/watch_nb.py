"""Threads that wait for each other for a short time: none of them sleeps meanwhile."""

from __future__ import annotations

from contiga.num.glance import glance
from contiga.num.jit import kernel


@kernel()
def watch(count, seen, looks, more):
    """Wait until count[0] is no longer `seen`, and `more` looks longer; so many looks at most."""
    for _ in range(looks):
        if glance(count) != seen:
            for _ in range(more):
                glance(count)
            return
