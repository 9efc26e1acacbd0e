"""Names of a version ago answer as the new ones do, and say what these are."""

import numpy as np
import pytest

import contiga as cg

BALL = cg.Body([cg.shapes.sphere()])
POINTS = np.array([[0.0, 0.0, 1.1]])


def contact() -> cg.Contact:
    return cg.Contact(BALL, cg.Slave(POINTS, area=[0.5]), law=cg.PenaltyLaw(100.0))


@pytest.mark.parametrize("body", [BALL, BALL.tessellate(0.1)], ids=["body", "mesh"])
def test_a_method_answers_under_its_old_name(body: cg.Body | cg.TriMesh) -> None:
    kind = type(body).__name__
    with pytest.warns(DeprecationWarning, match=f"{kind}.about is called {kind}.with_reference"):
        moved = body.about([1.0, 2.0, 3.0])
    np.testing.assert_array_equal(moved.reference_point, [1.0, 2.0, 3.0])


def test_a_dry_run_answers_under_its_old_name() -> None:
    with pytest.warns(DeprecationWarning, match=r"Contact.rehearse is called Contact.dry_run now"):
        (found,) = contact().rehearse([(POINTS - [0.0, 0.0, 0.2], None)])
    assert found.inside.tolist() == [0]


@pytest.mark.parametrize(("old", "new"), [("near", "last_patch"), ("grip", "friction_memory")])
def test_an_array_answers_under_its_old_name(old: str, new: str) -> None:
    state = contact().start(POINTS)
    with pytest.warns(DeprecationWarning, match=f"State.{old} is called State.{new} now"):
        values = getattr(state, old)
    assert values is getattr(state, new)
    assert old not in state.arrays
