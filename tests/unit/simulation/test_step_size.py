"""Steps that choose themselves: what they may not miss, and where they may be long."""

from __future__ import annotations

import numpy as np
import pytest
from tests.sample import full
from tests.scenes import box

import contiga as cg
from contiga.dynamics.stepping import AutoSteps
from contiga.errors import InputError, RunError
from contiga.laws.law import Law
from contiga.simulation.checkpoint import read_checkpoint
from contiga.simulation.critical import limit_of
from contiga.simulation.reasons import Reason
from contiga.simulation.step_columns import COLUMNS

Free = cg.motion.Free
G = 9.81


def reasons(result: cg.Result) -> dict[str, int]:
    """How often each had the last word."""
    told: dict[str, int] = {}
    for one in result.summary["step_reasons"]["reasons"]:
        told[one["reason"]] = told.get(one["reason"], 0) + one["steps"]
    return told


def grid(n: int, half: float, height: float = 0.0) -> np.ndarray:
    x, y = np.meshgrid(*2 * [np.linspace(-half, half, n) + 0.01 * half])
    return np.column_stack([x.ravel(), y.ravel(), np.full(n * n, height)])


def test_an_impulse_between_two_steps_is_not_lost() -> None:
    ball = cg.Body([cg.shapes.sphere(radius=1.0)])
    push = [[0, 0, 0, 0], [20.13, 0, 0, 0], [20.18, 1e4, 0, 0], [20.23, 0, 0, 0], [100, 0, 0, 0]]
    simulation = cg.Simulation(
        bodies={"ball": (ball, Free(mass=2.0, hold=["rx", "ry", "rz"]))},
        slaves={},
        contacts=[],
        end=100.0,
        step="auto",
        loads=[cg.Load("ball", force=push)],
    )
    result = simulation.run()
    assert result.history["ball.vx"][-1] == pytest.approx(1e4 * 0.05 / 2.0, rel=1e-12)
    assert {20.13, 20.18, 20.23} <= set(result.history["time"].tolist())
    # what it works is what moves, within the pulse too
    energy = 0.5 * 2.0 * result.history["ball.vx"] ** 2
    np.testing.assert_allclose(result.history["energy.external"], energy, rtol=1e-9)
    assert reasons(result)["kink"] >= 3


def resting(tilt: float = 0.0, **more) -> cg.Simulation:
    """A block on a damped bed, let go a little above where it comes to rest; m, kg, s."""
    block = box((-0.2, -0.2, 0.0), (0.2, 0.2, 0.1))
    bed = cg.Slave(grid(5, 0.18, -1e-4), area=np.full(25, 1e-3))
    law = cg.PenaltyLaw(4e3, damping=16.0)
    contact = cg.Contact(block, bed, law=law, friction=cg.Coulomb(0.5))
    motion = Free(block.mass_properties(500.0))
    down = np.array([np.sin(tilt), 0.0, -np.cos(tilt)])
    own = {"end": 4.0, "step": "auto", "gravity": G * down} | more
    return cg.Simulation(
        bodies={"block": (block, motion)}, slaves={"bed": bed}, contacts=[contact], **own
    )


def test_at_rest_steps_are_nine_tenths_of_the_critical_one() -> None:
    simulation = resting()
    result = simulation.run()
    critical = limit_of(simulation, result.state).critical
    late = result.history["time"] > 2.0
    assert late.sum() < 1.1 * 2.0 / (0.9 * critical)
    assert len(late) < 1000
    assert reasons(result)["critical"] > 0.9 * late.sum()
    assert result.summary["energy"]["relative"] < 1e-3
    # it presses as its weight says
    force = result.history["force"][-1]
    assert force == pytest.approx(8.0 * G, rel=1e-6)


def test_an_impact_is_followed_as_finely_as_ever() -> None:
    ball, point = cg.Body([cg.shapes.sphere(radius=1.0)]), cg.Slave([[0, 0, -1.01]], area=[1.0])
    motion = Free(mass=1.0, velocity=[0, 0, -1.0], hold=["rx", "ry", "rz"])
    contact = cg.Contact(ball, point, law=cg.PenaltyLaw(100.0))
    simulation = cg.Simulation(
        bodies={"ball": (ball, motion)}, slaves={"s": point}, contacts=[contact], end=1.0,
        step="auto",
    )  # fmt: skip
    history = simulation.run().history
    assert history["max_penetration"].max() == pytest.approx(0.1, rel=1e-4)
    assert history["ball.vz"][-1] == pytest.approx(1.0, rel=1e-4)


