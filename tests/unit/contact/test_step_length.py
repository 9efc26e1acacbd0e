"""`Contact.step` without the length of the step: where no force depends on it, and nowhere else."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg
from contiga.errors import InputError

BALL = cg.Body([cg.shapes.sphere(radius=1.0)])
POINTS = np.array([[0.0, 0.0, 1.0], [0.1, 0.0, 1.0]])
PAD = cg.Slave(POINTS, area=[1.0, 1.0], thickness=[1.0, 1.0], mass=[1.0, 1.0])
ELASTIC = cg.StressLaw(10.0, 1.0)


class Own:
    """A law of a user that says nothing of rates."""

    needs_mass = needs_thickness = False
    n_memory = 0

    def respond(self, inp: cg.LawInput) -> cg.LawOutput:
        zeros = np.zeros(len(inp.penetration))
        return cg.LawOutput(inp.penetration, zeros + 1.0, zeros, np.zeros((len(zeros), 0)))


class OwnDamper(Own):
    has_rate = True

    def respond(self, inp: cg.LawInput) -> cg.LawOutput:
        plain = super().respond(inp)
        return plain._replace(force=np.maximum(plain.force + inp.rate, 0.0))


def pressed(contact: cg.Contact, dt: float | None, told: bool) -> cg.State:
    state = contact.start(np.add(POINTS, [0.0, 0.0, 0.1]))
    velocity = np.tile([0.3, 0.0, -1.0], (2, 1)) if told else None
    return contact.step(state, np.subtract(POINTS, [0.3, 0.0, 0.2]), dt=dt, velocity=velocity)


@pytest.mark.parametrize(
    ("law", "friction"),
    [
        (cg.PenaltyLaw(10.0, damping=1.0), None),
        (cg.PenaltyLaw(10.0, damping_ratio=0.1), None),
        (cg.StressLaw(10.0, 1.0, damping=1.0), None),
        (cg.StressLaw(10.0, 1.0, damping_curve=[[0, 0], [1, 1]]), None),
        (cg.StressLaw(10.0, 1.0, damping_ratio=0.1), None),
        (cg.FaceLaws(ELASTIC, {0: cg.StressLaw(10.0, 1.0, damping=1.0)}), None),
        (OwnDamper(), None),
        (ELASTIC, cg.ViscousFriction(0.3, 1.0)),
        (ELASTIC, cg.Coulomb(0.4, 0.2, decay=1.0)),
    ],
)
def test_rates_need_the_length_of_the_step_or_a_velocity(law: object, friction: object) -> None:
    """They were those of a step of 1."""
    contact = cg.Contact(BALL, PAD, law=law, friction=friction)
    with pytest.raises(InputError, match="dt: is missing: forces of this contact depend on rates"):
        pressed(contact, None, told=False)
    short, long = (pressed(contact, dt, told=False).force for dt in (0.01, 1.0))
    assert not np.allclose(short, long), "so it matters"
    told, other = (pressed(contact, dt, told=True) for dt in (None, 0.01))
    assert told.force.tobytes() == other.force.tobytes(), "a velocity says all"


def test_a_combined_law_has_the_rates_of_its_sides() -> None:
    soft = cg.StressLaw(10.0, 1.0, damping=1.0)
    for sides in ({"law": soft, "master_law": ELASTIC}, {"law": ELASTIC, "master_law": soft}):
        contact = cg.Contact(BALL, PAD, contact_type="combined", **sides)
        with pytest.raises(InputError, match="dt: is missing"):
            pressed(contact, None, told=False)


def test_a_stiffness_that_follows_the_step_needs_it_whatever_the_velocity() -> None:
    contact = cg.Contact(BALL, PAD, law=cg.AdaptiveLaw())
    for told in (False, True):
        with pytest.raises(InputError, match="dt: is missing"):
            pressed(contact, None, told=told)


@pytest.mark.parametrize(
    ("law", "friction"),
    [
        (cg.PenaltyLaw(10.0), None),
        (ELASTIC, cg.Coulomb(0.4)),
        (ELASTIC, cg.Coulomb(0.4, 0.2)),
        (ELASTIC, cg.Coulomb(0.4, 0.4, decay=1.0)),
        (cg.StressLaw(10.0, 1.0, unloading=5.0, hysteresis_slope=20.0), None),
        (cg.ForceLaw(10.0), None),
        (Own(), None),
    ],
)
def test_elsewhere_it_makes_no_difference_and_may_be_left_out(
    law: object, friction: object
) -> None:
    contact = cg.Contact(BALL, PAD, law=law, friction=friction)
    states = [pressed(contact, dt, told=False) for dt in (None, 0.01, 7.0)]
    assert states[0].force.any()
    assert len({state.force.tobytes() for state in states}) == 1
