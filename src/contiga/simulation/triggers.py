"""Take triggers through a step: read their channels, and tell when they fire."""

from __future__ import annotations

import math
from collections.abc import Mapping

from contiga.dynamics.kinks import SAME_TIME
from contiga.io.units import base_factor
from contiga.simulation.model import Model
from contiga.simulation.relative_sensors import between_columns
from contiga.simulation.sensor import RelativeSensor, Sensor, channel_of
from contiga.simulation.sensors import point_columns
from contiga.simulation.system_state import SystemState
from contiga.simulation.trigger import CORNER, OF_TRIGGERS, TriggerState


def trigger_states(
    model: Model, last: SystemState | None, state: SystemState
) -> dict[str, TriggerState]:
    """Return all triggers by their sensors at `state`, after the state `last`."""
    states = {}
    for sensor in model.triggered:
        if isinstance(sensor, Sensor):
            told = point_columns(model, sensor, state, last)
        else:
            told = between_columns(model, sensor, state, last)
        raw, trigger = told[f"{sensor.name}.{channel_of(sensor)}"], sensor.trigger
        assert trigger is not None
        if last is None or sensor.name not in last.triggers:
            states[sensor.name] = trigger.start(raw, state.time)
            continue
        dt, corner = state.time - last.time, _corner(model, sensor)
        states[sensor.name] = trigger.step(last.triggers[sensor.name], raw, state.time, dt, corner)
    return states


def _corner(model: Model, sensor: Sensor | RelativeSensor) -> float | None:
    if not isinstance(sensor, Sensor) or sensor.filter is None or channel_of(sensor)[0] != "a":
        return None
    hertz = CORNER * int(sensor.filter.removeprefix("CFC"))
    return 2.0 * math.pi * hertz * base_factor(model.units[2], "time")


def firing_times(states: Mapping[str, TriggerState]) -> dict[str, float]:
    """Return when triggers fire, for those of which that is known."""
    return {name: state.fires for name, state in states.items() if math.isfinite(state.fires)}


def kinks_of_triggers(model: Model, state: SystemState) -> list[float]:
    """Return times after `state` at which what triggers fire has a kink: steps end there."""
    nearest = SAME_TIME * (model.stepping.end - model.stepping.start)
    return [
        float(time)
        for name, fires in firing_times(state.triggers).items()
        for time in fires + model.fired_kinks[name]
        if time > state.time + nearest
    ]


def trigger_columns(state: SystemState) -> dict[str, float]:
    """Return the history columns of triggers."""
    columns: dict[str, float] = {}
    for name, one in state.triggers.items():
        values = one.value, float(one.fires <= state.time)
        columns |= {f"{name}.{c}": v for c, v in zip(OF_TRIGGERS, values, strict=True)}
    return columns