SOFTENING = [[0, 0], [0.01, 3e3], [0.06, 5e3]]


def scraping(kind: type = cg.ForceLaw, **time) -> cg.Simulation:
    """A ball that strikes a pad by a law whose forces are the gradient of nothing; m, kg, s."""
    ball = cg.Body([cg.shapes.sphere(radius=0.0825, centre=(0, 0, 0.085))])
    motion = Free(ball.mass_properties(1900.0), velocity=[4.7, 0.0, -10.0])
    pad = cg.Slave(grid(31, 0.2), area=np.full(961, 1e-4))
    law = kind(SOFTENING, share="penetration")
    contact = cg.Contact(ball, pad, law=law, friction=cg.Coulomb(0.3))
    return cg.Simulation(
        bodies={"ball": (ball, motion)}, slaves={"pad": pad}, contacts=[contact], **time
    )


def test_forces_of_no_gradient_make_no_step_short_and_the_cause_is_named() -> None:
    result = scraping(end=0.015, step="auto").run()
    assert len(result.history["time"]) < 700
    (warning,) = (text for text in result.summary["warnings"] if text.startswith("energy"))
    assert "the gradient of no energy" in warning
    assert "shorter ones would not reduce" in warning
    assert "auto" not in warning
    assert result.summary["step_reasons"]["let_pass"] > 20


def test_nothing_but_stability_and_ways_goes_below_the_shortest_step() -> None:
    shortest = 1e-5
    result = scraping(stepping=AutoSteps(0.0, 0.003, shortest=shortest)).run()
    steps = np.diff(result.history["time"])[:-2]  # the last two share what is left
    assert steps.min() >= 0.999 * shortest
    assert reasons(result)["shortest"] > 0


class UnjudgedForce(cg.ForceLaw):
    """Its energy judges no step."""

    has_energy = False


def test_where_no_shorter_step_was_tried_none_is_told_of() -> None:
    result = scraping(UnjudgedForce, end=0.003, step="auto").run().summary["step_reasons"]
    assert result["let_pass"] == 0
    assert result["tries"] < 300


def falling(law: Law, **more) -> cg.Simulation:
    plane = cg.Body([cg.shapes.plane(width=4, length=4)])
    node = cg.Slave([[0.1, 0.2, 0.5]], area=[1.0], mass=[2.0])
    own = {"end": 4.0, "step": "auto", "gravity": [0.0, 0.0, -10.0]} | more
    return cg.Simulation(
        bodies={"plane": plane},
        slaves={"node": (node, Free(velocity=[0, 0, -1.0]))},
        contacts=[cg.Contact(plane, node, law=law)],
        **own,
    )


def test_a_law_without_an_energy_ends_under_gravity() -> None:
    history = falling(cg.AdaptiveLaw()).run().history
    assert len(history["time"]) < 500
    assert history["n_contact"].max() == 1


class Unjudged(cg.PenaltyLaw):
    """Its energy judges no step."""

    has_energy = False


def test_a_law_without_an_energy_keeps_its_stiffness() -> None:
    mine, ours = (falling(law, step=1e-3, end=0.24) for law in (Unjudged(2e4), cg.PenaltyLaw(2e4)))
    states = [one.run().state for one in (mine, ours)]
    limits = [
        limit_of(one, state, "lasting") for one, state in zip((mine, ours), states, strict=True)
    ]
    assert limits[0] == limits[1]
    assert limits[0].critical == pytest.approx(2.0 * np.sqrt(2.0 / 2e4))


def test_where_the_stiffness_follows_the_step_and_no_step_is_stable_the_run_says_so() -> None:
    with pytest.raises(RunError, match=r"no step is stable for contact 'plane-node'.*scale"):
        falling(cg.AdaptiveLaw(scale=5.0)).run()
    assert falling(cg.AdaptiveLaw(scale=5.0), allow_unstable=True, end=0.5).run()


