"""The example with two regions of contact."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import contiga as cg

EXAMPLE = Path(__file__).parents[3] / "examples" / "02_two_regions.toml"


def test_two_balls_touch_in_two_regions():
    history = cg.run(cg.load_case(EXAMPLE)).history
    peak = int(np.argmax(history["max_penetration"]))
    assert history["n_clusters"][peak] == 2
    # Discs of the sheet in balls of radius 20 pressed 4 deep.
    assert history["area"][peak] == pytest.approx(2 * np.pi * (20.0**2 - 16.0**2), rel=5e-3)
    # σ = 2 λ/20, F_z = 2/20 π d h² a ball.
    assert abs(history["force_z"][peak]) == pytest.approx(2 * 0.1 * np.pi * 16.0 * 4.0**2, rel=1e-2)
    assert history["max_pressure"][peak] == pytest.approx(0.1 * 4.0, rel=1e-3)
    assert history["centre_x"][peak] == pytest.approx(0.0, abs=1e-6)
    assert history["area"][0] == history["n_clusters"][0] == 0
