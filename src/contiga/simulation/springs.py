"""Advance springs and slip rings in a step, and write them into the history and the summary."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from contiga.arrays.ordered import length
from contiga.curves.curve_records import Response
from contiga.dynamics.belt_devices import Moment
from contiga.dynamics.nodes import SlaveState
from contiga.dynamics.slip_rings import SlipRingState, slip
from contiga.dynamics.springs import SpringState
from contiga.errors import RunError
from contiga.records import FloatArray
from contiga.rigid.frames import cross
from contiga.simulation.load_forces import point_of
from contiga.simulation.mechanism import Mechanism, RingSide
from contiga.simulation.model import Model
from contiga.simulation.sensors import point_velocity
from contiga.simulation.system_state import BodyStates, SystemState

SPRING_COLUMNS = (
    *("force", "elongation", "rate"),
    *("energy_stored", "energy_hysteresis", "energy_damping"),
)
"""Columns of a spring: tension with its damper, elongation beyond the length at rest and its rate,
stored energy, and energies lost since the start."""


DEVICE_COLUMNS = ("paid_out", "travel", "pulled_in", "locked", "released", "energy_pretension")
"""Columns of a spring with devices: length paid out since the start, travel of film and limiter
under load, length pulled in; 1 once the retractor has locked, and once the end is released; work of
the pretensioner."""
SLIP_RING_COLUMNS = ("slipped", "angle", "energy_friction")
"""Columns of a slip ring: length that slipped from its first segment into the second, wrap angle of
the webbing, and energy lost."""
MAX_SWEEPS = 1000
"""Largest number of sweeps over all slip rings of a belt."""
SLIP_TOL = 1e-15
"""Slip in a sweep, as a share of the length of segments, at which the sweeps end."""


class Ends(NamedTuple):
    """Positions and velocities of the ends of a spring."""

    places: FloatArray
    """(2, 3) world."""
    velocities: FloatArray
    """(2, 3)."""


class SpringStates(NamedTuple):
    """Springs and slip rings at the end of a step."""

    springs: dict[str, SpringState]
    rings: dict[str, SlipRingState]


def spring_states(
    model: Model,
    last: SystemState | None,
    bodies: BodyStates,
    slaves: Mapping[str, SlaveState],
    moment: Moment,
) -> SpringStates:
    """Return all springs and slip rings at the end of a step from `last`; None at the start.

    Webbing slips through the rings first. Raises `RunError` if their slips do not converge.
    """
    system = model.mechanism
    before: dict[str, SpringState] = {}
    ends: dict[str, Ends] = {}
    for name, spring in system.springs.items():
        places, velocities = np.empty((2, 3)), np.zeros((2, 3))
        for k, (i, slave, nodes, shares) in enumerate(system.ends[name]):
            places[k] = spring.at[k]
            if i is not None:
                pose, twist = bodies.poses[i], bodies.twists[i]
                places[k] = point_of(pose, model.origins[i], spring.at[k])
                velocities[k] = twist[:3] + cross(twist[3:], places[k] - pose[:3, 3])
            elif slave is not None:
                state = slaves[slave]
                places[k] = shares @ state.points[nodes]
                velocities[k] = shares @ state.velocities[nodes]
        ends[name] = Ends(places, velocities)
        before[name] = spring.at_rest if last is None else last.springs[name]
    slips = _ring_slips(model, before, ends, moment) if system.rings else {}
    fed = dict.fromkeys(system.springs, 0.0)
    for name, sides in system.rings.items():
        fed[sides[0].spring] -= slips[name]
        fed[sides[1].spring] += slips[name]
    springs = {}
    for name, spring in system.springs.items():
        now = spring.step(before[name], *ends[name], moment=moment, fed=fed[name])
        springs[name] = spring.begun(now) if last is None else now
    rings = {}
    for name, sides in system.rings.items():
        last_ring = SlipRingState() if last is None else last.slip_rings[name]
        differences = [
            states[sides[1].spring].force - states[sides[0].spring].force
            for states in (before, springs)
        ]
        lost = 0.0 if last is None else 0.5 * sum(differences) * slips[name]
        angle = _wrap_angle(sides, ends)
        rings[name] = SlipRingState(
            last_ring.slipped + slips[name], last_ring.friction + lost, angle
        )
    return SpringStates(springs, rings)


def _ring_slips(
    model: Model, before: Mapping[str, SpringState], ends: Mapping[str, Ends], moment: Moment
) -> dict[str, float]:
    """Return the length that slips in a step from the first segment of each ring to its second.

    Webbing slips until no tension is more than e^{μ θ} times the tension on the other side. Rings
    are solved one after the other, in sweeps, until no slip changes by more than `SLIP_TOL` of the
    longest segment.

    Raises
    ------
    RunError
        The sweeps do not converge.
    """
    system = model.mechanism
    lengths = {}
    for sides in system.rings.values():
        for name, _ in sides:
            lengths[name] = math.dist(*ends[name].places.tolist())
    size = max(lengths.values())
    ratios = {
        name: model.slip_rings[name].ratio(_wrap_angle(sides, ends))
        for name, sides in system.rings.items()
    }
    fed = dict.fromkeys(lengths, 0.0)
    slips = dict.fromkeys(system.rings, 0.0)

    def tension(segment: str, more: float) -> Response:
        spring = system.springs[segment]
        return spring.moved(before[segment], lengths[segment], fed[segment] + more, moment).axial

    for _ in range(MAX_SWEEPS):
        change = 0.0
        for name, (first, second) in system.rings.items():
            fed[first.spring] += slips[name]
            fed[second.spring] -= slips[name]
            slipped = slip(
                partial(tension, first.spring), partial(tension, second.spring), ratios[name]
            )
            fed[first.spring] -= slipped
            fed[second.spring] += slipped
            change = max(change, abs(slipped - slips[name]))
            slips[name] = slipped
        if len(system.rings) == 1 or change <= SLIP_TOL * size:
            return slips
    raise RunError(
        f"t = {moment.time:g}: the slip rings {', '.join(map(repr, slips))} do not settle: their "
        "segments differ too much in stiffness. Make the stiffest one softer"
    )


def _wrap_angle(sides: tuple[RingSide, RingSide], ends: Mapping[str, Ends]) -> float:
    """Return the wrap angle of the webbing between two segments, radians from 0 to π."""
    directions = []
    for name, end in sides:
        places = ends[name].places
        directions.append(places[1 - end] - places[end])
    a, b = directions
    # The angle is zero where the two directions are opposite.
    return float(np.arctan2(length(cross(a, b)), -float((a * b).sum())))


def add_pulls(
    system: Mechanism, springs: Mapping[str, SpringState], poses: FloatArray, total: FloatArray
) -> None:
    """Add the forces of springs to the wrenches `total` (n, 6) on bodies, in place.

    Wrenches are about the origins of the frames `poses` (n, 4, 4). Ends on slaves are left out.
    """
    for name, spring in springs.items():
        for k, end in enumerate(system.ends[name]):
            i = end.body
            if i is not None:
                pull = spring.pull if k == 0 else -1.0 * spring.pull
                total[i, :3] += pull
                total[i, 3:] += cross(spring.ends[k] - poses[i, :3, 3], pull)


def spring_columns(model: Model, state: SystemState) -> dict[str, float]:
    """Return the history columns of all springs and slip rings: ``<spring>.force`` and so on.

    Columns of devices are left out for springs without any.
    """
    columns: dict[str, float] = {}
    for name, spring in model.mechanism.springs.items():
        now, rate = state.springs[name], 0.0
        if now.length > 0.0:  # rate of elongation at the end of the step; the ground is at rest
            speeds = []
            for k, (i, slave, nodes, shares) in enumerate(model.mechanism.ends[name]):
                if slave is not None:
                    speeds.append(shares @ state.slaves[slave].velocities[nodes])
                else:
                    point = now.ends[k]
                    speeds.append(np.zeros(3) if i is None else point_velocity(state, i, point))
            axis = (now.ends[1] - now.ends[0]) / now.length
            rate = float(np.sum(axis * (speeds[1] - speeds[0])))
        values = (
            now.force,
            spring.elongation(now),
            rate,
            now.stored,
            now.hysteresis,
            now.damping,
        )
        columns |= {f"{name}.{c}": float(v) for c, v in zip(SPRING_COLUMNS, values, strict=True)}
        if any(spring.devices):
            devices = now.devices
            locked, released = (
                float(since <= state.time) for since in (devices.locked, devices.released)
            )
            of_devices = (
                devices.paid_out,
                devices.travel,
                devices.pulled_in,
                locked,
                released,
                devices.work,
            )
            columns |= {f"{name}.{c}": v for c, v in zip(DEVICE_COLUMNS, of_devices, strict=True)}
    for name, ring in state.slip_rings.items():
        columns |= {
            f"{name}.{c}": v
            for c, v in zip(
                SLIP_RING_COLUMNS, (ring.slipped, ring.angle, ring.friction), strict=True
            )
        }
    return columns


def spring_summary(model: Model, history: Mapping[str, FloatArray]) -> dict[str, dict[str, Any]]:
    """Return the bodies, points and filter of each spring for the summary, by name.

    Devices have the times of the first rows in which they are locked and released, or None.
    """
    springs: dict[str, dict[str, Any]] = {}
    for name, spring in model.springs.items():
        entry = {"between": list(spring.between), "at": spring.at.tolist(), "filter": spring.filter}
        if spring.devices.retractor is not None:
            entry["locked"] = first_time(history, f"{name}.locked")
        if spring.devices.release is not None:
            entry["released"] = first_time(history, f"{name}.released")
        springs[name] = entry
    return springs


def first_time(history: Mapping[str, FloatArray], column: str) -> float | None:
    """Return the time of the first row in which a column is not zero, or None."""
    rows = np.flatnonzero(history[column])
    return float(history["time"][rows[0]]) if len(rows) else None


def slip_ring_summary(model: Model) -> dict[str, dict[str, Any]]:
    """Return the segments and friction of slip rings for the summary, by name."""
    return {
        name: {"between": list(ring.between), "friction": ring.friction}
        for name, ring in model.slip_rings.items()
    }
