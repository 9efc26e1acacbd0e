"""Belts with devices in a simulation: a sled, its ledger, rings, resumed runs, what is refused."""

from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from tests.unit.simulation.sameness import same_states

import contiga as cg
from contiga.belts import LoadLimiter, Pretensioner, Retractor, SlipRing
from contiga.errors import InputError

HELD = ("y", "z", "rx", "ry", "rz")
BALL = [cg.shapes.sphere(radius=0.05)]


def mass(velocity: float = 0.0) -> cg.motion.Free:
    return cg.motion.Free(40.0, inertia=np.eye(3), velocity=(velocity, 0.0, 0.0), hold=HELD)


def sled(
    step: float | str = 1e-4, end: float = 0.06, delay: float = 0.004, **options: object
) -> cg.Simulation:
    """A mass on a sled that is braked, on webbing with all devices, fired by the sled."""
    brake = cg.motion.Accelerated(
        [[0.0, 0.0], [0.005, -200.0], [0.2, -200.0]], direction="x", velocity=(15.0, 0.0, 0.0)
    )
    belt = cg.Spring(
        ("sled", "mass"),
        at=[[-1.0, 0.0, 0.0], [0.0, 0.0, 0.0]],
        curve=[[0.0, 0.0], [0.1, 3000.0], [0.2, 9000.0]],
        unloading=[[0.0, 0.0], [0.1, 500.0], [0.2, 2000.0]],
        hysteresis_slope=1e5,
        name="belt",
        retractor=Retractor(10.0, trigger="crash", film=[[0.0, 0.0], [0.02, 2000.0]]),
        limiter=LoadLimiter([4000.0, 4000.0, 6000.0], travel=[0.0, 0.2, 0.25]),
        pretensioner=Pretensioner("crash", pull=[[0.0, 0.0], [0.008, 0.06]]),
        **options,  # type: ignore[arg-type]
    )
    sensor = cg.Sensor("crash", "sled", trigger=cg.Trigger("ax", below=-50.0, delay=delay))
    return cg.Simulation(
        bodies={"sled": (cg.Body(BALL), brake), "mass": (cg.Body(BALL), mass(15.0))},
        slaves={},
        contacts=[],
        springs=[belt],
        sensors=[sensor],
        end=end,
        step=step,
        units=("m", "kg", "s"),
    )


def ring(*, friction: float = 0.3, turn: float = 90.0, **options: object) -> cg.Simulation:
    """A mass that pulls webbing round a ring: from the ground up to it, and on to the mass."""
    angle = math.radians(180.0 - turn)
    way = np.array([math.cos(angle), math.sin(angle), 0.0])
    pulled = cg.motion.Free(
        40.0, inertia=np.eye(3), velocity=5.0 * way, centre=way, hold=("z", "rx", "ry", "rz")
    )
    first = cg.Spring(("ground", "post"), at=[[1, 0, 0], [0, 0, 0]], curve=2e5, name="first")
    second = cg.Spring(("post", "mass"), at=[[0, 0, 0], way], curve=3e5, name="second")
    given: dict[str, object] = {
        "slip_rings": [SlipRing(("first", "second"), friction=friction, name="ring")],
        "springs": [first, second],
        "end": 0.015,
        "step": 2e-5,
    }
    return cg.Simulation(
        bodies={
            "post": cg.Body(BALL),
            "mass": (cg.Body([cg.shapes.sphere(radius=0.05, centre=way)]), pulled),
        },
        slaves={},
        contacts=[],
        units=("m", "kg", "s"),
        **(given | options),  # type: ignore[arg-type]
    )


