"""Triggers: when a channel fires, and what its filter does to it."""

from __future__ import annotations

import math

import numpy as np
import pytest

import contiga as cg
from contiga.errors import InputError
from contiga.records import FloatArray
from contiga.simulation.trigger import CORNER, TriggerState


def fed(trigger: cg.Trigger, times, values, corner=None) -> list[TriggerState]:  # type: ignore[no-untyped-def]
    states = [trigger.start(float(values[0]), float(times[0]))]
    for before, time, value in zip(times, times[1:], values[1:], strict=False):
        dt = float(time - before)
        states.append(trigger.step(states[-1], float(value), float(time), dt, corner))
    return states


def test_a_trigger_fires_once_where_its_channel_passes_the_threshold() -> None:
    times = np.arange(8.0)
    states = fed(cg.Trigger("ax", above=2.5, delay=3.0), times, [0, 1, 2, 3, 0, 9, 9, 0])
    assert [s.fires for s in states] == [math.inf] * 3 + [2.5 + 3.0] * 5
    down = fed(cg.Trigger("ax", below=-2.0), times, [0, 0, -4, 0, 0, 0, 0, 0])
    assert [s.fires for s in down] == [math.inf] * 2 + [1.5] * 6


def test_a_short_peak_does_not_fire_what_is_to_last() -> None:
    times = np.arange(9.0)
    states = fed(cg.Trigger("a", above=1.0, lasting=2.5), times, [0, 2, 2, 0, 2, 2, 2, 2, 2])
    assert [s.since for s in states[:4]] == [math.inf, 0.5, 0.5, math.inf]
    assert states[5].fires == math.inf
    assert states[6].fires == 3.5 + 2.5


def test_a_channel_that_starts_beyond_its_threshold_fires_from_the_start_on() -> None:
    assert fed(cg.Trigger("x", above=-1.0, delay=0.5), [2.0], [0.0])[0].fires == 2.5
    assert fed(cg.Trigger("x", above=0.0), [2.0], [0.0])[0].fires == math.inf


def ramped(times: FloatArray, corner: float) -> FloatArray:
    """The answer of the filter to the ramp x = t, from rest."""
    w = corner / math.sqrt(2.0)
    rest = np.exp(-w * times) / w * np.cos(w * times)
    return np.asarray(times - math.sqrt(2.0) / corner + rest)


@pytest.mark.parametrize("jitter", [0.0, 0.4])
def test_the_filter_is_a_butterworth_of_second_order(jitter) -> None:  # type: ignore[no-untyped-def]
    corner, n = 2.0, 4000
    steps = 1.0 + jitter * np.sin(np.arange(n))
    times = np.concatenate([[0.0], np.cumsum(steps * 5.0 / n)])
    # A ramp from rest: what is left of the formula is of the second order in the step.
    states = fed(cg.Trigger("a", above=1e9), times, times, corner)
    np.testing.assert_allclose([s.value for s in states], ramped(times, corner), atol=1e-6)


def sled(**options) -> cg.Simulation:  # type: ignore[no-untyped-def]
    brake = cg.motion.Accelerated([[0.0, 0.0], [10.0, -20.0]], direction="x")
    sensor = cg.Sensor("crash", "sled", **{"trigger": cg.Trigger("ax", below=-5.0)} | options)
    dummy = cg.motion.Free(1.0, inertia=np.eye(3))
    ball = cg.Body([cg.shapes.sphere(radius=1.0)])
    return cg.Simulation(
        bodies={"sled": (ball, brake), "dummy": (ball, dummy)},
        slaves={},
        contacts=[],
        sensors=[sensor],
        end=10.0,
        step=0.01,
        units=("mm", "g", "ms"),
    )


def test_a_run_tells_what_triggers_see_and_when_they_fire() -> None:
    result = sled().run()
    history = result.history
    np.testing.assert_array_equal(history["crash.trigger"], history["crash.ax"])
    np.testing.assert_array_equal(history["crash.fired"], history["time"] > 2.5 + 1e-9)
    assert result.summary["sensors"]["crash"]["fired"] == pytest.approx(2.51)
    assert result.state.triggers["crash"].fires == pytest.approx(2.5, rel=1e-12)
    never = sled(trigger=cg.Trigger("ax", below=-1e3)).run()
    assert never.summary["sensors"]["crash"]["fired"] is None


def test_a_filter_makes_a_trigger_late() -> None:
    history = sled(filter="CFC60").run().history
    corner = 2.0 * math.pi * CORNER * 60 * 1e-3
    late = -2.0 * ramped(history["time"], corner)
    np.testing.assert_allclose(history["crash.trigger"], late, atol=1e-5)
    np.testing.assert_array_equal(history["crash.fired"], late < -5.0)


def test_sensors_between_bodies_have_triggers_too() -> None:
    with pytest.raises(InputError, match="trigger: channel: the sensor has no such column; found"):
        cg.RelativeSensor("gap", ("a", "b"), trigger=cg.Trigger("ax", above=1.0))
    gap = cg.RelativeSensor("gap", ("sled", "dummy"), trigger=cg.Trigger("rate", above=10.0))
    base = sled()
    both = cg.Simulation(
        bodies=base.bodies, slaves={}, contacts=[], sensors=[gap], end=10.0, step=0.01
    )
    # v = t²: a rate of 10 at √10.
    assert both.run().state.triggers["gap"].fires == pytest.approx(math.sqrt(10.0), rel=1e-5)


@pytest.mark.parametrize(
    ("make", "told"),
    [
        (lambda: cg.Trigger("a"), "a trigger has one threshold"),
        (lambda: cg.Trigger("a", above=1, below=2), "a trigger has one threshold"),
        (lambda: cg.Trigger("a", above=math.nan), "trigger: must be finite"),
        (lambda: cg.Trigger("a", above=1.0, lasting=-1.0), "for: must not be negative"),
        (lambda: cg.Trigger("a", above=1.0, delay=-1.0), "delay: must not be negative"),
        (lambda: sled(trigger=cg.Trigger("wx", above=1.0)), "found 'wx'; allowed: 'ax', 'ay'"),
    ],
)
def test_triggers_that_make_no_sense_are_refused(make, told) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(InputError, match=told):
        make()
