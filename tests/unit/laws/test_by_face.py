"""Laws by face: each point by the law of its face, alone and in series with the slave's."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg
from contiga.errors import InputError
from contiga.laws.by_face import FaceLaws
from contiga.laws.combined import CombinedLaw
from contiga.records import LawInput

SOFT, HARD = cg.StressLaw(4.0, 0.5), cg.StressLaw(20.0, 0.1, damping=0.3)
LAZY = cg.StressLaw(4.0, 0.5, unloading=2.0, hysteresis_slope=50.0)
PATCH = np.array([0, 2, 1, 0, 2])


def pressed(memory: np.ndarray | None = None, depth: float = 0.02) -> LawInput:
    rng = np.random.default_rng(3)
    depths, rate, area = depth * (1.0 + rng.random(5)), rng.random(5), 1.0 + rng.random(5)
    kept = np.zeros((0, 0)) if memory is None else memory
    return LawInput(depths, rate, area, None, None, 0.1, kept, PATCH)


def one(inp: LawInput, k: int, memory: np.ndarray) -> LawInput:
    own = (v[k : k + 1] for v in inp[:3])
    return LawInput(*own, None, None, inp.dt, memory)


def test_each_point_has_the_law_of_its_face_and_its_own_memory() -> None:
    laws = FaceLaws(SOFT, {1: HARD, (2,): LAZY})
    first = laws.respond(pressed())
    then = laws.respond(pressed(first.memory, 0.01))
    assert laws.n_memory == 2
    for k, law in enumerate((SOFT, LAZY, HARD, SOFT, LAZY)):
        width = law.n_memory
        before = law.respond(one(pressed(), k, np.zeros((0, 0))))
        after = law.respond(one(pressed(depth=0.01), k, before.memory))
        for whole, part in ((first, before), (then, after)):
            for name in ("force", "stiffness", "stored", "hysteresis", "damping"):
                assert getattr(whole, name)[k] == getattr(part, name)[0]
            np.testing.assert_array_equal(whole.memory[k, :width], part.memory[0])


def test_in_series_with_the_slave_s_side() -> None:
    both = FaceLaws(SOFT, {1: HARD}).with_slave(SOFT)
    answer = both.respond(pressed())
    for k, law in enumerate((SOFT, SOFT, HARD, SOFT, SOFT)):
        alone = CombinedLaw(SOFT, law).respond(one(pressed(), k, np.zeros((0, 0))))
        assert answer.force[k] == alone.force[0]


def test_a_ball_on_a_box_of_two_stiffnesses() -> None:
    """Plates side by side: the force of each is that of a plate alone."""
    left = cg.shapes.plane(width=1.0, length=1.0, centre=(-0.5, 0.0, 0.0))
    right = cg.shapes.plane(width=1.0, length=1.0, centre=(0.5, 0.0, 0.0))
    body = cg.Body([left, right])
    points = np.array([[-0.5, 0.0, 0.1], [0.5, 0.0, 0.1]])
    slave = cg.Slave(points, area=[1.0, 1.0])
    law = cg.FaceLaws(cg.StressLaw(4.0, 0.5), {1: cg.StressLaw(8.0, 0.5)})
    contact = cg.Contact(body, slave, law=law, contact_type="master")
    state = contact.step(contact.start(points), points - [0.0, 0.0, 0.15])
    np.testing.assert_allclose(state.force[:, 2], [0.4, 0.8], rtol=1e-12)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: FaceLaws(SOFT, {0: SOFT, (1, 0): HARD}), "two laws; found 0"),
        (lambda: FaceLaws(SOFT, {-1: HARD}), "is not a face; found -1"),
        (lambda: FaceLaws(SOFT, {"hood": HARD}), "is not a face; found 'hood'"),
        (lambda: FaceLaws(cg.ForceLaw(1.0), {0: SOFT}), "each point by itself; found 'ForceLaw'"),
        (lambda: FaceLaws(SOFT, {0: FaceLaws(SOFT, {})}), "by itself; found 'FaceLaws'"),
    ],
)
def test_wrong_faces_are_refused(make, message: str) -> None:
    with pytest.raises(InputError, match=message):
        make()


def test_faces_that_the_master_does_not_have_are_refused() -> None:
    slave = cg.Slave([[0.0, 0.0, 2.0]], area=[1.0])
    ball = cg.Body([cg.shapes.sphere(radius=1.0)])
    for master in (ball, ball.tessellate(0.1)):
        with pytest.raises(InputError, match="no such face; found 1"):
            cg.Contact(master, slave, law=FaceLaws(SOFT, {1: HARD}), contact_type="master")
