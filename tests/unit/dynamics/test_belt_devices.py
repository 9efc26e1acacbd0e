"""Devices of belts by themselves: forces beside closed forms, and what they refuse."""

from __future__ import annotations

import math

import numpy as np
import pytest

from contiga.belts import LoadLimiter, Moment, Pretensioner, Retractor
from contiga.dynamics.belt_devices import root
from contiga.dynamics.springs import Spring, SpringState
from contiga.errors import InputError

STIFFNESS = 200.0
AT = ((0.0, 0.0, 0.0), (100.0, 0.0, 0.0))
CLOSE = {"rtol": 1e-9, "atol": 1e-9}


def belt(**devices: object) -> Spring:
    return Spring(("ground", "body"), at=AT, **({"curve": STIFFNESS} | devices))  # type: ignore[arg-type]


def follow(spring: Spring, stretch: list[float], **fired: float) -> list[SpringState]:
    """The states at stretches 1 apart in time."""
    states: list[SpringState] = []
    for k, x in enumerate(stretch):
        ends = [[0.0, 0.0, 0.0], [100.0 + x, 0.0, 0.0]]
        moment = Moment(float(k), 1.0 if k else 0.0, fired)
        still = np.zeros((2, 3))
        if k == 0:
            states.append(spring.start(ends, still, moment=moment))
        else:
            states.append(spring.step(states[-1], ends, still, moment=moment))
    return states


def test_a_limiter_holds_its_force_and_keeps_what_it_let_out() -> None:
    states = follow(belt(limiter=LoadLimiter(3000.0)), [0, 10, 25, 20, 12, 5, 25, 30])
    forces = [state.force for state in states]
    # Elastic; 10 let out; unloads by the webbing until slack; loads again where it left; 5 more.
    np.testing.assert_allclose(forces, [0, 2000, 3000, 2000, 400, 0, 3000, 3000], **CLOSE)
    assert forces[2] == forces[-1] == 3000.0
    np.testing.assert_allclose(
        [state.devices.paid_out for state in states], [0, 0, 10, 10, 10, 10, 10, 15], **CLOSE
    )
    np.testing.assert_allclose(states[-1].hysteresis, 3000.0 * 15.0, **CLOSE)


def test_stages_of_a_limiter_are_the_force_over_its_travel() -> None:
    limiter = LoadLimiter([3000, 3000, 5000], travel=[0, 10, 20])
    states = follow(belt(limiter=limiter), [0, 20, 40, 60])
    # On the rising stage x − 10 − s = (3000 + 200 s)/200, then held.
    np.testing.assert_allclose([s.force for s in states], [0, 3000, 4500, 5000], **CLOSE)
    np.testing.assert_allclose([s.devices.travel for s in states], [0, 5, 17.5, 35], **CLOSE)
    lost = 3000 * 10 + 0.5 * (3000 + 5000) * 10 + 5000 * 15
    np.testing.assert_allclose(states[-1].hysteresis, lost, **CLOSE)


def test_a_retractor_pays_out_and_reels_in_by_its_spring_until_it_locks() -> None:
    spool = Retractor([[0, 5], [100, 25]], trigger="crash")
    states = follow(belt(retractor=spool), [0, 20, 50, 10, 15, 8], crash=4.0)
    # 5 + 0.2 p = 200 (x − p) until t = 4; below no length it is as at its start.
    exact = [5.0, *(5 + 0.2 * (200 * x - 5) / 200.2 for x in (20, 50, 10))]
    np.testing.assert_allclose([s.force for s in states[:4]], exact, **CLOSE)
    held = states[3].devices.paid_out
    np.testing.assert_allclose(states[4].force, 200 * (15 - held), **CLOSE)
    assert states[5].force == 0.0
    assert states[4].devices.locked == 4.0
    assert states[5].devices.paid_out == held


def test_the_spring_of_a_spool_gives_back_what_it_takes() -> None:
    spool = Retractor([[0, 5], [100, 25]], trigger="crash")
    states = follow(belt(retractor=spool), [10, 40, 10])
    webbing = [s.stored - s.devices.spool for s in states]
    np.testing.assert_allclose(webbing, [s.force**2 / (2 * STIFFNESS) for s in states], **CLOSE)
    p = states[1].devices.paid_out
    np.testing.assert_allclose(states[1].devices.spool, 5 * p + 0.1 * p * p, **CLOSE)
    np.testing.assert_allclose(states[2].stored, states[0].stored, **CLOSE)
    assert states[2].hysteresis == 0.0


