"""A simulation from Python: what it is made of, one step, and a whole run."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import contiga as cg
from contiga.case.schema import parse_case
from contiga.dynamics.stepping import EqualSteps
from contiga.errors import CaseError, InputError, MissingPackageError
from contiga.simulation.model import ContactPart

BALL = cg.Body([cg.shapes.sphere(radius=1.0)], name="ball")
PAD = cg.Slave([[0.0, 0.0, 1.2], [0.1, 0.0, 1.3]], area=[1.0, 1.0], name="pad")
ENDS = {"between": ("ball", "ground"), "at": [[0, 0, 0], [0, 0, 5]]}
CASE = """
units = {{ length = "mm", mass = "kg", time = "ms" }}
time = {{ end = 1.0, step = 0.5 }}
[[body]]
name = {name}
geometry = {{ shape = "sphere", radius = 1.0 }}
[[slave]]
name = "pad"
points = {{ coordinates = [[0, 0, 2]] }}
area = 1.0
[[contact]]
master = {name}
slave = "pad"
law = {{ kind = "penalty", stiffness = 1.0 }}
"""
DOWN = cg.motion.Translate([[0, 0, 0, 0], [1, 0, 0, -0.4]])


def simulation(**changes: object) -> cg.Simulation:
    values: dict[str, object] = {
        "bodies": {"ball": BALL},
        "slaves": {"pad": (PAD, DOWN)},
        "contacts": [cg.Contact(BALL, PAD, law=cg.PenaltyLaw(100.0))],
        "end": 1.0,
        "step": 0.25,
    }
    return cg.Simulation(**(values | changes))  # type: ignore[arg-type]


@pytest.mark.parametrize("name", ["a/b", "", ".", "..", " a", "a\n", "a.b", "a\0", "<a>", 7, None])
def test_names_are_those_that_a_case_may_have(name: object) -> None:
    """With them folders were written that nothing could open."""
    sheet, spring = cg.Slave(PAD.points + 9.0, area=[1.0, 1.0]), cg.Spring(curve=1.0, **ENDS)
    contact = cg.Contact(BALL, PAD, law=cg.PenaltyLaw(100.0))
    for changes in (
        {"bodies": {"ball": BALL, name: BALL.scaled(0.1)}},
        {"slaves": {"pad": (PAD, DOWN), name: sheet}},
        {"contacts": [ContactPart(name, "ball", "pad", contact)]},  # type: ignore[arg-type]
        {"springs": {name: spring}},
    ):
        (kind,) = changes
        with pytest.raises(InputError, match=f"{kind}: name: is not a name; .*letters, digits"):
            simulation(**changes)
    if isinstance(name, str):
        case = CASE.format(name=json.dumps(name))
        with pytest.raises(CaseError, match="is not a name"):
            parse_case(case)


def test_names_of_many_kinds_are_good() -> None:
    for name in ("Kopf", "Schädel links", "頭", "7", "_", "a-b_c 1"):
        simulation(bodies={"ball": BALL, name: BALL.scaled(0.1)})
        assert parse_case(CASE.format(name=json.dumps(name))).body[0].name == name


def test_steps_one_by_one_are_the_run() -> None:
    own = simulation()
    seen: list[cg.SystemState] = []
    result = own.run(keep=1, on_step=seen.append)
    state = own.start()
    for kept, told in zip(result.states, seen, strict=True):
        assert kept is told
        assert (state.time, state.energy) == (kept.time, kept.energy)
        (name,) = state.contacts
        for field in ("status", "uv", "force", "energies", "points_B"):
            one, other = (getattr(s.contacts[name], field) for s in (state, kept))
            assert one.tobytes() == other.tobytes()
        if state.time < 1.0:
            state = own.step(state)
    assert [s.time for s in result.states] == [0.0, 0.25, 0.5, 0.75, 1.0]
    assert result.state is result.states[-1]
    assert result.state.n_contact == 2


@pytest.mark.parametrize(("keep", "times"), [(None, []), (2, [0.0, 0.5, 1.0]), (3, [0.0, 0.75])])
def test_as_many_states_are_kept_as_were_asked_for(keep: int | None, times: list[float]) -> None:
    assert [state.time for state in simulation().run(keep=keep).states] == times


def test_a_step_leaves_the_state_before_it_as_it_was() -> None:
    own = simulation()
    first = own.start()
    before = {name: array.copy() for name, array in first.contacts["ball-pad"].arrays.items()}
    again = [own.step(first), own.step(first)]
    for name, array in before.items():
        assert getattr(first.contacts["ball-pad"], name).tobytes() == array.tobytes()
    assert again[0].contacts["ball-pad"].force.tobytes() == (
        again[1].contacts["ball-pad"].force.tobytes()
    )


def test_a_step_has_the_length_that_is_asked_for() -> None:
    own = simulation()
    state = own.step(own.step(own.start(), dt=0.1), dt=0.65)
    assert state.time == 0.75
    assert own.step(state).time == 1.0
    with pytest.raises(InputError, match="at its end"):
        own.step(own.step(state))
    assert own.step(own.step(state), dt=0.5).time == 1.5
    with pytest.raises(InputError, match="dt"):
        own.step(state, dt=0.0)


def test_a_state_says_where_all_is_and_how_it_moves() -> None:
    turn = cg.motion.Rotate([[0, 0], [1, 180]], axis="z", centre=[1, 0, 0])
    own = simulation(bodies={"ball": (BALL, turn)}, slaves={"pad": (PAD, DOWN)})
    state = own.step(own.start())
    body, slave = state.bodies["ball"], state.slaves["pad"]
    np.testing.assert_array_equal(body.pose, turn.pose(0.25))
    np.testing.assert_allclose(body.twist.spin, [0, 0, np.pi])
    np.testing.assert_allclose(
        body.twist.velocity, np.cross([0, 0, np.pi], body.pose[:3, 3] - [1, 0, 0])
    )
    np.testing.assert_array_equal(slave.points, PAD.points + np.array([0, 0, -0.1]))
    np.testing.assert_array_equal(slave.velocities, np.tile([0, 0, -0.4], (2, 1)))


def test_the_energy_is_what_the_contacts_store() -> None:
    own = simulation()
    state = own.run().state
    depth = state.contacts["ball-pad"].penetration
    assert depth.min() > 0.05
    assert state.energy.contact == pytest.approx(0.5 * 100.0 * (depth**2).sum(), rel=1e-14)


def test_names_of_contacts_are_given_or_made_of_their_sides() -> None:
    contact = cg.Contact(BALL, PAD, law=cg.PenaltyLaw(1.0))
    for given, name in (
        ([contact], "ball-pad"),
        ({"touch": contact}, "touch"),
        ([ContactPart("own", "ball", "pad", contact)], "own"),
    ):
        (part,) = simulation(contacts=given).contacts
        assert (part.name, part.master, part.slave) == (name, "ball", "pad")


class OnlyPose:
    """A motion that does not say how fast it is."""

    def pose(self, t: float) -> np.ndarray:
        return np.eye(4)


class OnlyPoints:
    """Points that move without a velocity."""

    def points(self, t: float) -> np.ndarray:
        return PAD.points


OTHER = cg.Contact(BALL, cg.Slave([[0.0, 0.0, 2.0]], area=[1.0]), law=cg.PenaltyLaw(1.0))
WRONG = {
    "no time": ({"end": None, "step": None}, "give one of"),
    "an end only": ({"step": None}, "give one of.*; found 'end'"),
    "two ways": ({"times": [0.0, 1.0]}, "found 'times, end, step'"),
    "three ways": ({"times": [0.0], "stepping": EqualSteps(0.0, 1.0, 0.5)}, "give one of"),
    "times that repeat": ({"end": None, "step": None, "times": [0.0, 1.0, 1.0]}, "increase"),
    "no times": ({"end": None, "step": None, "times": []}, "one or more"),
    "a step too long": ({"step": 2.0}, "step: .*longer than the whole time"),
    "an end before the start": ({"start": 2.0}, "end: .*after the start"),
    "a step that is no number": (
        {"step": "fast"},
        "step: must be a number, or .auto.; found",
    ),
    "times that are no numbers": ({"end": None, "step": None, "times": ["a"]}, "must be numbers"),
    "no stepping": ({"end": None, "step": None, "stepping": 3}, "stepping: has no start"),
    "bodies without names": ({"bodies": [BALL]}, "bodies: must be given by name"),
    "slaves without names": ({"slaves": PAD}, "slaves: must be given by name"),
    "three of a body": (
        {"bodies": {"ball": (BALL, DOWN, 1)}},
        "expected a Body or TriMesh; found 'tuple'",
    ),
    "one contact": ({"contacts": OTHER}, "contacts: must be several"),
    "no body": ({"bodies": {"ball": "ball.step"}}, r"bodies\['ball'\]: expected a Body or TriMesh"),
    "no slave": ({"slaves": {"pad": PAD.points}}, r"slaves\['pad'\]: expected a Slave"),
    "a motion without twist": ({"bodies": {"ball": (BALL, OnlyPose())}}, r"no twist\(t\)"),
    "carried without twist": ({"slaves": {"pad": (PAD, OnlyPose())}}, r"no twist\(t\)"),
    "points without velocities": ({"slaves": {"pad": (PAD, OnlyPoints())}}, r"no velocities\(t\)"),
    "another slave's contact": ({"contacts": [OTHER]}, "its slave is none of the simulation's"),
    "no contact": ({"contacts": ["ball"]}, "its master is none of the simulation's"),
}


@pytest.mark.parametrize("what", WRONG)
def test_what_is_wrong_is_said_when_it_is_made(what: str) -> None:
    changes, message = WRONG[what]
    with pytest.raises(InputError, match=message):
        simulation(**changes)


class Answers:
    """A motion of a user that answers as it is told."""

    def __init__(self, **answers: object) -> None:
        for name, answer in answers.items():
            setattr(self, name, lambda t, own=answer: own)


STILL = cg.motion.Twist(np.zeros(3), np.zeros(3))
NOT_FINITE = cg.motion.Twist(np.zeros(3), np.full(3, np.nan))
BODY_ANSWERS = {
    "a small pose": ({"pose": np.eye(3), "twist": STILL}, "must be a finite"),
    "no twist": ({"pose": np.eye(4), "twist": None}, r"twist\(t\) must be"),
    "a twist of pairs": ({"pose": np.eye(4), "twist": cg.motion.Twist([0, 0], [0, 0])}, "twist"),
    "a twist not finite": ({"pose": np.eye(4), "twist": NOT_FINITE}, "finite"),
}
SLAVE_ANSWERS = {
    "too many points": ({"points": np.zeros((3, 3)), "velocities": PAD.points}, r"points\(t\)"),
    "too few velocities": ({"points": PAD.points, "velocities": np.zeros((1, 3))}, "velocities"),
    "no velocities": ({"points": PAD.points, "velocities": None}, r"velocities\(t\)"),
}


@pytest.mark.parametrize("what", [*BODY_ANSWERS, *SLAVE_ANSWERS])
def test_a_motion_that_answers_wrongly_is_told_and_leaves_nothing(
    what: str, tmp_path: Path
) -> None:
    if what in BODY_ANSWERS:
        answers, message = BODY_ANSWERS[what]
        own = simulation(bodies={"ball": (BALL, Answers(**answers))})
        where = r"bodies\['ball'\]: motion at t = 0"
    else:
        answers, message = SLAVE_ANSWERS[what]
        own = simulation(slaves={"pad": (PAD, Answers(**answers))})
        where = r"slaves\['pad'\]: motion at t = 0"
    with pytest.raises(InputError, match=f"{where}.*{message}"):
        own.step(own.start())
    # A motion that is wrong beforehand leaves nothing on disk, either.
    with pytest.raises(InputError):
        own.run(tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_state_of_another_simulation_is_refused() -> None:
    other = simulation(contacts={"other": cg.Contact(BALL, PAD, law=cg.PenaltyLaw(1.0))})
    for state in (other.start(), 3):
        with pytest.raises(InputError, match="not a state of this simulation"):
            simulation().step(state)  # type: ignore[arg-type]


@pytest.mark.parametrize("keep", [0, -1, 1.5, True])
def test_states_are_kept_every_whole_number_of_steps(keep: float) -> None:
    with pytest.raises(InputError, match="keep"):
        simulation().run(keep=keep)  # type: ignore[arg-type]


def test_the_history_is_a_table_of_pandas() -> None:
    pandas = pytest.importorskip("pandas")
    result = simulation().run()
    table = result.to_pandas()
    assert isinstance(table, pandas.DataFrame)
    assert table.index.name == "time"
    np.testing.assert_array_equal(table.index, result.history["time"])
    assert list(table.columns) == list(result.history)[1:]
    assert table["n_contact"].dtype == np.int64
    assert table.loc[1.0, "max_penetration"] == pytest.approx(0.2)


def test_without_pandas_the_message_says_what_to_install(
    blocked: Callable[[str], None],
) -> None:
    blocked("pandas")
    with pytest.raises(MissingPackageError, match=r"contiga\[pandas\]"):
        simulation().run().to_pandas()


def test_free_bodies_need_no_contacts() -> None:
    thrown = cg.motion.Free(2.0, velocity=(3.0, 0.0, 0.0), hold=("rx", "ry", "rz"))
    own = {"bodies": {"ball": (BALL, thrown)}, "slaves": {}, "contacts": []}
    result = simulation(**own, gravity=(0.0, 0.0, -2.0)).run()
    assert result.history["ball.x"].tolist() == [0.0, 0.75, 1.5, 2.25, 3.0]
    assert result.history["ball.z"][-1] == pytest.approx(-1.0)
    with pytest.raises(InputError, match="there must be contacts"):
        simulation(**(own | {"bodies": {"ball": BALL}}))