def test_a_mass_is_stopped_by_a_limiter_over_its_energy_by_the_force() -> None:
    belt = cg.Spring(
        ("ground", "mass"),
        at=[[-1, 0, 0], [0, 0, 0]],
        curve=1e6,
        name="belt",
        limiter=LoadLimiter(4000.0),
    )
    history = (
        cg.Simulation(
            bodies={"mass": (cg.Body(BALL), mass(10.0))},
            slaves={},
            contacts=[],
            springs=[belt],
            end=0.11,
            step=2e-5,
        )
        .run()
        .history
    )
    elastic = 4000.0 / 1e6
    np.testing.assert_allclose(history["belt.paid_out"][-1], 0.5 - 0.5 * elastic, rtol=1e-6)
    np.testing.assert_allclose(history["mass.x"].max(), 0.5 + 0.5 * elastic, rtol=1e-6)
    assert history["belt.force"].max() == 4000.0
    assert history["mass.vx"].min() > -1.0


def test_devices_on_a_sled_change_at_their_times_and_say_so() -> None:
    result = sled().run()
    history, told = result.history, result.summary
    # −50 of −40000 t is passed at 1.25 ms, and the delay is 4.
    assert told["sensors"]["crash"]["fired"] == pytest.approx(0.0053)
    assert told["springs"]["belt"]["locked"] == pytest.approx(0.0053)
    pulled = np.interp(history["time"] - 0.00525, [0.0, 0.008], [0.0, 0.06])
    np.testing.assert_allclose(history["belt.pulled_in"], pulled, atol=1e-12)
    before = history["time"] < 0.0052
    np.testing.assert_allclose(history["belt.force"][before], 10.0, rtol=1e-9)
    held = (history["belt.travel"] > 0.05) & (np.diff(history["belt.travel"], prepend=0.0) > 0.0)
    np.testing.assert_array_equal(
        history["belt.force"][held & (history["belt.travel"] < 0.21)], 4000.0
    )
    assert {told["columns"][f"belt.{c}"] for c in ("paid_out", "travel", "pulled_in")} == {"m"}
    assert told["columns"]["belt.energy_pretension"] == "J"


def test_the_ledger_of_devices_closes_with_the_square_of_the_step() -> None:
    errors = []
    for step in (2e-4, 1e-4, 5e-5, 2.5e-5):
        history = sled(step).run().history
        errors.append(np.abs(history["energy.error"]).max() / history["energy.total"].max())
    assert errors[0] < 1e-5
    assert errors[-1] < errors[0] / 30.0
    automatic = sled("auto").run().history
    assert np.abs(automatic["energy.error"]).max() < 1e-5 * automatic["energy.total"].max()


@pytest.mark.parametrize("delay", [0.0, 3e-5])
def test_what_fires_within_a_step_acts_at_its_end(delay: float) -> None:
    history = sled(1e-4, 0.02, delay).run().history
    # −50 of −40000 t is passed at 1.25 ms.
    since = history["time"] - 0.00125 - delay
    pulled = np.interp(since, [0.0, 0.008], [0.0, 0.06])
    assert pulled[since > 0.0][0] > 0.0
    np.testing.assert_allclose(history["belt.pulled_in"], pulled, atol=1e-12)
    np.testing.assert_array_equal(history["crash.fired"], since >= 0.0)
    released = sled(1e-4, 0.01, delay, release="crash").run().history
    assert not released["belt.force"][released["time"] > 0.00125 + delay].any()


def test_one_trigger_fires_another_in_the_same_step() -> None:
    """A released mass loses its acceleration at once, which a second sensor sees."""
    belt = cg.Spring(("ground", "mass"), at=[[-1, 0, 0], [0, 0, 0]], curve=1e4, length=0.9,
                     name="belt", release="first")  # fmt: skip
    other = cg.Spring(("ground", "other"), at=[[-1, 1, 0], [0, 1, 0]], curve=1e4, length=0.9,
                      name="other belt", release="second")  # fmt: skip
    still = cg.motion.Free(1.0, inertia=np.eye(3), hold=HELD, centre=(0.0, 1.0, 0.0))
    sensors = [
        cg.Sensor("first", "mass", trigger=cg.Trigger("vx", below=-0.05)),
        cg.Sensor("second", "mass", trigger=cg.Trigger("ax", above=-1.0)),
    ]
    history = (
        cg.Simulation(
            bodies={"mass": (cg.Body(BALL), mass()), "other": (cg.Body(BALL), still)},
            slaves={},
            contacts=[],
            springs=[belt, other],
            sensors=sensors,
            end=0.005,
            step=1e-4,
        )
        .run()
        .history
    )
    np.testing.assert_array_equal(history["belt.released"], history["other belt.released"])
    assert history["belt.released"].sum() > 10


