"""Advance triggers in a step: read their channels, and determine when they fire."""

from __future__ import annotations

import math
from collections.abc import Mapping

from contiga.dynamics.kinks import TIME_TOL
from contiga.io.units import base_factor
from contiga.simulation.model import Model
from contiga.simulation.relative_sensors import between_columns
from contiga.simulation.sensor import Sensor, channel_of
from contiga.simulation.sensors import point_columns
from contiga.simulation.system_state import SystemState
from contiga.simulation.trigger import CORNER, TRIGGER_COLUMNS, TriggerState


def trigger_states(
    model: Model, last: SystemState | None, state: SystemState
) -> dict[str, TriggerState]:
    """Return all triggers at `state`, after the state `last`, by the names of their sensors.

    Accelerations of a sensor with a filter are filtered; a trigger that `last` does not have is
    started.
    """
    states = {}
    for sensor in model.triggered:
        if isinstance(sensor, Sensor):
            columns = point_columns(model, sensor, state, last)
        else:
            columns = between_columns(model, sensor, state, last)
        raw, trigger = columns[f"{sensor.name}.{channel_of(sensor)}"], sensor.trigger
        assert trigger is not None
        if last is None or sensor.name not in last.triggers:
            states[sensor.name] = trigger.start(raw, state.time)
            continue
        corner = None
        if (
            isinstance(sensor, Sensor)
            and sensor.filter is not None
            and channel_of(sensor)[0] == "a"
        ):
            hertz = CORNER * int(sensor.filter.removeprefix("CFC"))
            corner = 2.0 * math.pi * hertz * base_factor(model.units[2], "time")
        dt = state.time - last.time
        states[sensor.name] = trigger.step(last.triggers[sensor.name], raw, state.time, dt, corner)
    return states


def firing_times(states: Mapping[str, TriggerState]) -> dict[str, float]:
    """Return the firing times of triggers that are known so far, by sensor."""
    return {name: state.fires for name, state in states.items() if math.isfinite(state.fires)}


def kinks_of_triggers(model: Model, state: SystemState) -> list[float]:
    """Return times after `state` at which fired devices have kinks: steps end there.

    Kinks within `TIME_TOL` of the run's duration after the state are left out.
    """
    nearest = TIME_TOL * (model.stepping.end - model.stepping.start)
    return [
        float(time)
        for name, fires in firing_times(state.triggers).items()
        for time in fires + model.fired_kinks[name]
        if time > state.time + nearest
    ]


def trigger_columns(state: SystemState) -> dict[str, float]:
    """Return the history columns of triggers by name: filtered value, and 1 once fired, else 0."""
    columns: dict[str, float] = {}
    for name, trigger in state.triggers.items():
        values = trigger.value, float(trigger.fires <= state.time)
        columns |= {f"{name}.{c}": v for c, v in zip(TRIGGER_COLUMNS, values, strict=True)}
    return columns
