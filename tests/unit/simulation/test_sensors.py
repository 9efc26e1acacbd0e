"""Sensors: how points of bodies move, against closed forms and differences of positions."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg
from contiga.errors import InputError

INERTIA = np.array([[1.0, 0.2, 0.1], [0.2, 2.0, 0.3], [0.1, 0.3, 2.5]])
AT = (1.0, -2.0, 0.5)


def flight(motion: object, sensors: list[cg.Sensor], **options: object) -> cg.Result:
    """A body that touches nothing."""
    ball = cg.Body([cg.shapes.sphere(radius=1.0)])
    far = cg.Slave([[0.0, 0.0, 500.0]], area=[1.0])
    arguments: dict[str, object] = {"end": 2.0, "step": 0.001} | options
    return cg.Simulation(
        bodies={"ball": (ball, motion)},
        slaves={"far": far},
        contacts=[cg.Contact(ball, far, law=cg.PenaltyLaw(1.0))],
        sensors=sensors,
        **arguments,  # type: ignore[arg-type]
    ).run()


def columns(history: dict[str, np.ndarray], name: str) -> np.ndarray:
    return np.stack([history[f"{name}{axis}"] for axis in "xyz"], axis=1)


@pytest.mark.parametrize("hold", [(), ("rz",), ("rx", "ry")])
def test_a_point_of_a_free_body_moves_as_it_says(hold: tuple[str, ...]) -> None:
    spin = [
        0.0 if axis in hold else w
        for axis, w in zip(("rx", "ry", "rz"), (0.5, 0.9, 0.4), strict=True)
    ]
    motion = cg.motion.Free(
        2.0, inertia=INERTIA, centre=(0.1, 0.2, 0.3), velocity=(0, 0, 1.0), spin=spin, hold=hold
    )
    push = cg.Load("ball", force=(0.0, 0.4, 0.0), at=(0.5, 0.0, 0.0))
    history = flight(motion, [cg.Sensor("chin", "ball", at=AT)], loads=[push], end=0.3).history
    place, velocity = columns(history, "chin."), columns(history, "chin.v")
    acceleration = columns(history, "chin.a")
    assert place[0].tolist() == [0.0, 0.0, 0.0]
    h = 0.001
    np.testing.assert_allclose(
        (place[2:] - place[:-2]) / (2 * h), velocity[1:-1], rtol=0.0, atol=2e-6
    )
    np.testing.assert_allclose(
        (velocity[2:] - velocity[:-2]) / (2 * h), acceleration[1:-1], rtol=0.0, atol=2e-6
    )
    np.testing.assert_allclose(history["chin.a"], np.linalg.norm(acceleration, axis=1))


def test_axes_of_the_body_turn_with_it() -> None:
    motion = cg.motion.Free(1.0, inertia=np.eye(3), spin=(0.0, 0.0, 0.7))
    pair = [cg.Sensor("world", "ball", at=AT), cg.Sensor("own", "ball", at=AT, axes="body")]
    history = flight(motion, pair, step=0.05).history
    # An even turn: the same centripetal acceleration at all times.
    np.testing.assert_allclose(
        columns(history, "own.a"), np.tile([-0.49, 0.98, 0.0], (41, 1)), atol=1e-13
    )
    np.testing.assert_allclose(history["own.a"], history["world.a"], rtol=1e-13)


OWN_AXES = np.array([[0.0, 0.6, 0.8], [1.0, 0.0, 0.0], [0.0, 0.8, -0.6]])


def test_axes_of_a_sensor_turn_with_its_body() -> None:
    motion = cg.motion.Free(2.0, inertia=INERTIA, centre=(0.1, 0.2, 0.3), spin=(0.5, 0.9, 0.4))
    every = ["acceleration", "velocity", "displacement", "spin"]
    pair = [
        cg.Sensor("body", "ball", at=AT, axes="body", measures=every),
        cg.Sensor("own", "ball", at=AT, axes=OWN_AXES, measures=every),
    ]
    history = flight(motion, pair, step=0.05).history
    for prefix in ("a", "v", "", "w"):
        body, own = (columns(history, f"{name}.{prefix}") for name in ("body", "own"))
        np.testing.assert_allclose(own, body @ OWN_AXES.T, atol=1e-13)
    assert abs(columns(history, "own.w")).max() > 0.3


@pytest.mark.parametrize(
    ("axes", "words"),
    [
        ("head", "world"),
        (2 * OWN_AXES, "unit vectors at right angles"),
        (OWN_AXES[:2], "unit vectors at right angles"),
        (-OWN_AXES, "right-handed"),
    ],
)
def test_axes_that_are_none_are_refused(axes: object, words: str) -> None:
    for make in (
        lambda: cg.Sensor("own", "ball", axes=axes),  # type: ignore[arg-type]
        lambda: cg.RelativeSensor("own", ("ball", "pad"), axes=axes),  # type: ignore[arg-type]
    ):
        with pytest.raises(InputError, match=words):
            make()


def test_forces_and_moments_are_those_on_the_body() -> None:
    motion = cg.motion.Free(2.0, inertia=np.eye(3), hold=["rx", "ry", "rz"])
    sensor = cg.Sensor("cell", "ball", at=(0.0, 0.0, 1.0), measures=["force", "moment"])
    push = cg.Load("ball", force=(3.0, 0.0, 0.0), at=(0.0, 0.0, 2.0))
    history = flight(motion, [sensor], loads=[push], gravity=(0, 0, -1.0), step=0.1).history
    np.testing.assert_allclose(columns(history, "cell.f"), np.tile([3.0, 0.0, -2.0], (21, 1)))
    np.testing.assert_allclose(columns(history, "cell.m"), np.tile([0.0, 3.0, 0.0], (21, 1)))


def test_a_prescribed_body_tells_its_pulse() -> None:
    pulse = cg.motion.Accelerated([[0.0, 0.0], [1.0, 4.0], [2.0, 0.0]], direction="x")
    history = flight(pulse, [cg.Sensor("sled", "ball")], step=0.1).history
    times = history["time"]
    np.testing.assert_allclose(history["sled.ax"], 4.0 - 4.0 * np.abs(times - 1.0), atol=1e-12)
    moved = cg.motion.Translate([[0.0, 0, 0, 0], [1.0, 2.0, 0, 0], [2.0, 2.0, 0, 0]])
    history = flight(moved, [cg.Sensor("sled", "ball")], step=0.25).history
    assert history["sled.ax"].tolist() == [0.0, 0.0, 0.0, 0.0, -8.0, 0.0, 0.0, 0.0, 0.0]


def test_a_half_sine_gives_its_hic() -> None:
    """Filtered by the class of 1000 Hz a pulse of 20 ms keeps its criteria to a per mille."""
    g, peak = 9.80665e-3, 80.0
    times = np.linspace(0.0, 30.0, 601)
    pulse = np.where(times < 20.0, peak * g * np.sin(np.pi * times / 20.0), 0.0)
    motion = cg.motion.Accelerated(np.stack([times, pulse], axis=1), direction="x")
    bands = {"HIC15": cg.criteria.Bands([0.1, 1e5], ["low", "middle", "high"])}
    asked = ["HIC15", "HICd", "3ms"]
    sensor = cg.Sensor("head", "ball", filter="CFC1000", criteria=asked, bands=bands)
    units = {"end": 30.0, "step": 0.05, "units": ("mm", "g", "ms")}
    result = flight(motion, [sensor], **units)
    told = result.summary["sensors"]["head"]["criteria"]
    a, t = peak * np.sin(np.pi * times / 20.0) * (times < 20.0), times / 1000.0
    assert told["HIC15"]["value"] == pytest.approx(cg.criteria.hic(a, t).value, rel=1e-3)
    assert told["3ms"]["value"] == pytest.approx(cg.criteria.clip(a, t).value, rel=1e-3)
    assert told["HICd"]["value"] == pytest.approx(
        cg.criteria.hicd(cg.criteria.hic(a, t, 0.036).value), rel=1e-3
    )
    assert (told["HIC15"]["band"], "band" in told["3ms"]) == ("middle", False)
    assert told["HIC15"]["start"] < 10.0 < told["HIC15"]["end"]
    assert np.abs(result.history["head.filtered_a"] - result.history["head.a"]).max() < 0.02


def test_steps_that_choose_themselves_are_short_enough_for_the_filter() -> None:
    pulse = [[0.0, 0.0], [20.0, 0.4], [40.0, 0.0]]
    sensor = cg.Sensor("head", "ball", filter="CFC1000", criteria=["HIC15"])
    own = {"end": 40.0, "step": "auto", "units": ("mm", "g", "ms")}
    result = flight(cg.motion.Accelerated(pulse, direction="x"), [sensor], **own)
    assert np.diff(result.history["time"]).max() <= 0.1 * (1.0 + 1e-9)
    assert "HIC15" in result.summary["sensors"]["head"]["criteria"]
    coarse = flight(cg.motion.Accelerated(pulse, direction="x"), [sensor], **(own | {"step": 0.5}))
    assert coarse.summary["sensors"]["head"]["criteria"] == {}
    assert any("too long for CFC1000" in text for text in coarse.summary["warnings"])


@pytest.mark.parametrize(
    ("options", "match"),
    [
        ({"axes": "moon"}, "axes.*'world', 'body'"),
        ({"measures": ["speed"]}, "measures"),
        ({"filter": "CFC500"}, "filter"),
        ({"criteria": ["GSI"]}, "criteria"),
        ({"criteria": ["HIC15"], "measures": ["force"]}, "does not measure"),
        ({"bands": {"HIC15": cg.criteria.Bands([1], "ab")}, "criteria": ["3ms"]}, "bands"),
        ({"code": "11HEAD"}, "code: is not the start of a channel's code"),
    ],
)
def test_wrong_sensors_are_told(options: dict[str, object], match: str) -> None:
    with pytest.raises(InputError, match=match):
        cg.Sensor("head", "ball", **options)  # type: ignore[arg-type]


def test_names_of_sensors_are_columns() -> None:
    with pytest.raises(InputError, match="name of its own"):
        flight(cg.motion.Free(1.0, inertia=np.eye(3)), [cg.Sensor("ball", "ball")])
    with pytest.raises(InputError, match="names a body that is not there"):
        flight(cg.motion.Free(1.0, inertia=np.eye(3)), [cg.Sensor("cg", "head")])
