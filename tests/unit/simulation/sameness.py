"""Two runs that are to be the same bits."""

from __future__ import annotations

from dataclasses import fields as fields_of
from pathlib import Path

import numpy as np

from contiga.contact.state import State
from contiga.dynamics.nodes import SlaveState
from contiga.io.out.outlines import read_outlines
from contiga.io.out.vtkhdf import FieldSeries, read_fields
from contiga.simulation.system_state import BodyState, SystemState


def same_fields(a: FieldSeries, b: FieldSeries) -> None:
    np.testing.assert_array_equal(a.times, b.times)
    assert (a.names, [p.name for p in a.parts]) == (b.names, [p.name for p in b.parts])
    for k in range(len(a.times)):
        np.testing.assert_array_equal(a.points(k), b.points(k))
        for name in a.names:
            assert a.data(k, name).tobytes() == b.data(k, name).tobytes()


def same_states(a: SystemState, b: SystemState) -> None:
    assert (a.time, a.energy) == (b.time, b.energy)
    for kind in ("bodies", "slaves", "contacts"):
        assert list(getattr(a, kind)) == list(getattr(b, kind))
    for name, body in a.bodies.items():
        for one, other in zip(_flat(body), _flat(b.bodies[name]), strict=True):
            assert one.tobytes() == other.tobytes()
    for name, slave in a.slaves.items():
        for one, other in zip(_arrays(slave), _arrays(b.slaves[name]), strict=True):
            assert one.tobytes() == other.tobytes()
    for name, state in a.contacts.items():
        for field in fields_of(State):
            one, other = getattr(state, field.name), getattr(b.contacts[name], field.name)
            assert one.dtype == other.dtype
            assert one.tobytes() == other.tobytes()


def _arrays(slave: SlaveState) -> list[np.ndarray]:
    return [slave.points, slave.velocities, *(slave.matter[key] for key in sorted(slave.matter))]


def _flat(body: BodyState) -> tuple[np.ndarray, ...]:
    return (body.pose, *body.twist)


def same_output(path: Path) -> None:
    same_fields(*(read_fields(path / k / "fields.vtkhdf") for k in ("whole", "parts")))
    one, other = (read_outlines(path / k / "outlines.vtkhdf") for k in ("whole", "parts"))
    assert one.times.tobytes() == other.times.tobytes()
    for i in range(len(one.times)):
        for a, b in zip(one.loops(i), other.loops(i), strict=True):
            assert np.asarray(a).tobytes() == np.asarray(b).tobytes()


def same_history(a: dict[str, np.ndarray], b: dict[str, np.ndarray]) -> None:
    assert list(a) == list(b)
    for name in a:
        assert a[name].dtype == b[name].dtype
        if not name.endswith("wall_time"):
            assert a[name].tobytes() == b[name].tobytes(), name
