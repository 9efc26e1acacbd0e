"""Processor time of a run by room: what is asked of the engine is timed where it is asked for."""

from __future__ import annotations

import cProfile
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from functools import wraps
from time import thread_time
from typing import Any
from unittest.mock import patch

from contiga.contact.contact import Contact
from contiga.search.exact_surface import ExactSurface
from contiga.search.hierarchy.table_cache import TableCache
from contiga.simulation import step
from contiga.simulation.clock import Clock
from contiga.simulation.recorder import Recorder
from contiga.triangles.facet_surface import FacetedSurface

ROOMS = ("place", "search", "sides", "forces", "motion", "ledger", "record", "output")
START = "start"
"""What is worked out once of a body, at whatever step that is."""
_SIDES = ("sides", "clear_paths", "last_crossings")
TIMED: tuple[tuple[str, Any, tuple[str, ...]], ...] = (
    (START, TableCache, ("of",)),
    ("place", step, ("place",)),
    ("forces", Contact, ("start", "step")),
    ("sides", ExactSurface, _SIDES),
    ("sides", FacetedSurface, _SIDES),
    ("ledger", step, ("energy_of", "external_work", "contact_energy")),
    ("record", Recorder, ("take",)),
)
"""Functions that a room is entered by, beside the stages of the engine's clock. What a contact does
about velocities and states, outside of its search, is counted as forces."""
STAGES = {"search": "search", "forces": "forces", "motion": "motion", "output": "output"}


class RoomClock(Clock):
    """Seconds of one thread's processor by room: in each without those in rooms it calls.

    >>> clock = RoomClock()
    >>> with clock.inside("search"), clock.inside("sides"):
    ...     before = clock.spent["search"]
    >>> clock.spent["search"] >= before and clock.spent["place"] == 0.0
    True
    """

    def __init__(self) -> None:
        super().__init__()
        self._within = ["motion"]
        self.reset()

    def reset(self) -> None:
        """Begin at nought."""
        self.spent = dict.fromkeys((*ROOMS, START), 0.0)
        self._since = thread_time()

    def read(self) -> dict[str, float]:
        """What was spent until now."""
        self._charge()
        return dict(self.spent)

    def _charge(self) -> None:
        now = thread_time()
        self.spent[self._within[-1]] += now - self._since
        self._since = now

    @contextmanager
    def inside(self, room: str) -> Iterator[None]:
        """Count what is done inside as the room's."""
        self._charge()
        self._within.append(room)
        try:
            yield
        finally:
            self._charge()
            self._within.pop()

    @contextmanager
    def __call__(self, stage: str) -> Iterator[None]:
        """A stage of the engine; one that is no room belongs to that which it is in."""
        with super().__call__(stage), self.inside(STAGES.get(stage, self._within[-1])):
            yield

    def _entered(self, room: str, work: Callable[..., Any]) -> Callable[..., Any]:
        @wraps(work)
        def timed(*args: Any, **named: Any) -> Any:
            with self.inside(room):
                return work(*args, **named)

        return timed

    @contextmanager
    def listening(self) -> Iterator[None]:
        """Within this the functions of `TIMED` are timed."""
        with ExitStack() as stack:
            for room, home, names in TIMED:
                for name in names:
                    timed = self._entered(room, getattr(home, name))
                    stack.enter_context(patch.object(home, name, timed))
            yield


def kernel_seconds(profile: cProfile.Profile) -> float:
    """Seconds inside of kernels, by a profile of a run."""
    profile.create_stats()
    times = profile.stats.items()
    return sum(
        own
        for (file, _, name), (_, _, own, _, _) in times
        if "_nb.py" in file or ("contiga" in name and "_nb." in name)
    )
