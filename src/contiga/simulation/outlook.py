"""Estimate after a minute the remaining time of a run, and warn with advice if it is very long."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable

from contiga.simulation.reasons import Reason
from contiga.simulation.step import StepResult

PATIENCE = 60.0
"""Seconds of wall-clock time over which the pace is measured."""
LONG_RUN = 3600.0
"""Remaining seconds from which a run counts as very long."""


class Outlook:
    """The remaining time of a run at the pace of its last minute; it warns once.

    Parameters
    ----------
    end : end of the run
    now : clock, seconds
    """

    def __init__(self, end: float, now: Callable[[], float]) -> None:
        self._end = end
        self._now = now
        self._has_warned = False
        self._begin: tuple[float, float] | None = None
        self._cuts: Counter[tuple[Reason, str]] = Counter()

    def after(self, stepped: StepResult) -> str | None:
        """Return a warning after a step if more than `LONG_RUN` remains at the present pace.

        The pace is that of the last `PATIENCE` seconds or more; the measurement begins anew if less
        remains. Returns None during the first `PATIENCE` seconds of a measurement, if less remains,
        and after the first warning.
        """
        if self._has_warned:
            return None
        now, time = self._now(), stepped.state.time
        if self._begin is None:
            self._begin = now, time
            return None
        if stepped.choice is not None:
            cut = stepped.choice.cut
            self._cuts[cut.reason, cut.of] += 1
        elapsed = now - self._begin[0]
        if elapsed < PATIENCE:
            return None
        progress = time - self._begin[1]
        seconds_left = elapsed * (self._end - time) / progress if progress > 0.0 else float("inf")
        if seconds_left < LONG_RUN:
            self._begin = now, time
            self._cuts.clear()
            return None
        self._has_warned = True
        if stepped.choice is None or not self._cuts:
            cause = 'Its steps are as given: longer ones, fewer points, or step = "auto" end sooner'
        else:  # the most frequent reason for short steps, with its remedy
            (reason, of), count = self._cuts.most_common(1)[0]
            cut, share = stepped.choice.cut, 100.0 * count / self._cuts.total()
            cut_text = cut._replace(reason=reason, of=of).text()
            cause = f"What sets {share:.0f} % of its steps, now of {cut.step:.3g}: {cut_text}"
            cause += f". Longer ones need {reason.remedy}" if reason.remedy else ""
        return (
            f"t = {time:.6g} of {self._end:g}: at the pace of the last {elapsed:.0f} s the run "
            f"takes {_duration_text(seconds_left)} more. {cause}"
        )


def _duration_text(seconds: float) -> str:
    """Return a duration in words.

    >>> _duration_text(7200.0), _duration_text(400000.0), _duration_text(float("inf"))
    ('2 hours', '4.6 days', 'for ever')
    """
    hours = seconds / 3600.0
    if hours > 24.0 * 3650.0:
        return "for ever"
    return f"{hours:.2g} hours" if hours < 48.0 else f"{hours / 24.0:.2g} days"
