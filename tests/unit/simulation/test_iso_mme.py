"""Channels of a run: codes, units and times, from its history and summary."""

from __future__ import annotations

import numpy as np
import pytest

from contiga.errors import InputError
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
    found = {one.code: one for one in channels_of(HISTORY, SUMMARY)}
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
    assert set(found) == set(scales)
    for code, (unit, scale) in scales.items():
        one = found[code]
        assert one.unit == unit
        np.testing.assert_allclose(one.values, scale * TIMES, rtol=1e-13)
        assert (one.start, one.interval) == (0.0, pytest.approx(5e-4))
    assert found["11HEAD0000H3ACXC"].filter == "180"


def test_names_that_begin_alike_have_codes_of_their_own() -> None:
    history = {"time": TIMES} | {f"{name}.x": TIMES for name in ("head_cg", "head_top", "b")}
    sensors = {name: {"filter": None} for name in ("head_cg", "head_top", "b")}
    codes = [one.code for one in channels_of(history, {"units": UNITS, "sensors": sensors})]
    assert codes == ["10HEAD000000DSX0", "10HEAD010000DSX0", "10B000000000DSX0"]


def test_steps_that_differ_are_made_even() -> None:
    times = np.array([0.0, 0.1, 0.2, 0.25, 0.4, 0.5])
    sensors = {"units": UNITS, "sensors": {"head": {"filter": None}}}
    (one,) = channels_of({"time": times, "head.x": 7.0 * times}, sensors)
    assert one.interval == pytest.approx(1e-4)
    np.testing.assert_allclose(one.values, 7e-3 * np.linspace(0.0, 0.5, 6), rtol=1e-12)


def test_columns_that_are_not_finite_are_left_out() -> None:
    sensors = {"units": UNITS, "sensors": {"head": {"filter": None}}}
    history = {"time": TIMES, "head.x": np.nan * TIMES, "head.y": TIMES}
    assert [one.code[-4:] for one in channels_of(history, sensors)] == ["DSY0"]


@pytest.mark.parametrize(
    ("summary", "message"),
    [
        ({"sensors": SENSORS}, "the run has no units"),
        ({"units": UNITS | {"mass": ""}, "sensors": SENSORS}, "the run has no units"),
        ({"units": UNITS}, "no sensors and no springs"),
    ],
)
def test_runs_without_channels_are_refused(summary, message: str) -> None:
    with pytest.raises(InputError, match=message):
        channels_of(HISTORY, summary)
