"""Channels of a run: codes, units and times, from its history and summary."""

from __future__ import annotations

import numpy as np
import pytest

from contiga.errors import ContigaWarning, InputError
from contiga.simulation.iso_mme import channels_of

TIMES = np.linspace(0.0, 2.0, 5)
UNITS = {"length": "mm", "mass": "kg", "time": "ms"}
HISTORY = {
    "time": TIMES,
    "force": TIMES,
    "head.ax": 3.0 * TIMES,
    "head.a": 3.0 * TIMES,
    "head.filtered_ax": 2.0 * TIMES,
    "head.mz": TIMES,
    "head.qw": TIMES,
    "heads.x": TIMES,
    "neck.distance": TIMES,
    "neck.angle_y": TIMES,
    "belt.force": TIMES,
    "belt.energy_stored": TIMES,
}
SENSORS = {
    "head": {"filter": "CFC180", "code": "11HEAD0000H3"},
    "heads": {"filter": None},
    "neck": {"filter": None},
}
SUMMARY = {"units": UNITS, "sensors": SENSORS, "springs": {"belt": {"filter": None}}}


def test_codes_units_and_values() -> None:
    actual = {one.code: one for one in channels_of(HISTORY, SUMMARY)}
    scales = {  # from mm, kg and ms to SI
        "11HEAD0000H3ACX0": ("m/(s*s)", 3.0 * 1e-3 / 1e-6),
        "11HEAD0000H3ACR0": ("m/(s*s)", 3.0 * 1e-3 / 1e-6),
        "11HEAD0000H3ACXC": ("m/(s*s)", 2.0 * 1e-3 / 1e-6),
        "11HEAD0000H3MOZ0": ("Nm", 1e-6 / 1e-6),
        "10HEAD000000DSX0": ("m", 1e-3),
        "10NECK000000DS00": ("m", 1e-3),
        "10NECK000000ANY0": ("rad", 1.0),
        "10BELT000000FO00": ("N", 1e-3 / 1e-6),
    }
    assert set(actual) == set(scales)
    for code, (unit, scale) in scales.items():
        one = actual[code]
        assert one.unit == unit
        np.testing.assert_allclose(one.values, scale * TIMES, rtol=1e-13)
        assert (one.start, one.interval) == (0.0, pytest.approx(5e-4))
    assert actual["11HEAD0000H3ACXC"].filter == "180"


def test_names_that_begin_alike_have_codes_of_their_own() -> None:
    history = {"time": TIMES} | {f"{name}.x": TIMES for name in ("head_cg", "head_top", "b")}
    sensors = {name: {"filter": None} for name in ("head_cg", "head_top", "b")}
    codes = [one.code for one in channels_of(history, {"units": UNITS, "sensors": sensors})]
    assert codes == ["10HEAD000000DSX0", "10HEAD010000DSX0", "10B000000000DSX0"]


def test_codes_made_of_names_are_as_many_as_wanted_and_leave_those_given() -> None:
    names = [f"head_{k}" for k in range(250)]
    sensors = {name: {"filter": None} for name in names} | {
        "own": {"filter": None, "code": "10HEAD000000"}
    }
    history = {"time": TIMES} | {f"{name}.x": TIMES for name in sensors}
    result = channels_of(history, {"units": UNITS, "sensors": sensors})
    codes = {one.name: one.code for one in result}
    assert len(set(codes.values())) == 251
    assert {len(code) for code in codes.values()} == {16}
    assert (codes["own x"], codes["head_0 x"]) == ("10HEAD000000DSX0", "10HEAD010000DSX0")
    assert codes["head_99 x"] == "10HEAD000001DSX0"


def test_steps_that_differ_are_made_even() -> None:
    times = np.array([0.0, 0.1, 0.2, 0.25, 0.4, 0.5])
    sensors = {"units": UNITS, "sensors": {"head": {"filter": None}}}
    (one,) = channels_of({"time": times, "head.x": 7.0 * times}, sensors)
    assert one.interval == pytest.approx(5e-5)
    np.testing.assert_allclose(one.values, 7e-3 * np.linspace(0.0, 0.5, 11), atol=1e-15)


@pytest.mark.parametrize("column", ["ax", "fz", "my", "filtered_a"])
def test_a_pulse_shorter_than_most_steps_is_not_lost(column: str) -> None:
    """149 steps of 1 ms, and 20 of 0.05 ms through half a sine of 1 ms amid them."""
    times = np.cumsum([0.0] + [1.0] * 75 + [0.05] * 20 + [1.0] * 74)
    pulse = np.where(np.abs(times - 75.5) < 0.5, np.sin(np.pi * (times - 75.0)), 0.0)
    sensors = {"head": {"filter": "CFC1000" if "filtered" in column else None}}
    summary = {"units": {"length": "m", "mass": "kg", "time": "ms"}, "sensors": sensors}
    (one,) = channels_of({"time": times, f"head.{column}": pulse}, summary)
    unit = 1e6  # 1/ms² in SI
    integral = np.trapezoid(one.values, dx=one.interval)
    assert integral == pytest.approx(unit * 1e-3 * np.trapezoid(pulse, times), rel=1e-9)
    assert integral == pytest.approx(unit * 1e-3 * 2.0 / np.pi, rel=5e-3)
    assert one.values.max() == pytest.approx(unit, rel=1e-2)
    assert len(one.values) < 3100


def test_columns_that_are_not_finite_are_left_out_and_told() -> None:
    sensors = {"units": UNITS, "sensors": {"head": {"filter": None}}}
    history = {"time": TIMES, "head.x": np.nan * TIMES, "head.y": TIMES}
    with pytest.warns(ContigaWarning, match="left out, as they are not finite: head.x"):
        actual = channels_of(history, sensors)
    assert [one.code[-4:] for one in actual] == ["DSY0"]


def test_joints_have_channels_of_their_reactions_coordinates_and_laws() -> None:
    joints = {"units": UNITS, "joints": {"knee": {"kind": "cylindrical"}, "neck": {}, "hip": {}}}
    columns = {
        "knee.fx": ("FOX", 1e3), "knee.mz": ("MOZ", 1.0), "knee.angle": ("AN0", 1.0),
        "knee.angle_force": ("MO0", 1.0), "knee.travel": ("DS0", 1e-3),
        "knee.travel_force": ("FO0", 1e3), "neck.cone": ("AN1", 1.0), "neck.twist": ("AN2", 1.0),
        "neck.twist_force": ("MO2", 1.0), "hip.angle_1": ("AN1", 1.0),
        "hip.angle_2_force": ("MO2", 1.0),
    }  # fmt: skip
    history = {"time": TIMES} | dict.fromkeys(columns, TIMES)
    history |= {"knee.angle_energy_stored": TIMES}
    channels = {one.name: one for one in channels_of(history, joints)}
    assert len({one.code for one in channels.values()}) == len(channels) == len(columns)
    for name, (code, factor) in columns.items():
        one = channels[name.replace(".", " ")]
        assert one.code[-4:] == f"{code}0", name
        assert one.values[-1] == pytest.approx(factor * TIMES[-1]), name


@pytest.mark.parametrize(
    ("summary", "message"),
    [
        ({"sensors": SENSORS}, "the run has no units"),
        ({"units": UNITS | {"mass": ""}, "sensors": SENSORS}, "the run has no units"),
        ({"units": UNITS}, "no sensors, springs or joints"),
    ],
)
def test_runs_without_channels_are_refused(summary, message: str) -> None:
    with pytest.raises(InputError, match=message):
        channels_of(HISTORY, summary)
