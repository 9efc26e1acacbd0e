"""Samples of `make stress`."""

from __future__ import annotations

import numpy as np
import pytest
from tests.sample import FULL, full
from tests.stress import (
    auto,
    checkpoints,
    loops,
    motions,
    open_scenes,
    opened,
    segments,
    shaking,
    solids,
    subjects,
    tracking,
    unions,
    wandering,
)
from tests.stress.tally import Tally

import contiga as cg

SOLIDS = list(solids.RECIPES)
SHAKEN = ("slot", "lens", "torus", "blade")
OTHERS = [name for name in SOLIDS if name not in SHAKEN]
SAMPLED = ("slot", "cup", "torus", "block, fillets 3")
SHOT = [name for name in SOLIDS if name not in ("link rod", "small link rod")]
SURFACES = ("sphere", "cylinder", "ellipsoid", "high bumps", "torus with slivers")
SURFACES = (*SURFACES, "bumps with slivers")
BRICKS = ("bricks",)


@pytest.fixture(autouse=True)
def _data(data_dir):
    """CAD files are part of the sample."""


def clean(tally: Tally) -> None:
    assert tally.wrong == 0, "\n".join(map(str, [tally.line(), *tally.faults]))
    assert tally.count > 0


@pytest.mark.parametrize("name", [*SHAKEN, *full(*OTHERS, *solids.CLOSED_FILES)])
def test_after_each_step_of_shaking_contact_is_inside_and_came_in(name):
    scales = np.geomspace(1e-6, 0.3, 5)
    clean(shaking.shaken(solids.solid(name), scales, n=40, steps=6, seed=11))


@pytest.mark.parametrize(
    "name", [*BRICKS, *full("tiles", "pin in its hole", "bolt cast in", "heap 1")]
)
def test_solids_that_touch_or_overlap_are_their_union(name):
    clean(shaking.shaken(unions.solid(name), np.geomspace(1e-6, 0.3, 4), n=60, steps=6, seed=19))


@pytest.mark.parametrize(
    "name", [*SHOT, *full(*(n for n in SOLIDS if n not in SHOT), *solids.CLOSED_FILES)]
)
def test_segments_of_every_length_and_angle_enter_where_they_do(name):
    tally = segments.shot(solids.solid(name), 2_000, seed=12)
    clean(tally)
    assert tally.flagged <= 0.005 * tally.count


@pytest.mark.parametrize("name", [*SURFACES, *full("rational", "with creases")])
def test_tracked_feet_are_those_of_tiny_steps_or_flagged(name):
    clean(tracking.follow(tracking.tracked(name), 320, seed=13))


@pytest.mark.parametrize("name", motions.MOTIONS)
def test_ten_times_as_many_steps_end_in_the_same_contacts_and_depths(name):
    tally = motions.refine(name, finest=2)
    clean(tally)
    assert tally.notes["contacts"] > 50


@pytest.mark.parametrize("name", [*SAMPLED, *full("internal gear")])
def test_points_pressed_at_one_depth_travel_round_with_a_continuous_foot(name):
    clean(motions.slide(solids.solid(name), 20, 300, seed=14))


@pytest.mark.parametrize("name", motions.TURNS)
def test_blades_and_teeth_touch_points_where_their_arcs_say(name):
    clean(motions.turn(name, 300, 40, seed=15))


@pytest.mark.parametrize("steps", [10, 100])
def test_ways_through_a_t_end_by_the_same_wall_in_steps_of_any_length(steps):
    """Past its hollow corners, where two walls of the web are nearly as near."""
    a = np.array([[-4.8, 39.5, 4.7], [3.7, 39.0, 9.9], [2.1, 32.6, 5.0], [4.8, 38.0, -1.8]])
    b = np.array([[0.8, 25.7, 3.7], [-1.6, 5.0, -13.5], [-11.5, 39.6, 9.9], [-2.2, 28.8, 3.4]])
    slave = cg.Slave(a, area=np.ones(len(a)))
    contact = cg.Contact(
        subjects.plane_body("T-section"), slave, law=cg.PenaltyLaw(1.0), search="penetration"
    )
    state = contact.start(a)
    for share in np.linspace(0.0, 1.0, steps + 1)[1:]:
        state = contact.step(state, a + share * (b - a))
    depth = subjects.Planes(subjects.PLANE["T-section"]).nearest(b)[0]
    np.testing.assert_allclose(state.penetration, depth, rtol=0, atol=1e-9)


LOOPS = [
    ("wedge on its edge", 0.4),
    *full(
        ("block", 0.0),
        ("T-section on its web", 0.4),
        ("wedge on its wall", 0.0),
        ("cup on its rim", 0.4),
        ("cog on its teeth", 0.0),
    ),
    *full(("casting", 0.4)),
]
WANDERED = ("wedge", "lens", "block, fillets 3")


@pytest.mark.parametrize(
    "name", [*WANDERED, *full("plate", "T-section", "cup", "blade", *solids.CLOSED_FILES)]
)
def test_points_that_wander_are_pushed_by_the_wall_that_the_rule_says(name):
    scales = np.geomspace(1e-6, 0.3, 6 if FULL else 4)
    n = 20 if FULL else 10
    clean(wandering.wandered(subjects.subject(name), scales, n=n, steps=3, seed=16))


@pytest.mark.parametrize(("name", "wave"), LOOPS)
def test_round_a_closed_loop_no_work_is_done(name, wave):
    """What is stored has come back to the last bit. Followed feet lose half of it and more."""
    states = list(loops.Loop(loops.SCENES[name], wave).states(80, 7))
    done = np.diff([state.energy.work for state in states])
    assert max(state.n_contact for state in states) > 8
    assert not any(state.guard_B.any() for state in states)
    assert states[-1].n_contact == 0
    assert states[-1].energy.stored == 0.0
    assert abs(done.sum()) < 2.5e-3 * done[done > 0.0].sum()


OPEN = ("stack", "block without its bottom", "lidded pipe", "hills, mesh")


@pytest.mark.parametrize("name", [*OPEN, *full(*(n for n in open_scenes.ALL if n not in OPEN))])
def test_the_wall_that_holds_a_point_in_an_open_shell_is_that_of_the_rule(name):
    clean(opened.walked(name, 16, seed=20, steps=(1, 20), lengths=(1e-6, 0.3, 1.0)))


def test_a_run_that_fails_by_itself_is_wrong_and_none_killed_too(monkeypatch):
    own = checkpoints.make_simulation
    parent = checkpoints.os.getpid()

    def fail():
        if checkpoints.os.getpid() != parent:
            raise RuntimeError
        return own()

    monkeypatch.setattr(checkpoints, "make_simulation", fail)
    tally = checkpoints.kill(0, seed=18)
    assert tally.wrong == 2
    assert [fault["kind"] for fault in tally.faults] == [
        "a run failed by itself",
        "no run was killed",
    ]


def test_damaged_checkpoints_are_told_and_never_gone_on_from():
    tally = checkpoints.damage(300, seed=17)
    clean(tally)
    assert tally.flagged == tally.count > 250


@pytest.mark.parametrize("seed", [23, 147])
def test_steps_that_choose_themselves_agree_with_far_shorter_ones(seed):
    clean(auto.agree([seed]))


def test_a_run_that_misses_a_pulse_does_not_agree(monkeypatch):
    """The judge itself: without the kinks of loads a short pulse lies between two steps."""
    own = auto.scene(15)
    monkeypatch.setattr(cg.Simulation, "kinks", property(lambda _: ()))
    verdict = auto.judged(own)
    assert verdict.kind == "wrong"
    assert verdict.worst.relative > 0.1
