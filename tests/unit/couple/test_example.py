"""The arm that swings into a pad, on a coarse mesh."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("mujoco")

from examples import arm_into_pad


def test_the_hand_is_stopped_by_the_pad_and_the_energy_is_accounted_for() -> None:
    course = arm_into_pad.swing(mesh=0.012, step=5e-4, end=0.1)
    history = course.result.history
    peak = int(np.argmax(history["force"]))
    assert course.angles.shape == (len(history["time"]), 3)
    assert 300.0 < history["force"][peak] < 400.0
    # The wrist gives way, the shoulder turns on.
    assert course.angles[-1, 2] < -20.0 < 20.0 < course.angles[-1, 0]
    # Foam that takes most of what goes into it does not throw the hand back.
    assert history["energy.hysteresis"][-1] > 3.0 * history["energy.contact"].max()
    assert history["energy.friction"][-1] > 0.1 * history["energy.hysteresis"][-1]
    assert course.error < 0.01