def test_a_retractor_locks_where_it_is_pulled_out_fast() -> None:
    states = follow(belt(retractor=Retractor(5.0, rate=8.0)), [0, 7, 14, 23, 30])
    assert [s.devices.locked for s in states] == [math.inf, math.inf, math.inf, 3.0, 3.0]
    np.testing.assert_allclose([s.force for s in states[:4]], 5.0, **CLOSE)
    np.testing.assert_allclose(states[4].force, 5.0 + 7 * STIFFNESS, **CLOSE)


def test_a_film_pays_out_from_the_tension_it_locks_at() -> None:
    spool = Retractor(50.0, trigger="crash", film=[[0, 0], [10, 1000], [20, 4000]])
    states = follow(belt(retractor=spool), [0, 10, 15, 35, 60, 50], crash=2.0)
    # Compliances of webbing and film in series from T = 50, p = 9.75 and 0.5 of the film gone.
    first = (15 - 9.75 + 0.5) / (1 / 200 + 1 / 100)
    np.testing.assert_allclose(states[2].force, first, **CLOSE)
    second = (35 - 9.75 + 0.5 - 10 + 1000 / 300) / (1 / 200 + 1 / 300)
    np.testing.assert_allclose(states[3].force, second, **CLOSE)
    # Beyond its last row nothing more comes, and nothing goes back.
    np.testing.assert_allclose(states[4].force, 200 * (60 - 9.75 - 19.5), **CLOSE)
    np.testing.assert_allclose(states[5].force, 200 * (50 - 9.75 - 19.5), **CLOSE)


def test_film_and_limiter_add_up() -> None:
    spool = Retractor(trigger="crash", film=[[0, 0], [10, 1000], [20, 4000]])
    limiter = LoadLimiter([2000, 3000], travel=[0, 5])
    states = follow(belt(retractor=spool, limiter=limiter), [0, 5, 27, 60], crash=0.0)
    np.testing.assert_allclose(states[1].force, 5 / (1 / 200 + 1 / 100), **CLOSE)
    # At 2500: 12.5 of webbing, 10 + 5 of film, 2.5 of the limiter: 27 + 3 − 3 at 2500 · 27/30.
    force = 2000 + (27 - 10 - 10 - 1000 / 300) / (1 / 200 + 1 / 300 + 1 / 200)
    np.testing.assert_allclose(states[2].force, force, **CLOSE)
    assert states[3].force == 3000.0


def test_a_pretensioner_pulls_in_by_its_table() -> None:
    pull = Pretensioner("crash", pull=[[0, 0], [4, 8], [5, 8]])
    states = follow(belt(pretensioner=pull), [0.0] * 8, crash=1.5)
    lengths = [0, 0, 1, 3, 5, 7, 8, 8]
    np.testing.assert_allclose([s.devices.pulled_in for s in states], lengths, **CLOSE)
    np.testing.assert_allclose([s.force for s in states], [200 * p for p in lengths], **CLOSE)
    np.testing.assert_allclose(states[-1].devices.work, 100 * 8.0**2, **CLOSE)
    np.testing.assert_allclose(states[-1].stored, states[-1].devices.work, **CLOSE)


def test_a_pretensioner_of_a_force_never_lets_out() -> None:
    force = Pretensioner("crash", force=[[0, 1000], [2, 2000], [4, 0]], stroke=9.0)
    states = follow(belt(pretensioner=force), [0, 0, 0, 0, -5, -5], crash=1.0)
    np.testing.assert_allclose([s.force for s in states], [0, 1000, 1500, 1800, 800, 800], **CLOSE)
    # 10 for 2000 N are more than its stroke.
    np.testing.assert_allclose([s.devices.pulled_in for s in states], [0, 5, 7.5, 9, 9, 9], **CLOSE)


def test_a_limiter_turns_under_its_pretensioner() -> None:
    states = follow(
        belt(
            limiter=LoadLimiter(1200.0),
            pretensioner=Pretensioner("crash", pull=[[0, 0], [1, 10]]),
        ),
        [0.0, 0.0, 0.0],
        crash=1.0,
    )
    assert [s.force for s in states] == [0.0, 0.0, 1200.0]
    np.testing.assert_allclose(states[2].devices.travel, 4.0, **CLOSE)
    held = belt(
        limiter=LoadLimiter(1200.0),
        pretensioner=Pretensioner("crash", force=[[0, 2000], [9, 2000]]),
    )
    assert [s.force for s in follow(held, [0.0, 0.0], crash=0.0)] == [1200.0, 1200.0]


def test_a_pretensioner_locks_its_retractor() -> None:
    both = belt(
        retractor=Retractor(5.0, rate=1e3),
        pretensioner=Pretensioner("crash", pull=[[0, 0], [1, 10]]),
    )
    states = follow(both, [0.0, 0.0, 0.0], crash=1.0)
    assert states[1].devices.locked == 1.0
    np.testing.assert_allclose(states[2].force, 5.0 + 2000.0, **CLOSE)


