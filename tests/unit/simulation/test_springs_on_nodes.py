"""Springs that end on nodes of slaves: the same as on bodies, their energy and forces kept."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import contiga as cg
from contiga.errors import CaseError, InputError, RunError

POINTS = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]])
FACETS = np.array([[0, 1, 2], [0, 2, 3]])
CLOTH = cg.materials.Elastic(young=1e4, poisson=0.3)


def swinging(stiffness: float = 4.0, damping: float = 0.0, **given: Any) -> cg.Simulation:
    """One of two free masses on a spring to the ground, half a unit longer than at rest."""
    slave = cg.Slave([[1.5, 0.0, 0.0], [9.0, 0.0, 0.0]])
    spring = cg.Spring(
        ("mass", "ground"),
        at=[[1.5, 0.0, 0.0], [0.0, 0.0, 0.0]],
        curve=stiffness,
        damping=damping,
        length=1.0,
        name="spring",
    )
    return cg.Simulation(
        **({"bodies": {}, "contacts": [], "springs": [spring], "end": 3.0, "step": 1e-3} | given),
        slaves={"mass": (slave, cg.motion.Free(2.0))},
    )


def test_a_mass_on_a_spring_swings_as_the_closed_form_says() -> None:
    result = swinging().run()
    time, root = result.state.time, np.sqrt(2.0)
    points = result.state.slaves["mass"].points
    assert points[0, 0] == pytest.approx(1.0 + 0.5 * np.cos(root * time), abs=1e-6)
    np.testing.assert_array_equal(points[1], [9.0, 0.0, 0.0])
    assert abs(result.state.energy.error) < 1e-6
    assert result.history["spring.rate"][-1] == pytest.approx(
        -0.5 * root * np.sin(root * time), abs=1e-5
    )


def test_a_damped_mass_loses_what_the_damper_takes() -> None:
    result = swinging(damping=1.0).run()
    energy, time = result.state.energy, result.state.time
    decay, swing = 0.25, np.sqrt(2.0 - 0.0625)
    shape = np.cos(swing * time) + decay / swing * np.sin(swing * time)
    expected = 1.0 + 0.5 * np.exp(-decay * time) * shape
    assert result.state.slaves["mass"].points[0, 0] == pytest.approx(expected, abs=1e-6)
    assert energy.damping > 0.1
    assert abs(energy.error) < 1e-6


def test_the_critical_step_is_that_of_the_mass_on_its_spring() -> None:
    result = swinging(stiffness=8e6, end=1e-3, step="auto").run()
    assert abs(result.state.energy.error) < 1e-3 * result.state.energy.initial
    with pytest.raises(RunError, match="spring 'spring'"):
        swinging(stiffness=8e6, end=0.1, step=2e-3).run()


def hung(**given: Any) -> cg.Simulation:
    """A cloth that hangs from two springs, beside a ball that a third one ties to it."""
    cloth = cg.Slave(POINTS, FACETS)
    motion = cg.motion.Deforming(material=CLOTH, density=1.0, thickness=0.01)
    springs = [
        cg.Spring(("cloth", "ground"), at=[POINTS[k], POINTS[k] + [0, 1, 0]], curve=50.0, name=name)
        for k, name in ((2, "right"), (3, "left"))
    ]
    tie = cg.Spring(("ball", "cloth"), at=[[0.0, -1.0, 0.0], [0.0, 0.001, 0.0]], curve=20.0)
    ball = cg.Body([cg.shapes.sphere(radius=0.1, centre=(0.0, -1.0, 0.0))])
    free = cg.motion.Free(0.05, inertia=1e-3 * np.eye(3), centre=(0.0, -1.0, 0.0))
    return cg.Simulation(
        bodies={"ball": (ball, free)},
        slaves={"cloth": (cloth, motion)},
        contacts=[],
        springs=[*springs, tie],
        gravity=(0.0, -10.0, 0.0),
        **({"end": 0.3, "step": 1e-4} | given),
    )


def test_what_hangs_on_cloth_keeps_the_energy() -> None:
    ends = [hung(step=step).run().state.energy for step in (4e-4, 1e-4)]
    came = abs(ends[1].external)
    assert came > 0.01
    errors = [abs(end.error) for end in ends]
    assert errors[1] < 1e-4 * came
    assert errors[0] > 8.0 * errors[1]


def test_an_end_is_put_on_the_nearest_node() -> None:
    simulation = hung()
    tied = simulation.mechanism.ends["ball-cloth"][1]
    assert tied.slave == "cloth"
    assert tied.nodes.tolist() == [0]
    # As long at rest as it is between the ball and the node.
    assert simulation.mechanism.springs["ball-cloth"].length == 1.0
    assert simulation.springs["ball-cloth"].length == pytest.approx(1.001)


def test_a_cloth_at_rest_pulls_its_springs_by_its_weight() -> None:
    state = hung().settle()
    pulls = [state.springs[name].pull for name in ("left", "right")]
    tie = -state.springs["ball-cloth"].pull
    np.testing.assert_allclose(sum(pulls) + tie, [0.0, 10.0 * 0.01, 0.0], atol=1e-3 * 0.1)


def test_a_run_resumes_with_the_same_bits(tmp_path: Any) -> None:
    def stop(state: Any) -> None:
        if state.time > 0.1:
            raise KeyboardInterrupt

    whole = hung(step=1e-3).run()
    with pytest.raises(KeyboardInterrupt):
        hung(step=1e-3).run(tmp_path / "out", on_step=stop)
    again = hung(step=1e-3).run(tmp_path / "out", resume=True)
    one, other = (run.state.slaves["cloth"].points for run in (whole, again))
    assert one.tobytes() == other.tobytes()


def test_a_driven_node_works_against_its_spring() -> None:
    cloth = cg.Slave(POINTS, FACETS)
    up = cg.motion.Translate([[0.0, 0, 0, 0], [1.0, 0, 0, 2.0]])
    ball = cg.Body([cg.shapes.sphere(radius=0.1, centre=(0.0, 0.0, -1.0))])
    ways = ("x", "y", "z", "rx", "ry", "rz")
    fixed = cg.motion.Free(1.0, inertia=np.eye(3), centre=(0, 0, -1.0), hold=ways)
    spring = cg.Spring(("ball", "cloth"), at=[[0, 0, -1.0], [0, 0, 0]], curve=3.0)
    simulation = cg.Simulation(
        bodies={"ball": (ball, fixed)},
        slaves={"cloth": (cloth, cg.motion.Moved(cloth.points, up))},
        contacts=[],
        springs=[spring],
        end=1.0,
        step=0.01,
    )
    energy = simulation.run().state.energy
    assert energy.external == pytest.approx(6.0, rel=1e-9)
    assert energy.strain == pytest.approx(6.0, rel=1e-9)


@pytest.mark.parametrize(
    ("between", "at", "said"),
    [
        (("cloth", "ground"), [[5.0, 0, 0], [0, 9.0, 0]], "node 1, is 4 away"),
        (("rope", "ground"), [[0.0, 0, 0], [0, 9.0, 0]], "no body of this name"),
    ],
)
def test_an_end_that_is_nowhere_is_refused(between: Any, at: Any, said: str) -> None:
    cloth = cg.Slave(POINTS, FACETS)
    motion = cg.motion.Deforming(material=CLOTH, density=1.0, thickness=0.01)
    with pytest.raises(InputError, match=said):
        cg.Simulation(
            bodies={},
            slaves={"cloth": (cloth, motion)},
            contacts=[],
            springs=[cg.Spring(between, at=at, curve=1.0)],
            end=1.0,
            step=0.1,
        ).step(None)  # type: ignore[arg-type]


CASE = """
[units]
length = "m"
mass = "kg"
time = "s"

[[slave]]
name = "cloth"
points = { grid = { shape = "plane", width = 1.0, length = 1.0, nu = 3, nv = 3 } }
motion = { kind = "free" }
mass = 0.1

[[spring]]
between = ["WHO", "ground"]
at = [[0, 0, 0], [0, 0, 1]]
curve = 5.0
length = 0.5

[time]
end = 0.1
step = 0.01
"""


def test_a_case_names_a_slave(tmp_path: Path) -> None:
    file = tmp_path / "case.toml"
    file.write_text(CASE.replace("WHO", "clot"))
    with pytest.raises(CaseError, match="no body or slave of this name") as error:
        cg.load_case(file)
    assert "cloth" in str(error.value)
    file.write_text(CASE.replace("WHO", "cloth"))
    state = cg.build(cg.load_case(file)).run().state
    assert state.springs["cloth-ground"].length < 1.0
