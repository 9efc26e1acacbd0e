"""Hold contiga's part of a coupled run: masters, slaves, contacts and sensors, by name."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from contiga.arrays.ordered import length
from contiga.contact.state import State
from contiga.couple.carriers import Carrier, frame_of, point_rates
from contiga.couple.kick import Kick
from contiga.dynamics.nodes import SlaveState
from contiga.dynamics.prescribed import Fixed, Moved
from contiga.dynamics.stepping import EqualSteps
from contiga.errors import InputError
from contiga.records import FloatArray
from contiga.rigid.frames import to_body, to_world
from contiga.rigid.twist import Twist, still
from contiga.simulation.model import BodyPart, ContactPart, Model, SlavePart
from contiga.simulation.relative_sensors import relative_columns
from contiga.simulation.sensor import RelativeSensor, Sensor
from contiga.simulation.sensors import on_axes
from contiga.simulation.system_state import BodyStates, Energy, SystemState

_LETTERS = {"acceleration": "a", "velocity": "v", "displacement": "", "spin": "w"}
_WITH_MAGNITUDE = ("acceleration", "velocity")


class Carriers(NamedTuple):
    """Masters and slaves on bodies of a MuJoCo model, by name."""

    masters: Mapping[str, Carrier]
    slaves: Mapping[str, Carrier]
    moving: Mapping[str, int]
    """Bodies that can move, by name."""


class _FixedMotion(NamedTuple):
    """Placeholder for a motion by MuJoCo: only its start is known."""

    first: FloatArray

    def pose(self, t: float) -> FloatArray:
        """Return the pose at the start."""
        return self.first

    def twist(self, t: float) -> Twist:
        """Return a twist of zero."""
        return still()


class Scene:
    """Masters, slaves, contacts and sensors at the start of a run.

    Raises
    ------
    InputError
        Sensors that are not on masters, with the same name, with criteria but no units, or with
        measures that only MuJoCo knows.
    """

    def __init__(
        self,
        physics: tuple[Any, Any],
        carriers: Carriers,
        parts: tuple[ContactPart, ...],
        sensors: Sequence[Sensor | RelativeSensor],
        units: tuple[str, str, str],
    ) -> None:
        self._masters, self._slaves, moving = carriers
        model, data = physics
        rest = np.zeros(model.nv)
        frames = {n: frame_of(model, data, item.body, rest) for n, item in self._masters.items()}
        self.model = Model(
            bodies={
                n: BodyPart(item.carried, _FixedMotion(frames[n].pose))
                for n, item in self._masters.items()
            },
            slaves={
                n: SlavePart(item.carried, Moved(item.carried.points, Fixed()))
                for n, item in self._slaves.items()
            },
            contacts=parts,
            stepping=EqualSteps(0.0, 1.0, 1.0),
            sensors=tuple(self._with_points(item, physics) for item in sensors),
            units=units,
        )
        self._points = {}
        for sensor in self.model.point_sensors:
            _check_sensor(sensor, moving)
            point = _default_point(physics, self._masters[sensor.body].body)
            first = np.array(point if sensor.at is None else sensor.at)
            at = to_body(frames[sensor.body].pose, first[None])[0]
            self._points[sensor.name] = at, first
        for pair in self.model.relative:
            if "acceleration" in pair.measures:
                raise InputError(
                    "the acceleration between two bodies of MuJoCo is not measured here",
                    where=f"sensor {pair.name!r}: measures",
                    found="acceleration",
                    remedy="Take a Sensor on each of them",
                )

    def _with_points(
        self, item: Sensor | RelativeSensor, physics: tuple[Any, Any]
    ) -> Sensor | RelativeSensor:
        """Return a sensor; one between two bodies gets their centres of mass as default points.

        It stays as it is with points of its own, or on unknown masters, which `Model` refuses.
        Raises `InputError` for objects that are no sensors of masters.
        """
        if not isinstance(item, Sensor | RelativeSensor):
            raise InputError(
                "is no sensor of masters",
                where="sensors",
                found=type(item).__name__,
                allowed="Sensor and RelativeSensor: slaves are moved by MuJoCo here",
            )
        if not isinstance(item, RelativeSensor) or item.at is not None:
            return item
        masters = item.between
        if not set(masters) <= set(self._masters):
            return item
        at = [_default_point(physics, self._masters[name].body) for name in masters]
        return replace(item, at=np.array(at))

    def state(
        self,
        physics: tuple[Any, Any],
        speed: FloatArray,
        contacts: Mapping[str, State],
        time: float,
    ) -> SystemState:
        """Return the state of all parts at the joint velocities `speed`; its energies are zero."""
        bodies = [frame_of(*physics, item.body, speed) for item in self._masters.values()]
        slaves = {}
        for name, item in self._slaves.items():
            frame = frame_of(*physics, item.body, speed)
            points = to_world(frame.pose, item.carried.points)
            slaves[name] = SlaveState(points, frame.twist.at(frame.pose[:3, 3], points))
        return SystemState(
            time,
            BodyStates(
                {name: i for i, name in enumerate(self._masters)},
                np.array([frame.pose for frame in bodies]),
                np.array([np.concatenate(frame.twist) for frame in bodies]),
            ),
            slaves,
            dict(contacts),
            Energy(0.0),
        )

    def columns(self, physics: tuple[Any, Any], now: Kick, state: SystemState) -> dict[str, float]:
        """Return the columns of all sensors by name; displacements are since the start."""
        columns: dict[str, float] = {}
        for sensor in self.model.point_sensors:
            at, first = self._points[sensor.name]
            body, pose = self._masters[sensor.body].body, state.bodies[sensor.body].pose
            place = to_world(pose, at[None])[0]
            v, a = point_rates(*physics, body, place, now.speed, now.acceleration)
            spin = state.bodies[sensor.body].twist.spin
            values = {"acceleration": a, "velocity": v, "displacement": place - first, "spin": spin}
            origin = self.model.origins[self.model.mechanism.root_of(sensor.body)]
            for measure in sensor.measures:
                vector, letter = values[measure], _LETTERS[measure]
                if sensor.turns:
                    vector = on_axes(sensor, pose, origin, vector)
                named = zip("xyz", vector, strict=True)
                columns |= {f"{sensor.name}.{letter}{axis}": float(x) for axis, x in named}
                if measure in _WITH_MAGNITUDE:
                    columns[f"{sensor.name}.{letter}"] = length(vector)
        return columns | relative_columns(self.model, state, None)


def _default_point(physics: tuple[Any, Any], body: int) -> FloatArray:
    """Return the centre of mass (3,) of a body that can move, else its frame's origin."""
    model, data = physics
    return np.array(data.xipos[body] if model.body_weldid[body] != 0 else data.xpos[body])


def _check_sensor(sensor: Sensor, moving: Mapping[str, int]) -> None:
    """Raise `InputError` for measures that are unknown here, or the name of a moving body."""
    unknown = [measure for measure in sensor.measures if measure not in _LETTERS]
    if unknown:
        raise InputError(
            "what acts on a body of MuJoCo is not measured here",
            where=f"sensor {sensor.name!r}: measures",
            found=", ".join(unknown),
            allowed=", ".join(map(repr, _LETTERS)),
            remedy="Put a <force> or <torque> sensor into the MuJoCo model",
        )
    if sensor.name in moving:
        raise InputError(
            "must have a name of its own: columns of the history are called by it",
            where="sensors: name",
            found=sensor.name,
            allowed="not that of a body, a contact or another sensor",
        )
