"""Wrong input of a contact: one clear error each, with what, where and what is allowed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import contiga as cg
from contiga.errors import InputError
from contiga.records import LawInput, LawOutput

PLANE = cg.Body([cg.shapes.plane()])
CLOUD = cg.Slave(np.zeros((4, 3)), area=np.ones(4))
LAW = cg.PenaltyLaw(1.0)
POINTS = np.zeros((4, 3))
CONTACT = cg.Contact(PLANE, CLOUD, law=LAW)


def _make(**options: object) -> Callable[[], object]:
    master, slave = options.pop("master", PLANE), options.pop("slave", CLOUD)
    law = options.pop("law", LAW)
    return lambda: cg.Contact(master, slave, law=law, **options)  # type: ignore[arg-type]


def _step(points: object = POINTS, pose: object = None, dt: float = 1.0) -> Callable[[], object]:
    return lambda: CONTACT.step(CONTACT.start(POINTS), points, pose, dt)  # type: ignore[arg-type]


class _Law:
    """A law of the user's own that answers what it is told to."""

    needs_mass = needs_thickness = False
    n_memory = 0

    def __init__(self, answer: Callable[[LawInput], object]) -> None:
        self._answer = answer

    def respond(self, inp: LawInput) -> object:
        return self._answer(inp)


class _OldLaw:
    needs_mass = needs_thickness = False

    def forces(self, inp: LawInput) -> np.ndarray:
        return inp.area


def _force(force: Callable[[LawInput], object]) -> Callable[[], object]:
    def answer(inp: LawInput) -> LawOutput:
        none = np.zeros(len(inp.area))
        return LawOutput(force(inp), none, none, np.zeros((len(none), 0)))  # type: ignore[arg-type]

    return _answer(answer)


def _answer(answer: Callable[[LawInput], object]) -> Callable[[], object]:
    contact = cg.Contact(PLANE, CLOUD, law=_Law(answer))  # type: ignore[arg-type]
    start, end = np.add(POINTS, [0.0, 0.0, 0.1]), POINTS - [0.0, 0.0, 0.1]
    return lambda: contact.step(contact.start(start), end)


MIRROR = np.diag([1.0, 1.0, -1.0, 1.0])
SHEARED = np.eye(4) + 0.1 * np.eye(4, k=1)
NOT_FINITE = np.full((4, 4), np.nan)

CASES = {
    "search": (_make(search="both"), "search", "both", "'intersection', 'penetration'"),
    "type": (_make(contact_type="Slave"), "contact_type", "Slave", "'slave', 'master', 'combined'"),
    "edge": (_make(on_edge="keep"), "on_edge", "keep", "'release', 'hold'"),
    "master is a surface": (
        _make(master=cg.shapes.plane()),
        "master",
        "NurbsSurface",
        "the master must be a Body",
    ),
    "slave is an array": (_make(slave=POINTS), "slave", "ndarray", "the slave must be a Slave"),
    "law of a number": (_make(law=5.0), "law", "5.0", "PenaltyLaw"),
    "law not made": (_make(law=cg.PenaltyLaw), "law", "class", "PenaltyLaw"),
    "no law": (_make(law=None), "law", "None", "needs_thickness"),
    "area of a number": (_make(area=1.0), "area", "1.0", "NodalArea"),
    "area not made": (_make(area=cg.NodalArea), "area", "class", "NodalArea"),
    "forces in a row": (_force(lambda inp: inp.area[:, None]), "law", "(4, 1)", "(4,)"),
    "one force for all": (_force(lambda _: np.ones(1)), "law", "(1,)", "(4,)"),
    "a bare number": (_force(lambda _: 1.0), "law", "()", "(4,)"),
    "no answer": (_force(lambda _: "none"), "law", "none", "numbers"),
    "an array alone": (_answer(lambda inp: inp.area), "law", "ndarray", "LawOutput(force, "),
    "memory nobody asked for": (
        _answer(lambda inp: LawOutput(inp.area, inp.area, inp.area, np.ones((4, 2)))),
        "law: memory",
        "(4, 2)",
        "(4, 0)",
    ),
    "law of old": (_make(law=_OldLaw()), "law", "_OldLaw", "respond(LawInput) -> LawOutput("),
    "depth of a word": (_make(depth="deep"), "depth", "deep", "> 0"),
    "step of a word": (_step(dt="long"), "dt", "long", "> 0"),  # type: ignore[arg-type]
    "step of three": (_step(dt=np.ones(3)), "dt", "1.", "> 0"),  # type: ignore[arg-type]
    "no state": (lambda: CONTACT.step(None, POINTS), "state", "NoneType", "State"),  # type: ignore[arg-type]
    "outlines of nothing": (lambda: CONTACT.outlines(None), "state", "NoneType", "State"),  # type: ignore[arg-type]
    "depth zero": (_make(depth=0.0), "depth", "0.0", "positive"),
    "depth not a number": (_make(depth=float("nan")), "depth", "nan", "positive"),
    "combined alone": (_make(contact_type="combined"), "master_law", "None", "StressLaw"),
    "combined of a force law": (
        _make(contact_type="combined", law=cg.ForceLaw(1.0), master_law=cg.StressLaw(1.0, 1.0)),
        "law",
        "ForceLaw",
        "StressLaw",
    ),
    "master law for nothing": (
        _make(master_law=cg.StressLaw(1.0, 1.0)),
        "master_law",
        "slave",
        "combined",
    ),
    "no thickness": (_make(law=cg.StressLaw(1.0)), "law", "without thickness", "Give the slave"),
    "no mass": (_make(law=cg.AdaptiveLaw()), "law", "without mass", "Give the slave"),
    "fewer points": (_step(np.zeros((3, 3))), "points", "3", "4"),
    "more points": (_step(np.zeros((5, 3))), "points", "5", "4"),
    "flat points": (_step(np.zeros((4, 2))), "points", "(4, 2)", "(n, 3)"),
    "words": (_step("points"), "points", "array of numbers", "(n, 3)"),
    "start with other points": (lambda: CONTACT.start(np.zeros((2, 3))), "points", "2", "4"),
    "back in time": (_step(dt=-1e-9), "dt", "-1e-09", "> 0"),
    "endless step": (_step(dt=float("inf")), "dt", "inf", "> 0"),
    "step of no number": (_step(dt=float("nan")), "dt", "nan", "> 0"),
    "pose of three rows": (_step(pose=np.eye(3)), "pose", "(3, 3)", "(4, 4)"),
    "mirroring pose": (_step(pose=MIRROR), "pose", "", ""),
    "sheared pose": (_step(pose=SHEARED), "pose", "", ""),
    "scaled pose": (_step(pose=np.diag([2.0, 2.0, 2.0, 1.0])), "pose", "", ""),
    "pose of no numbers": (_step(pose=NOT_FINITE), "pose", "", ""),
}