def test_a_released_end_carries_nothing_and_what_it_held_is_lost() -> None:
    states = follow(belt(release="crash"), [0, 10, 12, 14, 20], crash=2.5)
    assert [s.force for s in states] == [0.0, 2000.0, 2400.0, 0.0, 0.0]
    assert states[3].devices.released == 2.5
    # With the work of the step, by the trapezoidal rule of forces 2400 and 0.
    np.testing.assert_allclose(states[4].hysteresis, 100 * 12**2 + 0.5 * 2400 * 2, **CLOSE)
    assert states[4].stored == 0.0


@pytest.mark.parametrize("steps", [1, 3, 40])
def test_devices_come_to_the_same_in_one_step_and_in_many(steps: int) -> None:
    curve = [[0, 0], [10, 500], [20, 4000]]
    spool = Retractor(20.0, trigger="crash", film=[[0, 0], [10, 1000], [20, 4000]])
    spring = belt(curve=curve, retractor=spool, limiter=LoadLimiter([2500, 3500], travel=[0, 20]))
    path = np.interp(np.linspace(0, 3, 3 * steps + 1), [0, 1, 2, 3], [0, 70, 40, 90]).tolist()
    last, few = (follow(spring, way, crash=0.0)[-1] for way in (path, [0.0, 70.0, 40.0, 90.0]))
    np.testing.assert_allclose(last.force, few.force, **CLOSE)
    np.testing.assert_allclose(last.devices[:4], few.devices[:4], **CLOSE)
    np.testing.assert_allclose(last.hysteresis, few.hysteresis, rtol=1e-9)


def test_a_root_is_found_between_pieces_and_on_flats() -> None:
    def falling(x: float) -> tuple[float, float]:
        return (4.0 - 3.0 * x, -3.0) if x < 1.0 else (1.0 - 1e-3 * (x - 1.0), -1e-3)

    np.testing.assert_allclose(root(falling, 0.0, 1e-3), 1001.0, rtol=1e-14)
    assert root(lambda x: (-1.0, -1.0), 2.0, 1.0) == 2.0
    step = root(lambda x: (1.0 if x < 0.3 else -1.0, 0.0), 0.0, 10.0)
    np.testing.assert_allclose(step, 0.3, rtol=1e-14)


@pytest.mark.parametrize(
    ("make", "told"),
    [
        (lambda: Retractor(5.0), "lock: a retractor that never locks holds nobody"),
        (lambda: Retractor([[0, 5], [10, 4]], rate=1.0), "spool: the force falls at row 1"),
        (lambda: Retractor(rate=1.0, film=[[1, 0], [2, 5]]), "film: what a film lets out"),
        (lambda: Retractor(rate=1.0, film=[[0, 0], [2, 0]]), "film: what a film lets out"),
        (
            lambda: Retractor(rate=1.0, film=[[0, 0], [0, 5]]),
            "film: the values of paid out go back",
        ),
        (lambda: Retractor(rate=0.0), "rate: must be positive"),
        (lambda: LoadLimiter([4000, 3000], travel=[0, 10]), "force: the force falls at row 1"),
        (lambda: LoadLimiter([4000, 5000], travel=[0, 0]), "force: the values of travel go back"),
        (lambda: LoadLimiter([4000, 5000]), "travel: needs a travel for each force"),
        (lambda: LoadLimiter(4000, travel=[3]), "travel: must start at 0"),
        (lambda: LoadLimiter(0.0), "force: must be positive"),
        (lambda: Pretensioner("a"), "pull: must be given one of pull and force"),
        (lambda: Pretensioner("a", pull=[[0, 1], [1, 0]]), "pull: the length falls at row 1"),
        (lambda: Pretensioner("a", force=[[0, -1]]), "force: must not be negative"),
        (lambda: Pretensioner("a", pull=[[0, 0]], stroke=1.0), "stroke: is that of a force"),
        (lambda: belt(limiter=4000.0), r"loadlimiter\[0\]: must be"),
        (lambda: belt(limiter=LoadLimiter(1.0), damping=1.0), "damping: webbing with a device"),
        (
            lambda: belt(limiter=LoadLimiter(1.0), curve=None, damping=1.0),
            "curve: is missing: a device needs webbing",
        ),
        (
            lambda: belt(limiter=LoadLimiter(1.0), curve=[[0, 0], [1, 5], [2, 4]]),
            "curve: the webbing that a device is on",
        ),
        (lambda: belt(limiter=LoadLimiter(1.0), curve=[[0, 1], [1, 5]]), "carries nothing at rest"),
    ],
)
def test_devices_that_make_no_sense_are_refused(make, told) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(InputError, match=told):
        make()