def panels(thick: float, *heights: float) -> cg.Body:
    """Closed panels one under the other, as one body."""
    boxes = (box((-30.0, -30.0, z - thick), (30.0, 30.0, z)) for z in heights)
    return cg.Body([patch for one in boxes for patch in one.patches])


@pytest.mark.parametrize(
    ("gap", "panel", "thick"),
    [
        (6.0, panels(1.0, 0.0), 1.0),
        *full(*((gap, panels(1.0, 0.0), 1.0) for gap in (5.0, 5.5, 7.0))),
        # thinner than a hundredth of a step's way, which may pass two of them
        *full((6.0, panels(0.01, 0.0), 0.01)),
        (6.0, panels(0.01, 0.0, -0.3), 0.01),
    ],
)
def test_a_thin_panel_stops_what_would_be_through_in_one_step(
    gap: float, panel: cg.Body, thick: float
) -> None:
    m, v, deep = 4540.0, 11.1, 0.45 * thick
    face = cg.Slave(grid(5, 20.0, gap), area=np.full(25, 1.0))
    carrier = cg.Body([cg.shapes.sphere(radius=45.0, centre=(0.2, 0.2, gap + 50.0))])
    motion = Free(mass=m, inertia=4e6 * np.eye(3), centre=[0.2, 0.2, gap + 50], velocity=[0, 0, -v])
    contact = cg.Contact(panel, face, law=cg.PenaltyLaw(m * v * v / deep**2 / 25))
    simulation = cg.Simulation(
        bodies={"panel": panel, "carrier": (carrier, motion)},
        slaves={"face": (face, cg.motion.Attached("carrier"))},
        contacts=[contact],
        end=40.0,
        step="auto",
    )
    result = simulation.run()
    assert result.history["carrier.vz"][-1] == pytest.approx(v, rel=1e-3)
    assert result.history["max_penetration"].max() == pytest.approx(deep, rel=1e-3)
    assert len(result.history["time"]) < 800


def struck(body: cg.Body, motion: object, point: list[float], **time) -> cg.Result:
    """A free mass that what a table drives may hit."""
    node = cg.Slave([point], area=[1.0], mass=[1.0])
    return cg.Simulation(
        bodies={"tool": (body, motion)},
        slaves={"node": (node, Free())},
        contacts=[cg.Contact(body, node, law=cg.PenaltyLaw(4000.0))],
        **time,
    ).run()


def test_a_hammer_that_strikes_within_one_step_is_seen() -> None:
    hammer, t0, w = cg.Body([cg.shapes.sphere(radius=1.0)]), 20.13, 0.4
    blow = cg.motion.Translate(
        [[0, 0, 0, 0], [t0, 0, 0, 0], [t0 + w / 2, 0, 0, -0.3], [t0 + w, 0, 0, 0], [100, 0, 0, 0]]
    )
    result = struck(hammer, blow, [0, 0, -1.05], end=100.0, step="auto")
    # a heavy hammer at 1.5 sends it off at twice that
    assert result.state.slaves["node"].velocities[0] == pytest.approx([0, 0, -3.0], abs=0.01)


@pytest.mark.full
def test_a_rotor_that_turns_wholly_in_a_step_is_seen() -> None:
    blade = cg.Body([cg.shapes.sphere(radius=0.5, centre=(3.0, 0, 0))])
    turning = cg.motion.Rotate([[0, 0], [2, 1440]], axis="z")
    result = struck(blade, turning, [-3.0, 0, 0.3], end=2.0, step="auto")
    fine = struck(blade, turning, [-3.0, 0, 0.3], end=2.0, step=2e-4)
    velocities = [one.state.slaves["node"].velocities[0] for one in (result, fine)]
    np.testing.assert_allclose(*velocities, atol=0.02)
    assert reasons(result)["way"] + reasons(result)["turn"] > 20


def creeping(v0: float, step: float | str) -> cg.Simulation:
    """A mass under its weight of 10, pulled by a third of its viscous friction."""
    plane = cg.Body([cg.shapes.plane(width=40, length=40)])
    node = cg.Slave([[0.1, 0.2, -0.01]], area=[1.0], mass=[1.0])
    law, friction = cg.PenaltyLaw(1000.0), cg.ViscousFriction(0.3, v0)
    contact = cg.Contact(plane, node, law=law, friction=friction, search="penetration")
    return cg.Simulation(
        bodies={"p": plane}, slaves={"s": (node, Free())}, contacts=[contact], end=0.5, step=step,
        gravity=[1.0, 0, -10.0],
    )  # fmt: skip


