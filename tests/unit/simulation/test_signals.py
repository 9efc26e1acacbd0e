"""Filtered signals have the integral of what was filtered, whatever the steps."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

import contiga as cg
from contiga.simulation.signals import filtered_columns

UNITS = ("mm", "g", "ms")


def struck(stiffness: float, measures: tuple[str, ...], axes: str = "world") -> cg.Result:
    """A ball of 100 g at 1 m/s rebounds from a point, in steps that choose themselves."""
    ball = cg.Body([cg.shapes.sphere(radius=10.0)])
    point = cg.Slave([[0.0, 0.0, -15.013]], area=[1.0])
    motion = cg.motion.Free(
        mass=100.0, inertia=np.eye(3) * 4000.0, centre=[0, 0, 0], velocity=[0, 0, -1.0]
    )
    options = {"measures": measures, "filter": "CFC1000", "criteria": ["HIC15"], "axes": axes}
    return cg.Simulation(
        bodies={"ball": (ball, motion)},
        slaves={"point": point},
        contacts=[cg.Contact(ball, point, law=cg.PenaltyLaw(stiffness))],
        end=10.0,
        step="auto",
        units=UNITS,
        sensors=[cg.Sensor("cg", "ball", **options)],  # type: ignore[arg-type]
    ).run()


@pytest.mark.parametrize("measures", [("acceleration", "velocity"), ("acceleration",)])
@pytest.mark.parametrize("axes", ["world", "body"])
def test_a_contact_far_shorter_than_the_filter_is_not_lost(
    measures: tuple[str, ...], axes: str
) -> None:
    """Of 0.0031 ms: samples of the filter are 0.0125 ms apart, and the largest steps 0.1 ms."""
    result = struck(1e8, measures, axes)
    h, half = result.history, np.pi * np.sqrt(100.0 / 1e8)
    change = np.ptp(h["ball.vz"][[0, -1]])
    assert change == pytest.approx(2.0, rel=1e-3)
    assert np.trapezoid(h["cg.filtered_az"], h["time"]) == pytest.approx(change, rel=1e-9)
    # The pulse is half a sine: 2 v ω / 2 high. Filtered on a grid that resolves it.
    dt = half / 20.0
    pulse = np.sin(np.pi * (np.arange(int(6.0 / dt)) * dt - 3.0) / half)
    inside = np.abs(np.arange(len(pulse)) * dt - 3.0 - 0.5 * half) < 0.5 * half
    truth = np.abs(cg.criteria.cfc(np.where(inside, np.pi / half * pulse, 0.0), dt * 1e-3, 1000))
    assert h["cg.filtered_a"].max() == pytest.approx(truth.max(), rel=0.02)
    hic = cg.criteria.hic(truth[::8] / 9.80665e-3, 8e-3 * dt * np.arange(len(truth[::8])), 0.015)
    actual = result.summary["sensors"]["cg"]["criteria"]["HIC15"]["value"]
    assert actual == pytest.approx(hic.value, rel=0.01)


def test_an_even_grid_of_as_many_points_is_another_one() -> None:
    """Steps of h/2, h and 3 h/2: as many as even ones of h."""
    n, h = 1000, 2.0**-7
    times = np.concatenate([[0.0], np.cumsum([0.5 * h] * n + [h] + [1.5 * h] * n)])
    force = np.sin(2.0 * np.pi * times / 20.0)  # 50 Hz
    spring = SimpleNamespace(filter="CFC1000")
    model = SimpleNamespace(point_sensors=(), springs={"s": spring}, units=UNITS)
    actual = filtered_columns(model, {"time": times, "s.force": force})  # type: ignore[arg-type]
    inside = (times > 1.0) & (times < times[-1] - 1.0)
    assert np.abs(actual["s.filtered_force"] - force)[inside].max() < 1e-2
