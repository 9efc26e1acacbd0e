"""Types of the fixtures of runs that are stopped."""

from __future__ import annotations

from collections.abc import Callable

from contiga import Simulation

Make = Callable[..., Simulation]
StopAfter = Callable[[int], Callable[[int, int, int], None]]