@pytest.mark.parametrize("v0", [0.01, *full(1e-3)])
def test_viscous_friction_is_part_of_the_critical_step(v0: float) -> None:
    run = creeping(v0, "auto").run(keep=1)
    (x0, t0), (x1, t1) = (
        (s.slaves["s"].points[0, 0], s.time) for s in (run.states[-200], run.state)
    )
    assert (x1 - x0) / (t1 - t0) == pytest.approx(v0 * np.arctanh(1.0 / 3.0), rel=0.01)
    with pytest.raises(RunError, match="viscous friction of contact 'p-s'"):
        creeping(v0, 0.01).run()


def test_a_resumed_run_takes_the_same_steps(tmp_path) -> None:
    seen: list[int] = []

    def stop(*_: int) -> None:
        seen.append(1)
        if len(seen) > 60:
            raise KeyboardInterrupt

    simulation = scraping(end=0.005, step="auto")
    whole = simulation.run()
    with pytest.raises(KeyboardInterrupt):
        simulation.run(tmp_path / "out", progress=stop)
    kept = read_checkpoint(tmp_path / "out" / "checkpoint.h5", simulation)
    assert kept.state.leak > 0.0
    again = simulation.run(tmp_path / "out", resume=True)
    for name in ("time", *COLUMNS, "ball.x"):
        np.testing.assert_array_equal(whole.history[name], again.history[name])


def test_the_shortest_step_may_be_given_and_is_not_above_the_largest() -> None:
    with pytest.raises(InputError, match=r"shortest.*not above the largest"):
        AutoSteps(0.0, 1.0, largest=0.1, shortest=0.2)
    assert AutoSteps(0.0, 1.0, shortest=1e-3).shortest == 1e-3


def test_reasons_keep_their_numbers() -> None:
    """Histories hold them."""
    names = (
        "LARGEST GROWTH SAMPLE CRITICAL SWING TURN KINK END WAY CROSSING STIFFER ENERGY SHORTEST"
    )
    assert [reason.name for reason in Reason] == names.split()
    assert all(reason.text for reason in Reason)


def flat_at_rest(step: float | str) -> cg.Simulation:
    """A box of 10 kg on a force law, pressed in as far as its weight asks, hardly turning; SI."""
    block, m, k = box((-0.2, -0.2, 0.0), (0.2, 0.2, 0.1)), 10.0, 1e4
    deep = m * G / k / 1.004**2  # 25 nodes: λ_max and the sum of the shares are 0.4 % more
    bed = cg.Slave(grid(5, 0.18, deep), area=np.full(25, 1e-3))
    motion = Free(block.mass_properties(m / 0.016), spin=[1e-5, 2e-5, 0.0])
    return cg.Simulation(
        bodies={"block": (block, motion)},
        slaves={"bed": bed},
        contacts=[cg.Contact(block, bed, law=cg.ForceLaw(k), search="penetration")],
        end=0.5,
        step=step,
        gravity=[0.0, 0.0, -G],
    )


def test_a_flat_box_on_a_force_law_stays_at_rest_below_its_critical_step() -> None:
    """What shares one force between points that move against each other is stiffer than it."""
    simulation = flat_at_rest(1e-6)
    critical = limit_of(simulation, simulation.start()).critical
    for step in (0.9 * critical, "auto"):
        result = flat_at_rest(step).run()
        spin = [np.abs(result.history[f"block.w{axis}"]).max() for axis in "xy"]
        assert max(spin) < 0.01  # it swings with about what it was given, at that frequency
        assert np.abs(result.history["block.vz"]).max() < 1e-3
    assert len(result.history["time"]) < 1.5 * 0.5 / (0.9 * critical)
    # its moments go from point to point faster than steps follow
    told = [text for text in result.summary["warnings"] if text.startswith("step: ")]
    (text,) = (text for text in told if "not right to phase" in text)
    assert result.history["step.single"].max() > 0.5
    assert 0.0 < float(text.split("time.largest of ")[1].split(" ")[0]) < 0.5 * critical
    with pytest.raises(RunError, match="longer than the critical"):
        flat_at_rest(1.1 * critical).run()


