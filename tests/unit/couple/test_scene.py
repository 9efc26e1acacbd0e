"""Sensors in a coupled run, and masters that touch nothing."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import contiga as cg
from contiga.couple import MujocoCoupling
from contiga.errors import InputError

mujoco = pytest.importorskip("mujoco")

ARM, STEP, OMEGA = 0.5, 0.001, 2.0
BALL = cg.Body([cg.shapes.sphere(radius=0.1, centre=(ARM, 0.0, 0.0))])
POINT = cg.Slave([[9.0, 0.0, 0.0]], area=[1.0])
CONTACT = cg.Contact(BALL, POINT, law=cg.PenaltyLaw(1.0))
UNITS = ("m", "kg", "s")


def swung(sensors: list[Any], **given: Any) -> MujocoCoupling:
    """A ball on an arm that turns about z at an even speed, past a post."""
    model = mujoco.MjModel.from_xml_string(
        f"""<mujoco><option gravity="0 0 0" timestep="{STEP}"/><worldbody>
        <body name="arm"><joint axis="0 0 1"/>
          <inertial pos="{ARM} 0 0" mass="1" diaginertia="1 1 1"/></body>
        <body name="post" pos="0 0 1"/></worldbody></mujoco>"""
    )
    data = mujoco.MjData(model)
    data.qvel[0] = OMEGA
    options = {
        "masters": {"arm": BALL, "post": cg.Body([cg.shapes.sphere(radius=0.2)])},
        "slaves": {"far": (POINT, "world")},
        "contacts": [CONTACT],
        **given,
    }
    return MujocoCoupling(model, data, sensors=sensors, **options)


def test_a_sensor_on_a_turning_arm() -> None:
    """On a circle: v = ω r, a = ω² r to the middle, in the world's and in the body's axes."""
    sensors = [
        cg.Sensor("tip", "arm", at=(0.6, 0.0, 0.0)),
        cg.Sensor("own", "arm", at=(0.6, 0.0, 0.0), axes="body", measures=["acceleration"]),
        cg.Sensor("centre", "arm", measures=["velocity"]),
    ]
    result = swung(sensors).run(0.3)
    tip, angle = result.of("tip"), OMEGA * result.history["time"]
    np.testing.assert_allclose(tip["v"], OMEGA * 0.6, rtol=1e-9)
    np.testing.assert_allclose(tip["ax"], -(OMEGA**2) * 0.6 * np.cos(angle), atol=1e-9)
    np.testing.assert_allclose(tip["x"], 0.6 * (np.cos(angle) - 1.0), atol=1e-9)
    np.testing.assert_allclose(result.of("own")["ax"], -(OMEGA**2) * 0.6, rtol=1e-9)
    np.testing.assert_allclose(result.of("centre")["v"], OMEGA * ARM, rtol=1e-9)


def test_a_sensor_between_the_arm_and_a_master_without_contact() -> None:
    result = swung([cg.RelativeSensor("gap", ["post", "arm"])]).run(0.3)
    gap = result.of("gap")
    np.testing.assert_allclose(gap["distance"], np.hypot(1.0, ARM), rtol=1e-12)
    np.testing.assert_allclose(gap["angle_z"], OMEGA * result.history["time"], atol=1e-9)
    np.testing.assert_allclose(gap["rate"], 0.0, atol=1e-12)


def test_criteria_and_filters_of_a_coupled_run() -> None:
    sensor = cg.Sensor("head", "arm", filter="CFC60", criteria=["HIC15", "3ms"])
    coupling = swung([sensor], units=UNITS)
    result = coupling.run(0.3)
    held = OMEGA**2 * ARM / 9.80665
    told = result.criteria["head"]["criteria"]
    assert told["3ms"]["value"] == pytest.approx(held, rel=1e-3)
    assert told["HIC15"]["value"] == pytest.approx(0.015 * held**2.5, rel=1e-3)
    assert "filtered_a" in result.of("head")


def test_the_spin_has_the_columns_of_other_runs() -> None:
    measures = ["acceleration", "velocity", "spin"]
    tip = swung([cg.Sensor("tip", "arm", measures=measures)]).run(0.01).of("tip")
    assert sorted(tip) == sorted(["a", "ax", "ay", "az", "v", "vx", "vy", "vz", "wx", "wy", "wz"])
    np.testing.assert_allclose(tip["wz"], OMEGA, rtol=1e-9)


def test_columns_by_name() -> None:
    result = swung([]).run(0.01)
    np.testing.assert_array_equal(result.of("arm")["wz"], result.history["arm.wz"])
    np.testing.assert_array_equal(result.of("arm-far")["force"], result.history["force"])
    np.testing.assert_array_equal(result.of("energy")["kinetic"], result.history["energy.kinetic"])
    with pytest.raises(InputError, match=r"nothing of this name; found 'leg'.*'arm'"):
        result.of("leg")


@pytest.mark.parametrize(
    ("sensors", "message"),
    [
        ([cg.Sensor("tip", "leg")], "names a body that is not there; found 'leg'"),
        ([cg.RelativeSensor("gap", ["arm", "leg"])], "names a body that is not there"),
        (
            [cg.RelativeSensor("gap", ["post", "arm"], measures=["acceleration"])],
            "'gap': measures: the acceleration between two bodies",
        ),
        ([cg.Sensor("arm", "arm")], "name of its own"),
        ([cg.Sensor("tip", "arm", filter="CFC60")], "need units"),
        ([cg.Sensor("tip", "arm", measures=["force"])], "measures: what acts on a body of MuJoCo"),
    ],
)
def test_wrong_sensors_are_told_at_once(sensors: list[Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        swung(sensors)
