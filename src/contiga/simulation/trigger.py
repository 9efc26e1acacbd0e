"""Define triggers: the channel of a sensor that fires something, and the state of one."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from contiga.arrays.layout import not_negative, positive, real
from contiga.errors import InputError

OF_TRIGGERS = ("trigger", "fired")
"""Columns of a trigger: its channel as it sees it, and 1 from when it has fired."""
CORNER = 2.0775
"""Corner of SAE J211's filters in a single pass, in their class: their 3 dB are of both passes."""


class TriggerState(NamedTuple):
    """The state of a trigger at one time."""

    raw: float
    """The channel."""
    value: float
    """The channel as it is filtered."""
    slope: float
    """Rate of that; zero without a filter."""
    since: float
    """Time since which the value has been beyond the threshold; infinite where it is not."""
    fires: float
    """Time at which it fires; infinite as long as that is not known. Then it never changes."""


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
    sign: float
    """1 of a threshold that is passed upward, −1 of one that is passed downward."""
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
        """Return the state at the start."""
        beyond = self.sign * (raw - self.level) > 0.0
        begun = TriggerState(raw, raw, 0.0, time if beyond else math.inf, math.inf)
        return self._fired(begun, time)

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
            foreseen = w * w * (raw - last.value - half * last.slope)
            slope = (last.slope + half * (before + foreseen)) / (
                1.0 + half * damping + half * half * w * w
            )
            value = last.value + half * (last.slope + slope)
        was, now = (self.sign * (v - self.level) for v in (last.value, value))
        since = math.inf
        if now > 0.0:
            since = last.since
            if not was > 0.0:
                since = time - dt * now / (now - was)
        return self._fired(TriggerState(raw, value, slope, since, last.fires), time)

    def _fired(self, state: TriggerState, time: float) -> TriggerState:
        done = state.since + self.lasting
        if math.isfinite(state.fires) or not done <= time:
            return state
        return state._replace(fires=done + self.delay)
