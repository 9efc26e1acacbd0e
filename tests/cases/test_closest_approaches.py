"""How near parts come to one another on their ways, and what is said of those that stay apart."""

from __future__ import annotations

import numpy as np
import pytest
from tests.cases.models import (
    DROPPED,
    PRESSED,
    case_of,
    moved,
)

import contiga as cg
from contiga.simulation.checks.approach import closest_approach
from contiga.simulation.checks.scene import MAX_TIMES, Pair


@pytest.mark.parametrize(
    ("base", "swaps"),
    [
        pytest.param(DROPPED, {"velocity": "velocity = [0, 0, -100.0]"}, id="fast"),
        pytest.param(DROPPED, {"end": "end = 2000.0"}, id="for long"),
        pytest.param(PRESSED, {"table": moved(-8000)}, id="far through"),
        pytest.param(PRESSED, {"table": moved(-150)}, id="once through"),
        pytest.param(
            PRESSED, {"table": moved(-2.001), "step": "step = 0.00625"}, id="for an instant"
        ),
    ],
)
def test_sides_that_meet_between_two_looks_are_not_said_to_stay_apart(base, swaps) -> None:
    assert "apart" not in [finding.rule for finding in case_of(base, swaps).check()]


def test_the_closest_approach_is_found_between_two_steps() -> None:
    """A ball that passes a point at a distance of 1, nearest in the middle of a long step."""
    ball = cg.Body([cg.shapes.sphere(radius=1.0, centre=(-5.0, 0.0, 0.0))])
    point = cg.Slave([[0.0, 2.0, 0.0]], area=[1.0])
    by = cg.motion.Translate([[0, 0, 0, 0], [1, 10, 0, 0]])
    simulation = cg.Simulation(
        bodies={"ball": (ball, by)},
        slaves={"point": point},
        contacts=[cg.Contact(ball, point, law=cg.PenaltyLaw(1.0))],
        end=1.0,
        step=1.0,
    )
    actual = closest_approach(Pair(simulation, simulation.contacts[0]))
    assert actual is not None
    assert actual.distance == pytest.approx(1.0, rel=1e-3)
    assert 0.99 < actual.bound <= 1.0
    assert actual.time == pytest.approx(0.5, abs=0.02)