def test_steps_that_choose_themselves_end_where_devices_fire() -> None:
    history = sled("auto").run().history
    for kink in (0.00525, 0.01325):
        assert np.abs(history["time"] - kink).min() < 1e-9


def test_a_released_end_lets_go_and_the_ledger_closes() -> None:
    history = sled(5e-5, release="crash").run().history
    after = history["time"] > 0.0054
    assert not history["belt.force"][after].any()
    np.testing.assert_array_equal(history["belt.released"], history["time"] >= 0.00525)
    assert np.abs(history["energy.error"]).max() < 1e-9 * history["energy.total"].max()


@pytest.mark.parametrize("turn", [30.0, 90.0, 180.0])
def test_tensions_at_a_ring_are_in_the_ratio_of_the_capstan(turn: float) -> None:
    history = ring(turn=turn).run().history
    slips = np.diff(history["ring.slipped"], prepend=0.0) > 0.0
    assert slips.sum() > 100
    ratio = history["second.force"][slips] / history["first.force"][slips]
    np.testing.assert_allclose(ratio, np.exp(0.3 * history["ring.angle"][slips]), rtol=1e-12)
    assert history["ring.angle"][0] == pytest.approx(math.radians(turn), rel=1e-12)


def test_webbing_at_a_ring_sticks_and_slips_back_and_what_slips_is_lost() -> None:
    history = ring(turn=180.0, end=0.045).run().history
    steps = np.diff(history["ring.slipped"])
    assert (steps > 0.0).any()
    assert (steps < 0.0).any()
    lost = history["ring.energy_friction"]
    assert (np.diff(lost) >= -1e-12).all()
    np.testing.assert_array_equal(lost, history["energy.friction"])
    assert np.abs(history["energy.error"]).max() < 1e-5 * history["energy.total"].max()
    free = ring(turn=180.0, friction=0.0).run().history
    np.testing.assert_allclose(free["first.force"], free["second.force"], rtol=1e-12, atol=1e-9)
    assert np.abs(free["ring.energy_friction"]).max() < 1e-12


def test_rings_in_a_row_all_keep_their_ratios() -> None:
    at = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]
    names = ["ground", "one", "two", "mass"]
    segments = [
        cg.Spring(pair, at=places, curve=stiffness, name=f"segment_{k}")
        for k, (pair, places, stiffness) in enumerate(
            zip(pairwise(names), pairwise(at), (1e5, 3e6, 2e5), strict=True)
        )
    ]
    rings = [
        SlipRing(("segment_0", "segment_1"), friction=0.2, name="ring_0"),
        SlipRing(("segment_1", "segment_2"), friction=0.1, name="ring_1"),
    ]
    pulled = cg.motion.Free(
        40.0, inertia=np.eye(3), velocity=(-5.0, 0.0, 0.0), centre=at[3], hold=HELD
    )
    history = (
        cg.Simulation(
            bodies={
                "one": cg.Body(BALL),
                "two": cg.Body(BALL),
                "mass": (cg.Body([cg.shapes.sphere(radius=0.05, centre=at[3])]), pulled),
            },
            slaves={},
            contacts=[],
            springs=segments,
            slip_rings=rings,
            end=0.005,
            step=5e-5,
        )
        .run()
        .history
    )
    forces = [history[f"segment_{k}.force"][1:] for k in range(3)]
    np.testing.assert_allclose(forces[1] / forces[0], math.exp(0.2 * math.pi / 2), rtol=1e-9)
    np.testing.assert_allclose(forces[2] / forces[1], math.exp(0.1 * math.pi / 2), rtol=1e-9)