@pytest.mark.parametrize("name", CASES)
def test_wrong_input_is_told_clearly(name: str) -> None:
    call, where, found, allowed = CASES[name]
    with pytest.raises(InputError) as error:
        call()
    text = str(error.value)
    assert where in text
    assert found in text
    assert allowed in text
    assert error.value.exit_code == 2


def test_a_friction_with_a_viscosity_tells_its_largest_ratio() -> None:
    drag = SimpleNamespace(n_memory=0, respond=print, slid=print, viscosity=print)
    with pytest.raises(InputError, match=r"friction\.coefficient"):
        cg.Contact(PLANE, CLOUD, law=LAW, friction=drag)
    drag.coefficient = 0.3
    assert cg.Contact(PLANE, CLOUD, law=LAW, friction=drag)


def test_a_state_of_another_slave_is_refused() -> None:
    other = cg.Contact(PLANE, cg.Slave(np.zeros((3, 3)), area=np.ones(3)), law=LAW)
    with pytest.raises(InputError, match="the state belongs to another slave") as error:
        CONTACT.step(other.start(np.zeros((3, 3))), POINTS)
    assert (error.value.where, error.value.found, error.value.allowed) == ("state", 3, "4 points")


def test_a_state_of_another_master_is_refused() -> None:
    two = cg.Body([cg.shapes.plane(), cg.shapes.plane().translated([2.0, 0.0, 0.0])])
    contact = cg.Contact(two, CLOUD, law=LAW)
    above = np.add(POINTS, [2.0, 0.0, 0.1])
    state = contact.step(contact.start(above), above - [0.0, 0.0, 0.2])
    assert state.patch.tolist() == [1, 1, 1, 1]
    with pytest.raises(InputError, match="the state belongs to another master") as error:
        CONTACT.step(state, POINTS)
    assert (error.value.found, error.value.allowed) == (1, "-1 … 0")


@pytest.mark.parametrize("name", ["patch", "last_patch"])
def test_a_state_that_was_written_to_names_no_piece_that_is_not_there(name: str) -> None:
    state = CONTACT.start(POINTS)
    getattr(state, name)[1] = 7
    with pytest.raises(InputError, match="the state belongs to another master") as error:
        CONTACT.step(state, POINTS)
    assert (error.value.where, error.value.found) == (f"state.{name}", 7)


def test_a_law_cannot_change_what_it_is_given() -> None:
    with pytest.raises(ValueError, match="read-only"):
        _answer(lambda inp: inp.penetration.__imul__(2.0))()
    with pytest.raises(ValueError, match="read-only"):
        _answer(lambda inp: inp.area.__imul__(2.0))()


def test_a_list_of_forces_is_an_answer() -> None:
    state = _force(lambda inp: [1.0, 2.0, 3.0, 4.0])()
    assert state.force[:, 2].tolist() == [1.0, 2.0, 3.0, 4.0]  # type: ignore[attr-defined]


def test_lists_and_single_points_are_points() -> None:
    contact = cg.Contact(PLANE, cg.Slave([0.0, 0.0, 1.0], area=[1.0]), law=LAW)
    state = contact.step(contact.start([0, 0, 1]), [0, 0, -1])
    assert state.penetration.tolist() == [1.0]


def test_a_state_cannot_be_assigned_to() -> None:
    state = CONTACT.start(POINTS)
    with pytest.raises(AttributeError):
        state.penetration = POINTS[:, 0]  # type: ignore[misc]
    assert replace(state, penetration=np.ones(4)).max_penetration == 1.0