def test_of_points_that_are_far_by_then_few_distances_are_worked_out(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A ball that is a thousand sizes away when it ends; all of the pad are about as near then."""
    from contiga.masters import nearness

    counts, own = [], nearness.gaps_and_feet

    def counted(surface, p_B, depth):
        counts.append((float(p_B[0, 2]), len(p_B)))
        return own(surface, p_B, depth)

    monkeypatch.setattr(nearness, "gaps_and_feet", counted)
    simulation = case_of(DROPPED, {"velocity": "velocity = [0, 0, 5000.0]"})
    (finding,) = (one for one in simulation.check() if one.rule == "apart")
    assert "never comes closer" in finding.text
    assert "at t = 0 ms" in finding.text
    far = [count for height, count in counts if abs(height) > 1e3]
    assert sum(far) < 100
    assert counts


def met_by(motion: object, point: list[float], end: float, step: float) -> list[str]:
    """What is said of a node that a blade on an arm of 3, or a ball about the origin, may meet."""
    turns = isinstance(motion, cg.motion.Rotate)
    shape = cg.shapes.sphere(radius=0.5 if turns else 1.0, centre=(3.0 if turns else 0.0, 0, 0))
    body, node = cg.Body([shape]), cg.Slave([point], area=[1.0], mass=[1.0])
    simulation = cg.Simulation(
        bodies={"tool": (body, motion)},
        slaves={"node": (node, cg.motion.Free())},
        contacts=[cg.Contact(body, node, law=cg.PenaltyLaw(4000.0))],
        end=end,
        step=step,
    )
    return [finding.text for finding in simulation.check()]


def many_rows(depth: float, count: int = 3001) -> np.ndarray:
    """A ball that trembles in the rows of its table, and once goes down."""
    t = np.linspace(0.0, 1.0, count)
    z = -1e-5 * (np.arange(count) % 2)
    z[1234] = -depth
    return np.column_stack([t, 0 * t, 0 * t, z])


@pytest.mark.parametrize(
    ("motion", "point", "end", "step"),
    [
        pytest.param(
            cg.motion.Rotate([[0, 0], [100, 72000]]), [-3.0, 0, 0.3], 100.0, 0.5, id="whole turns",
            marks=pytest.mark.full,
        ),
        pytest.param(
            cg.motion.Rotate([[0, 0], [2, 1440]]), [-3.0, 0, 0.3], 2.0, 0.5, id="few whole turns"
        ),
        pytest.param(
            cg.motion.Accelerated([[0, -4], [1, -4]], direction="z", velocity=[0, 0, 2.0]),
            [0, 0, 1.49], 1.0, 1.0, id="to and fro",
        ),
        pytest.param(cg.motion.Translate(many_rows(0.3)), [0, 0, -1.29], 1.0, 0.1, id="rows"),
    ],
)  # fmt: skip
def test_a_way_is_followed_along_its_path(motion, point, end, step) -> None:
    """Not from where it stands at one look to where it stands at the next."""
    assert met_by(motion, point, end, step) == []


def test_what_stays_away_is_told_over_many_rows_of_a_table() -> None:
    """A row that none of the times planned stands at: it is 1.29 - 1 - 0.2 away there."""
    (text,) = met_by(cg.motion.Translate(many_rows(0.2)), [0, 0, -1.29], 1.0, 0.1)
    told = float(text.split(" than ")[1].split(" ")[0])
    assert 0.045 < told <= 0.09


def test_a_crash_pulse_that_stays_away_is_told() -> None:
    """Half a sine over 300 ms at 10 kHz: by 100 · 0.3² / pi, half of it in the pulse and less."""
    t = np.linspace(0.0, 0.3, 3001)
    pulse = np.column_stack([t, 100.0 * np.sin(np.pi * t / 0.3)])
    (text,) = met_by(cg.motion.Accelerated(pulse, direction="z"), [0, 0, 9.0], 0.3, 0.01)
    told = float(text.split(" than ")[1].split(" ")[0])
    assert told == pytest.approx(8.0 - 9.0 / np.pi, rel=1e-2)


def test_a_way_of_more_rows_than_anybody_waits_for_is_not_spoken_of() -> None:
    far = cg.motion.Translate(many_rows(0.2, MAX_TIMES + 2))
    assert met_by(far, [0, 0, -1.29], 1.0, 0.1) == []


def test_what_is_never_met_is_told_with_a_bound() -> None:
    (text,) = met_by(cg.motion.Rotate([[0, 0], [2, 1440]]), [-3.0, 0, 3.0], 2.0, 0.5)
    told = float(text.split(" than ")[1].split(" ")[0])
    assert 1.25 < told <= 2.501


def test_points_that_move_apart_are_looked_at_and_that_is_said() -> None:
    ball = cg.Body([cg.shapes.sphere(radius=1.0)])
    node = cg.Slave([[0, 0, 2.0], [0, 0, 3.0]], area=[1.0, 1.0], mass=[1.0, 1.0])
    simulation = cg.Simulation(
        bodies={"ball": ball},
        slaves={"nodes": (node, cg.motion.Free(velocity=[[1.0, 0, 0], [0, 0, 1.0]]))},
        contacts=[cg.Contact(ball, node, law=cg.PenaltyLaw(1.0))],
        end=1.0,
        step=0.1,
    )
    (finding,) = simulation.check()
    assert finding.text.startswith("nodes, looked at 7 times, is no closer to ball than 1 ")


@pytest.mark.parametrize(("way", "told"), [(-0.5, ["apart"]), (-1.5, [])])
def test_what_is_attached_is_followed_with_its_body(way: float, told: list[str]) -> None:
    ball = cg.Body([cg.shapes.sphere(radius=1.0)])
    sled = cg.Body([cg.shapes.plane(centre=(0.0, 0.0, 4.0))])
    pad = cg.Slave([[0.0, 0.0, 2.0]], area=[1.0])
    simulation = cg.Simulation(
        bodies={
            "ball": ball,
            "sled": (sled, cg.motion.Translate([[0, 0, 0, 0], [1, 0, 0, way]])),
        },
        slaves={"pad": (pad, cg.motion.Attached("sled"))},
        contacts=[cg.Contact(ball, pad, law=cg.PenaltyLaw(1.0))],
        end=1.0,
        step=0.01,
    )
    assert [finding.rule for finding in simulation.check()] == told


class Live:
    """A motion that comes from a solver: asked for a time it goes there."""

    def __init__(self) -> None:
        self.asked: list[float] = []

    def pose(self, t: float) -> np.ndarray:
        self.asked.append(t)
        return np.eye(4)

    def twist(self, t: float) -> cg.motion.Twist:
        return cg.motion.Twist(np.zeros(3), np.zeros(3))


@pytest.mark.parametrize("free", [False, True])
def test_a_motion_of_a_user_is_asked_for_its_start_alone(free: bool) -> None:
    live = Live()
    ball = cg.Body([cg.shapes.sphere(radius=1.0)])
    dust = cg.Slave([[0.0, 0.0, 2.0]], area=[1.0], mass=[1.0])
    flying = cg.motion.Free(velocity=[0, 0, -3.0])
    simulation = cg.Simulation(
        bodies={"ball": (ball, live)},
        slaves={"dust": (dust, flying) if free else dust},
        contacts=[cg.Contact(ball, dust, law=cg.PenaltyLaw(1.0))],
        end=1.0,
        step=0.01,
    )
    simulation.check()
    assert set(live.asked) == {0.0}
