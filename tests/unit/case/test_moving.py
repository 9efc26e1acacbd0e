"""Keys of bodies that move by forces: what they make, and what is told of wrong ones."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import contiga as cg
from contiga.case.build import build
from contiga.case.describe import description
from contiga.case.schema import parse_case
from contiga.case.toml import resolved_toml
from contiga.dynamics.stepping import AutoSteps
from contiga.errors import InputError

CASE = """
title = "A ball on a sled"
units = { length = "mm", mass = "g", time = "ms" }
time = { end = 10.0, step = "auto", safety = 0.8, largest = 0.5 }
world = { gravity = [0.0, 0.0, -9.81e-3] }
[[body]]
name = "ball"
geometry = { shape = "sphere", radius = 20.0, centre = [0, 0, 21] }
mass = { density = 1.0e-3 }
motion = { kind = "free", velocity = [0, 0, -3.0], spin = [0.1, 0, 0], hold = ["x"] }
[[body]]
name = "cap"
geometry = { shape = "sphere", radius = 5.0, centre = [0, 0, 45] }
mass = { total = 10.0 }
motion = { kind = "attached", body = "ball" }
[[body]]
name = "sled"
geometry = { shape = "plane", width = 90.0, length = 90.0, centre = [0, 0, -50] }
motion = { kind = "acceleration", table = [[0, 2.0], [10, 0.0]], unit = "g", direction = "x" }
[[slave]]
name = "foam"
points = { grid = { shape = "plane", width = 80, length = 80, nu = 9, nv = 9 } }
motion = { kind = "attached", body = "sled" }
[[slave]]
name = "skin"
points = { body = "cap", tolerance = 0.5 }
[[slave]]
name = "dust"
points = { coordinates = [[0, 0, 200], [1, 0, 200]] }
motion = { kind = "free", velocity = [0, 0, 1.0] }
mass = 0.5
area = 1.0
[[load]]
body = "ball"
force = [[0, 0, 1.0, 0], [10, 0, 0, 0]]
[[spring]]
between = ["ball", "ground"]
at = [[0, 0, 21], [0, 0, 100]]
curve = 2.0
[[sensor]]
name = "cg"
body = "ball"
filter = "CFC1000"
criteria = ["HIC15"]
[[contact]]
name = "fall"
master = "ball"
slave = "foam"
law = { kind = "stress", elastic = 1.0, thickness = 20.0 }
[[contact]]
name = "cloud"
master = "ball"
slave = "dust"
law = { kind = "penalty", stiffness = 1.0 }
"""


def test_a_case_says_what_moves() -> None:
    simulation = build(parse_case(CASE))
    assert isinstance(simulation.stepping, AutoSteps)
    assert (simulation.stepping.safety, simulation.stepping.most) == (0.8, 0.5)
    np.testing.assert_array_equal(simulation.gravity, [0.0, 0.0, -9.81e-3])
    free = simulation.bodies["ball"].motion
    assert isinstance(free, cg.motion.Free)
    assert free.mass == pytest.approx(4.0 / 3.0 * np.pi * 8.0, rel=1e-9)
    assert free.hold == ("x",)
    cap = simulation.bodies["cap"].motion
    assert isinstance(cap, cg.motion.Attached)
    assert cap.mass is not None
    assert cap.mass.mass == pytest.approx(10.0)
    system = simulation.mechanism
    assert system.fixed[0, 0] == pytest.approx(free.mass + 10.0)
    assert system.carrier_of_slave == {"foam": 2, "skin": 0}
    np.testing.assert_array_equal(system.masses["dust"], [0.5, 0.5])
    assert list(system.springs) == ["ball-ground"]
    sled = simulation.bodies["sled"].motion
    assert sled.acceleration(0.0).tolist() == pytest.approx([2.0 * 9.80665e-3, 0.0, 0.0])
    assert [sensor.name for sensor in simulation.sensors] == ["cg"]
    assert len(simulation.loads) == 1


def test_its_resolved_copy_is_the_same_case() -> None:
    case = parse_case(CASE)
    again = parse_case(resolved_toml(case))
    assert again == case
    assert build(again).fingerprint() == build(case).fingerprint()


def test_it_is_told_in_words() -> None:
    text = description(parse_case(CASE))
    for words in (
        "automatic steps of at most 0.5",
        "its volume at a density of 0.001",
        "free, velocity [0.0, 0.0, -3.0] at the start, spin",
        "attached to sled",
        "the surface of cap, sampled to 0.5",
        "spring ball-ground",
        "CFC1000, HIC15",
    ):
        assert words in text


def test_a_run_of_it_closes_its_energy() -> None:
    history = build(parse_case(CASE)).run().history
    assert history["energy.friction"][-1] == 0.0
    total = np.abs(history["energy.total"]).max()
    assert np.abs(history["energy.error"]).max() < 1e-3 * total
    assert "ball.x" in history
    assert "cg.filtered_a" in history


@pytest.mark.parametrize(
    ("old", "new", "match"),
    [
        ('step = "auto"', 'step = "aut"', "time.step.*must be a number, or.*Did you mean 'auto'"),
        ('step = "auto"', "step = -1.0", "time.step.*too small"),
        ('step = "auto", safety = 0.8', "step = 0.1", "largest.*is for step"),
        (
            'step = "auto", safety = 0.8, largest = 0.5',
            "step = 0.1, shortest = 0.01",
            "shortest.*is for step",
        ),
        ("safety = 0.8", "safety = 1.8", r"safety: must be in \(0, 1\]"),
        ('mass = { density = 1.0e-3 }\n', "", r"body\[0\].mass.*a free body needs its mass"),
        ("density = 1.0e-3", "density = -1.0", r"body\[0\].mass.density"),
        ("{ total = 10.0 }", "{ total = 10.0, inertia = [1, 1, 9, 0, 0, 0] }", "larger than the"),
        ('hold = ["x"]', 'hold = ["up"]', "nothing of this name can be held"),
        ('hold = ["x"]', 'hold = ["z"]', "is held, and starts moving"),
        ('kind = "attached", body = "sled"', 'kind = "attached", body = "slad"', "no body of this"),
        ("[10, 0.0]]", "[9, 0.0]]", "stops at 9, and the run needs it up to 10"),
        ('unit = "g"', 'unit = "furlong"', "unit of acceleration"),
        ('body = "ball"\nforce', 'body = "bull"\nforce', r"load\[0\].body.*no body"),
        ('between = ["ball", "ground"]', 'between = ["ground", "ground"]', "ground"),
        ('between = ["ball", "ground"]', 'between = ["ball", "bull"]', r"spring\[0\].between\[1\]"),
        ('body = "ball"\nfilter', 'body = "bull"\nfilter', r"sensor\[0\].body.*no body"),
        ('filter = "CFC1000"', 'filter = "CFC99"', "filter.*CFC60"),
        ('criteria = ["HIC15"]', 'criteria = ["HIC"]', "criteria.*HIC15"),
        ("tolerance = 0.5", "tolerance = 5e-9", "tolerance: takes about .* triangles or more"),
        ("tolerance = 0.5", "tolerance = 500", "tolerance: is .* times the size of the body"),
        ("tolerance = 0.5", "size = 0.004", "size: takes about .* triangles or more"),
        ('body = "cap", tolerance', 'body = "cop", tolerance', r"slave\[1\].points.body.*no body"),
        ("mass = 0.5\n", "", "free nodes need masses"),
        ("spin = [0.1, 0, 0]", "spun = [0.1, 0, 0]", "unknown key.*spin"),
        ('motion = { kind = "attached", body = "ball" }', 'motion = { kind = "attached", body = '
         '"cap" }', "in a circle"),
    ],
)  # fmt: skip
def test_wrong_keys_are_told(old: str, new: str, match: str) -> None:
    assert old in CASE
    with pytest.raises(InputError, match=rf"(?s){match}"):
        build(parse_case(CASE.replace(old, new, 1)))


@pytest.mark.parametrize("name", ["03_two_parts", "04_sled"])
def test_examples_can_be_built(name: str) -> None:
    path = Path(__file__).parents[3] / "examples" / f"{name}.toml"
    assert build(cg.load_case(path)).mechanism.has_dynamics
