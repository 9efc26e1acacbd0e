"""The force law by its curve: resultants as vectors, and the energy of a head that rebounds."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from tests.scenes import square_sheet

import contiga as cg

CURVE = [[0.0, 0.0], [10.0, 3.0], [60.0, 5.0], [90.0, 12.0]]
RADIUS = 82.5
pose = cg.motion.pose


@pytest.mark.parametrize("spacing", [20.0, 10.0, 3.0])
@pytest.mark.parametrize(("depth", "force"), [(30.0, 3.8), (60.0, 5.0)])
def test_a_sphere_pressed_into_a_pad_feels_what_the_curve_says(spacing, depth, force) -> None:
    pad = cg.Slave(*square_sheet(240.0, round(240.0 / spacing) + 1))
    ball = cg.Body([cg.shapes.sphere(radius=RADIUS)])
    contact = cg.Contact(ball, pad, law=cg.ForceLaw(CURVE))
    x, y = 0.013, 0.007
    state = contact.start(pad.points, pose.translation([x, y, RADIUS + 1.0]))
    state = contact.step(state, pad.points, pose.translation([x, y, RADIUS - depth]))
    assert np.linalg.norm(state.total_force) == pytest.approx(force, rel=0.01)
    assert np.linalg.norm(state.wrench[:3]) == pytest.approx(force, rel=0.01)


HEAD = """
units = {{ length = "mm", mass = "kg", time = "ms" }}
time = {{ end = 20.0, step = {step} }}
[[body]]
name = "head"
geometry = {{ shape = "sphere", radius = 82.5, centre = [0, 0, 84] }}
mass = {{ total = 4.5 }}
motion = {{ kind = "free", velocity = [4.7, 0, -10.07] }}
[[slave]]
name = "pad"
points = {{ grid = {{ shape = "plane", width = 400, length = 400, nu = 27, nv = 27 }} }}
[[contact]]
master = "head"
slave = "pad"
law = {{ kind = "force", curve = [[0, 0], [10, 3], [60, 5], [90, 12]], \
unloading = [[0, 0], [60, 0.5], [90, 3]], hysteresis_slope = 2.0 }}
friction = {{ kind = "coulomb", static = 0.3 }}
[output]
formats = []
report = false
"""


def test_the_energy_of_an_oblique_head_balances(tmp_path: Path) -> None:
    errors = []
    for step in (0.12, 0.04):
        case = tmp_path / "head.toml"
        case.write_text(HEAD.format(step=step))
        history = cg.run(cg.load_case(case)).history
        errors.append(float(np.abs(history["energy.error"]).max() / history["energy.total"][0]))
    assert history["head.vz"][-1] > 1.0, "it has come back"
    assert errors[-1] < 2e-4
    assert errors[-1] < errors[0] / 4.0, "of second order in the step"