def test_a_limiter_acts_through_a_ring() -> None:
    first = cg.Spring(
        ("ground", "post"),
        at=[[1, 0, 0], [0, 0, 0]],
        curve=2e5,
        name="first",
        retractor=Retractor(10.0, rate=2.0),
        limiter=LoadLimiter(1000.0),
    )
    second = cg.Spring(("post", "mass"), at=[[0, 0, 0], [1, 0, 0]], curve=3e5, name="second")
    history = ring(turn=180.0, springs=[first, second]).run().history
    assert history["first.force"][0] == 10.0
    assert history["second.force"].max() == pytest.approx(1000.0 * math.exp(0.3 * math.pi))
    assert history["first.force"].max() == 1000.0


@pytest.mark.parametrize("stop", [30, 70, 200])
def test_a_run_that_was_killed_goes_on_with_the_same_bits(tmp_path: Path, stop: int) -> None:
    def kill(done: int, total: int, touching: int) -> None:
        if done == stop:
            raise KeyboardInterrupt

    for simulation in (sled(end=0.03), ring(turn=90.0, end=0.006)):
        whole = simulation.run()
        folder = tmp_path / str(len(simulation.springs))
        with pytest.raises(KeyboardInterrupt):
            simulation.run(folder, progress=kill)
        resumed = simulation.run(folder, resume=True)
        same_states(whole.state, resumed.state)
        assert whole.state.triggers == resumed.state.triggers
        assert whole.state.slip_rings == resumed.state.slip_rings
        for name, column in whole.history.items():
            if not name.endswith("wall_time"):
                np.testing.assert_array_equal(column, resumed.history[name], err_msg=name)


def test_what_does_not_fit_together_is_refused() -> None:
    with pytest.raises(InputError, match="spring 'belt': release: trigger: no sensor of this name"):
        sled(release="bang")
    two = cg.Spring(("mass", "ground"), at=[[0, 0, 0], [0, 3, 0]], curve=1.0, name="two")
    three = cg.Spring(("post", "ground"), at=[[0, 0, 0], [0, 3, 0]], curve=1.0, name="three")
    first, second = ring().springs.values()
    with pytest.raises(InputError, match="its segments do not meet: they end at 'ground'-'post'"):
        ring(springs=[first, two], slip_rings=[SlipRing(("first", "two"))])
    with pytest.raises(InputError, match="no spring of this name is there; found 'third'"):
        ring(slip_rings=[SlipRing(("first", "third"))])
    both = [SlipRing(("first", "second")), SlipRing(("first", "three"))]
    with pytest.raises(InputError, match="'first' is in slip ring 'first-second' with this"):
        ring(springs=[first, second, three], slip_rings=both)
    damped = cg.Spring(
        ("post", "ground"), at=[[0, 0, 0], [0, 3, 0]], curve=1.0, damping=1.0, name="three"
    )
    with pytest.raises(InputError, match="spring 'three': damping: webbing with a slip ring has"):
        ring(springs=[first, second, damped], slip_rings=[SlipRing(("first", "three"))])
    with pytest.raises(InputError, match=r"slip_rings\['mass'\]: name: must have a name of its"):
        ring(slip_rings=[SlipRing(("first", "second"), name="mass")])
    blind = cg.Sensor("crash", "sled")
    base = sled()
    with pytest.raises(InputError, match="retractor: trigger: has no trigger; found 'crash'"):
        cg.Simulation(
            bodies=base.bodies, slaves={}, contacts=[], springs=base.springs, sensors=[blind],
            end=0.1, step=0.01,
        )  # fmt: skip


def test_a_segment_between_two_rings_has_no_end_for_devices() -> None:
    at = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]
    names = ["ground", "post", "mass", "ground"]
    segments = [
        cg.Spring(
            pair, at=places, curve=1.0, name=f"s{k}", limiter=LoadLimiter(1.0) if k == 1 else None
        )
        for k, (pair, places) in enumerate(zip(pairwise(names), pairwise(at), strict=True))
    ]
    rings = [SlipRing(("s0", "s1")), SlipRing(("s1", "s2"))]
    with pytest.raises(InputError, match="spring 's1': has slip rings at both ends, and no end"):
        ring(springs=segments, slip_rings=rings)
