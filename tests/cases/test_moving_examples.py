"""The examples of bodies that move, whole: momentum, energy, and what a pulse does to a body."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import contiga as cg

EXAMPLES = Path(__file__).parents[2] / "examples"
pytestmark = pytest.mark.full


def of(history: dict[str, np.ndarray], name: str, letter: str) -> np.ndarray:
    return np.stack([history[f"{name}.{letter}{axis}"] for axis in "xyz"], axis=1)


def test_two_parts_keep_momentum_and_energy() -> None:
    case = cg.load_case(EXAMPLES / "03_two_parts.toml")
    masses = {
        name: part.motion.mass  # type: ignore[union-attr]
        for name, part in cg.build(case).bodies.items()
    }
    history = cg.run(case).history
    momentum = sum(m * of(history, name, "v") for name, m in masses.items())
    np.testing.assert_allclose(momentum - momentum[0], 0.0, atol=1e-10 * masses["ball"])
    assert history["n_contact"].max() > 10
    assert history["n_contact"][-1] == 0
    assert np.abs(history["energy.error"]).max() < 1e-3 * history["energy.total"][0]
    # The ring, hit off its centre, turns out of its plane.
    assert np.abs(history["ring.wx"][-1]) + np.abs(history["ring.wy"][-1]) > 0.01


def test_the_sled_stops_and_its_belt_holds_the_chest() -> None:
    result = cg.run(EXAMPLES / "04_sled.toml")
    history, energy = result.history, result.summary["energy"]
    # Both stand still in the end but for a few per cent of the speed, with what the sled has left.
    table = np.array([[0, 0], [10, 18], [20, 20], [60, 20], [75, 10], [90, 0]])
    change = np.trapezoid(table[:, 1], table[:, 0]) * 9.80665e-3
    sled = 13.9 - change
    assert abs(history["chest.vx"][-1] - sled) < 0.2 * 13.9
    assert energy["relative"] < 1e-3
    assert history["energy.hysteresis"][-1] > 0.1 * energy["most"]
    assert 20.0 < result.summary["sensors"]["chest_cg"]["criteria"]["3ms"]["value"] < 80.0
