"""Sensors of slaves: nodes against their motion, sections against what is pulled and hung."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from tests.blocks import block

import contiga as cg
from contiga.case.columns import columns_of_case
from contiga.errors import CaseError, InputError

YOUNG, LENGTH = 10.0, 4.0
STRAIN = 0.05
SECTION_FORCE = YOUNG * (1.0 + STRAIN) * (STRAIN + 0.5 * STRAIN**2)
"""Of a section of one, as Saint-Venant and Kirchhoff have it without a lateral strain."""


def bar(sensors: list[object], **options: object) -> cg.Simulation:
    """A bar of one by one by four that is held at its foot, pulled at its head, and at rest."""
    slave = block((2, 2, 8), (1.0, 1.0, LENGTH), kind="hexahedron")
    pulled = cg.motion.Translate([[0, 0, 0, STRAIN * LENGTH], [1, 0, 0.1, STRAIN * LENGTH]])
    motion = cg.motion.Deforming(
        material=cg.materials.Elastic(young=YOUNG),
        density=1.0,
        fixed={"layer": ([0, 0, -1], 0.0)},
        driven={"layer": ([0, 0, 1], 0.0), "motion": pulled},
    )
    arguments: dict[str, object] = {
        "slaves": {"bar": (slave, motion)},
        "bodies": {"ball": cg.Body([cg.shapes.sphere(radius=1.0, centre=(0, 0, -90))])},
        "contacts": [],
        "end": 0.1,
        "step": "auto",
        "settling": cg.Settle(tolerance=1e-8),
        "sensors": sensors,
    }
    return cg.Simulation(**(arguments | options))  # type: ignore[arg-type]


@pytest.mark.parametrize("height", [0.3, 2.1, 3.9])
def test_a_section_carries_what_pulls_wherever_it_is(height: float) -> None:
    plane = [[0.5, 0.5, height], [0.0, 0.0, 2.0]]
    below = [[0.5, 0.5, height], [0.0, 0.0, -2.0]]
    sensors = [
        cg.SectionSensor("up", "bar", plane=plane),
        cg.SectionSensor("down", "bar", plane=below),
    ]
    history = bar(sensors).run().history
    exact = pytest.approx([0.0, 0.0, -SECTION_FORCE], abs=1e-6)
    assert [history[f"up.f{axis}"][0] for axis in "xyz"] == exact
    assert history["up.f"][0] == pytest.approx(SECTION_FORCE, rel=1e-6)
    assert [history[f"up.m{axis}"][0] for axis in "xyz"] == pytest.approx([0, 0, 0], abs=1e-6)
    # what one side does on the other comes back, but for rounding
    np.testing.assert_allclose(history["up.fz"], -history["down.fz"], atol=1e-12)


def test_the_moment_is_about_the_point_of_the_plane() -> None:
    plane = [[0.0, 0.0, 2.1], [0.0, 0.0, 1.0]]
    history = bar([cg.SectionSensor("cut", "bar", plane=plane)]).run().history
    moment = [history[f"cut.m{axis}"][0] for axis in "xyz"]
    assert moment == pytest.approx([-0.5 * SECTION_FORCE, 0.5 * SECTION_FORCE, 0.0], abs=1e-6)


def test_a_node_moves_as_it_is_driven() -> None:
    history = bar([cg.NodeSensor("head", "bar", at=[0.0, 0.0, 4.4])]).run().history
    times = history["time"]
    np.testing.assert_allclose(history["head.y"], 0.1 * times, atol=1e-12)
    np.testing.assert_allclose(history["head.z"], STRAIN * LENGTH, atol=1e-12)
    np.testing.assert_allclose(history["head.vy"], 0.1, atol=1e-12)
    np.testing.assert_allclose(history["head.v"], 0.1, atol=1e-12)


def test_a_node_of_a_driven_slave_has_its_motion() -> None:
    points = np.array([[0.0, 0.0, 5.0], [3.0, 0.0, 5.0]])
    slave = cg.Slave(points, area=[1.0, 1.0])
    ball = cg.Body([cg.shapes.sphere(radius=1.0)])
    history = cg.Simulation(
        bodies={"ball": ball},
        slaves={"two": (slave, cg.motion.Translate([[0, 0, 0, 0], [1, 0, 2, 0]]))},
        contacts=[cg.Contact(ball, slave, law=cg.PenaltyLaw(1.0))],
        sensors=[cg.NodeSensor("right", "two", at=[2.0, 0.0, 5.0])],
        end=1.0,
        step=0.25,
    ).run().history  # fmt: skip
    np.testing.assert_allclose(history["right.y"], 2.0 * history["time"])
    np.testing.assert_allclose(history["right.vy"], 2.0)


@pytest.mark.parametrize(("make", "said"), [
    (lambda: cg.NodeSensor("a", "bar", at=[0, 0, 0], measures=["force"]), "measures.*'velocity'"),
    (lambda: cg.SectionSensor("a", "bar", plane=[[0, 0, 1], [0, 0, 0]]), "plane: has no normal"),
    (lambda: cg.SectionSensor("a", "bar", plane=[0, 0, 1]), "plane: must be two points"),
    (lambda: bar([cg.NodeSensor("a", "beam", at=[0, 0, 0])]), r"sensors\[0\]: node.*beam.*'bar'"),
    (lambda: bar([cg.NodeSensor("a", "bar", at=[0, 0, 99])]),
     "'a': at: no node is near.*allowed: a place within"),
    (lambda: bar([cg.SectionSensor("a", "bar", plane=[[0, 0, 9], [0, 0, 1]])]),
     "all nodes of the slave are on one side.*allowed: a plane through the slave"),
])  # fmt: skip
def test_what_cannot_be_measured_is_refused(make: object, said: str) -> None:
    with pytest.raises(InputError, match=said):
        make()  # type: ignore[operator]


def test_only_what_has_elements_has_sections() -> None:
    ball = cg.Body([cg.shapes.sphere(radius=1.0)])
    slave = cg.Slave([[0.0, 0.0, 5.0], [3.0, 0.0, 5.0]], area=[1.0, 1.0])
    contact = cg.Contact(ball, slave, law=cg.PenaltyLaw(1.0))
    sensor = cg.SectionSensor("a", "two", plane=[[1, 0, 0], [1, 0, 0]])
    parts = {"bodies": {"ball": ball}, "slaves": {"two": slave}, "contacts": [contact]}
    with pytest.raises(InputError, match="section: the slave has no elements"):
        bar([sensor], **parts)


CASE = """
units = { length = "mm", mass = "g", time = "ms" }
time = { end = 0.5, step = "auto" }
output = { formats = ["csv"], report = false }
[[body]]
name = "ball"
geometry = { shape = "sphere", radius = 1.0, centre = [0, 0, 5] }
[[slave]]
name = "cloth"
points = { grid = { shape = "plane", width = 4, length = 4, nu = 5, nv = 5 } }
[slave.motion]
kind = "deform"
material = { kind = "elastic", young = 1.0 }
density = 1.0e-3
thickness = 0.5
fixed = { plane = [[-2, 0, 0], [1, 0, 0]] }
[[contact]]
master = "ball"
slave = "cloth"
law = { kind = "penalty", stiffness = 0.5, per_area = true }
[[sensor]]
name = "corner"
node = "cloth"
at = [2, 2, 0]
[[sensor]]
name = "middle"
section = "SLAVE"
plane = [[0.1, 0, 0], [1, 0, 0]]
measures = ["force"]
"""


def test_a_case_has_them_and_knows_their_columns(tmp_path: Path) -> None:
    path = tmp_path / "case.toml"
    path.write_text(CASE.replace("SLAVE", "cloth"), encoding="utf-8")
    history = cg.run(path, out=tmp_path / "out").history
    told = [name for name in history if name.partition(".")[0] in ("corner", "middle")]
    own = [f"corner.{c}" for c in ("x", "y", "z", "vx", "vy", "vz", "v")]
    assert told == [*own, *(f"middle.{c}" for c in ("fx", "fy", "fz", "f"))]
    assert set(told) <= set(columns_of_case(cg.load_case(path)))


def test_a_case_names_slaves_that_are_there(tmp_path: Path) -> None:
    path = tmp_path / "case.toml"
    path.write_text(CASE.replace("SLAVE", "cloht"), encoding="utf-8")
    with pytest.raises(CaseError, match=r"sensor\[1\].section.*cloht.*cloth"):
        cg.load_case(path)
