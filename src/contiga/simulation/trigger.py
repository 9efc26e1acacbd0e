"""Define triggers: thresholds of sensor channels that fire devices, and their states."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from contiga.arrays.layout import not_negative, positive, real
from contiga.errors import InputError

TRIGGER_COLUMNS = ("trigger", "fired")
"""Columns of a trigger: its filtered channel, and 1 once it has fired."""
CORNER = 2.0775
"""Corner frequency of one pass of SAE J211's filters over their class: 3 dB are of two passes."""


class TriggerState(NamedTuple):
    """The state of a trigger at one time."""

    raw: float
    """Value of the channel."""
    value: float
    """Filtered value of the channel."""
    slope: float
    """Rate of the filtered value; zero without a filter."""
    since: float
    """Time since when the value has been beyond the threshold; infinite if it is not."""
    fires: float
    """Firing time; infinite until it is known, and constant from then on."""


@dataclass(frozen=True, init=False, eq=False)
class Trigger:
    """A threshold of a channel of a sensor, which fires once.

    It fires when the channel has been beyond the threshold for a while, `delay` later: inflators,
    pretensioners, releases and locks of retractors that name its sensor wait for that.

    Parameters
    ----------
    channel : column of the sensor, as "ax" or "a" (its magnitude), "distance", "rate"; "a" of a
        `Sensor`, "distance" of a `RelativeSensor` if omitted
    above, below : the threshold, one of both
    lasting : time for which the channel is beyond it without a break; `for` in case files
    delay : time from then on

    Notes
    -----
    When the channel passes the threshold is interpolated between two steps. An acceleration is
    filtered if its sensor has a filter: by a Butterworth filter of second order with the corner
    of that class, y'' + √2 ω y' + ω² y = ω² x, ω = 2π · 2.0775 · class. It goes forward in time
    only, as no device knows the future, and so lags by √2/ω, where the filtered columns of the
    history do not.

    Raises
    ------
    InputError
        Not one threshold, times below zero.

    Examples
    --------
    >>> import contiga as cg
    >>> trigger = cg.Trigger(above=0.05, lasting=1.0, delay=5.0)
    >>> cg.Sensor("crash", "sled", trigger=trigger).trigger.level
    0.05
    """

    channel: str | None
    level: float
    """The threshold, in the unit of the channel."""
    sign: float
    """1 for a threshold that is passed upward, −1 downward."""
    lasting: float
    delay: float

    def __init__(
        self,
        channel: str | None = None,
        *,
        above: float | None = None,
        below: float | None = None,
        lasting: float = 0.0,
        delay: float = 0.0,
    ) -> None:
        level = above if below is None else below
        if level is None or (above is not None and below is not None):
            raise InputError("a trigger has one threshold", where="trigger", allowed="above, below")
        put = object.__setattr__
        put(self, "channel", channel)
        put(self, "sign", 1.0 if below is None else -1.0)
        try:
            put(self, "level", float(real(level)))
        except (TypeError, ValueError) as error:
            raise InputError("must be a number", where="trigger", found=level) from error
        put(self, "lasting", not_negative(lasting, "for"))
        put(self, "delay", not_negative(delay, "delay"))
        if not math.isfinite(self.level):
            raise InputError("must be finite", where="trigger", found=level)

    def start(self, raw: float, time: float) -> TriggerState:
        """Return the state at the start, where a value beyond the threshold counts from `time`."""
        beyond = self.sign * (raw - self.level) > 0.0
        state = TriggerState(raw, raw, 0.0, time if beyond else math.inf, math.inf)
        return self._fired(state, time)

    def step(
        self, last: TriggerState, raw: float, time: float, dt: float, corner: float | None
    ) -> TriggerState:
        """Return the state after a step to `time`.

        Parameters
        ----------
        last : state before the step
        raw : value of the channel at the end of the step
        time, dt : end and length of the step
        corner : ω of the filter, radians / time; None without one
        """
        value, slope = raw, 0.0
        if corner is not None:
            # Both rates by the trapezoidal rule.
            w, half = positive(corner, "corner"), 0.5 * dt
            damping = math.sqrt(2.0) * w
            before = w * w * (last.raw - last.value) - damping * last.slope
            after = w * w * (raw - last.value - half * last.slope)
            slope = (last.slope + half * (before + after)) / (
                1.0 + half * damping + half * half * w * w
            )
            value = last.value + half * (last.slope + slope)
        old_excess, new_excess = (self.sign * (v - self.level) for v in (last.value, value))
        since = math.inf
        if new_excess > 0.0:
            since = last.since
            if not old_excess > 0.0:
                since = time - dt * new_excess / (new_excess - old_excess)
        return self._fired(TriggerState(raw, value, slope, since, last.fires), time)

    def _fired(self, state: TriggerState, time: float) -> TriggerState:
        """Return the state with its firing time, once it is known; that never changes again."""
        held_until = state.since + self.lasting
        if math.isfinite(state.fires) or not held_until <= time:
            return state
        return state._replace(fires=held_until + self.delay)