def test_what_has_passed_flies_off_in_long_steps() -> None:
    """Though its known distance from what it has passed lessens as it flies."""
    ball, pad = cg.Body([cg.shapes.sphere(radius=0.08, centre=(0, 0, 0.085))]), grid(11, 0.1)
    motion = Free(ball.mass_properties(1900.0), velocity=[300.0, 0.0, -1e4])
    slave = cg.Slave(pad, area=np.full(len(pad), 4e-4))
    contact = cg.Contact(ball, slave, law=cg.PenaltyLaw(1e5))
    result = cg.Simulation(
        bodies={"ball": (ball, motion)}, slaves={"pad": slave}, contacts=[contact], end=0.015,
        step="auto",
    ).run()  # fmt: skip
    assert result.history["n_contact"].max() > 0
    assert len(result.history["time"]) < 300


def test_a_damper_sees_the_velocity_that_a_pulse_gives() -> None:
    ball = cg.Body([cg.shapes.sphere(radius=1.0)])
    push = [[0, 0, 0, 0], [20.0, 0, 0, 0], [20.05, 1e4, 0, 0], [20.1, 0, 0, 0], [100, 0, 0, 0]]
    damper = cg.Spring(
        ("ball", "ground"), at=[[0, 0, 0], [-9e3, 0, 0]], damping=0.1, curve=1e-3, name="d"
    )
    simulation = cg.Simulation(
        bodies={"ball": (ball, Free(mass=2.0, hold=["rx", "ry", "rz"]))}, slaves={}, contacts=[],
        end=100.0, step="auto", loads=[cg.Load("ball", force=push)], springs=[damper],
    )  # fmt: skip
    history = simulation.run().history
    damping = history["d.force"] - 1e-3 * history["d.elongation"]
    np.testing.assert_allclose(damping, 0.1 * history["ball.vx"], atol=2e-3 * damping.max())


class OwnFriction:
    """A friction of a user's own that does as `ViscousFriction` does."""

    has_rate = True

    def __init__(self, same: cg.ViscousFriction) -> None:
        self.coefficient, self.n_memory = same.coefficient, same.n_memory
        self.respond, self.slid, self.viscosity = same.respond, same.slid, same.viscosity


def slowing_down(friction: object, end: float) -> cg.Simulation:
    """A node on a plate, at 3 mm/s."""
    plate = box((-1.0, -1.0, -1.0), (1.0, 1.0, 0.0))
    node = cg.Slave([[0.0, 0.0, -G / 1e4]], area=[1.0], mass=[1.0])
    law = cg.PenaltyLaw(1e4)
    contact = cg.Contact(plate, node, law=law, friction=friction, search="penetration")
    return cg.Simulation(
        bodies={"plate": plate}, slaves={"node": (node, Free(velocity=[3e-3, 0, 0]))},
        contacts=[contact], gravity=[0, 0, -G], end=end, step="auto",
    )  # fmt: skip


def test_a_friction_of_ones_own_takes_the_steps_of_one_that_does_the_same() -> None:
    friction = cg.ViscousFriction(0.3, 1e-3)
    ours, own = (slowing_down(one, 0.02).run() for one in (friction, OwnFriction(friction)))
    assert len(ours.history["time"]) > 20
    np.testing.assert_array_equal(own.history["time"], ours.history["time"])


def test_viscous_friction_of_a_free_node_is_followed() -> None:
    """v' = −μ g tanh(v/s): sinh(v/s) falls by e^(−μ g t/s)."""
    speed, rate = 1e-3, 0.3 * G / 1e-3
    history = slowing_down(cg.ViscousFriction(0.3, speed), 600.0 / rate).run().history
    # from where friction acts: the start knows of none
    time, force = history["time"][3:], history["friction_x"][3:] / (-0.3 * G)
    still = np.sinh(np.arctanh(force[0])) * np.exp(-rate * (time - time[0]))
    np.testing.assert_allclose(force, np.tanh(np.arcsinh(still)), atol=0.016)
    assert len(history["time"]) < 800
