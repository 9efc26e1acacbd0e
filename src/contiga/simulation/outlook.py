"""Say after a minute of a run how long it will take, if that is very long, and what would help."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable

from contiga.simulation.reasons import Reason
from contiga.simulation.step import Stepped

PATIENCE = 60.0
"""Seconds of the clock that a pace is taken over."""
LONG = 3600.0
"""Seconds still to go from which on the end is out of reach."""


class Outlook:
    """The remaining time of a run at the pace of its last minute. It speaks once.

    Parameters
    ----------
    end : of the run
    now : seconds of the clock
    """

    def __init__(self, end: float, now: Callable[[], float]) -> None:
        self._end = end
        self._now = now
        self._spoken = False
        self._from: tuple[float, float] | None = None
        self._cuts: Counter[tuple[Reason, str]] = Counter()

    def after(self, stepped: Stepped) -> str | None:
        """Return what there is to say after a step; None where there is nothing."""
        if self._spoken:
            return None
        now, time = self._now(), stepped.state.time
        if self._from is None:
            self._from = now, time
            return None
        if stepped.choice is not None:
            cut = stepped.choice.cut
            self._cuts[cut.reason, cut.of] += 1
        passed = now - self._from[0]
        if passed < PATIENCE:
            return None
        gone = time - self._from[1]
        left = passed * (self._end - time) / gone if gone > 0.0 else float("inf")
        if left < LONG:
            self._from = now, time
            self._cuts.clear()
            return None
        self._spoken = True
        if stepped.choice is None or not self._cuts:
            why = 'Its steps are as given: longer ones, fewer points, or step = "auto" end sooner'
        else:  # what makes them short most often, and what would let them be longer
            (reason, of), count = self._cuts.most_common(1)[0]
            cut, share = stepped.choice.cut, 100.0 * count / self._cuts.total()
            said = cut._replace(reason=reason, of=of).said()
            why = f"What sets {share:.0f} % of its steps, now of {cut.step:.3g}: {said}"
            why += f". Longer ones need {reason.remedy}" if reason.remedy else ""
        return (
            f"t = {time:.6g} of {self._end:g}: at the pace of the last {passed:.0f} s the run "
            f"takes {_long(left)} more. {why}"
        )


def _long(seconds: float) -> str:
    """Return a duration in words.

    >>> _long(7200.0), _long(400000.0), _long(float("inf"))
    ('2 hours', '4.6 days', 'for ever')
    """
    hours = seconds / 3600.0
    if hours > 24.0 * 3650.0:
        return "for ever"
    return f"{hours:.2g} hours" if hours < 48.0 else f"{hours / 24.0:.2g} days"
