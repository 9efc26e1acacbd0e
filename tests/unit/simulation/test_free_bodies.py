"""Bodies and nodes that the forces of contacts move: momentum, energy, what is attached to what."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from tests.scenes import square_sheet

import contiga as cg
from contiga.errors import InputError, RunError
from contiga.rigid import rigid_lanes as lanes

BALL = 10.0


def ball(centre: tuple[float, float, float]) -> cg.Body:
    return cg.Body([cg.shapes.sphere(radius=BALL, centre=centre)])


def skin(body: cg.Body, tolerance: float = 0.05) -> cg.Slave:
    mesh = body.tessellate(tolerance)
    return cg.Slave(mesh.vertices, mesh.triangles)


def pair(**options: object) -> cg.Simulation:
    """Two balls that meet beside their centres, one exact, one sampled."""
    first, second = ball((0.0, 0.0, 0.0)), ball((1.5, 0.5, 2.0 * BALL + 0.2))
    points = skin(second)
    contact = cg.Contact(
        first, points, law=cg.StressLaw(1.0, thickness=3.0), friction=cg.Coulomb(0.3)
    )
    inertia = 0.4 * 50.0 * BALL**2 * np.eye(3)
    arguments: dict[str, object] = {
        "bodies": {
            "first": (
                first,
                cg.motion.Free(50.0, inertia=inertia, velocity=(0, 0, 1.0), spin=(0.1, 0.02, 0)),
            ),
            "second": (
                second,
                cg.motion.Free(
                    90.0,
                    inertia=1.8 * inertia,
                    centre=(1.5, 0.5, 2.0 * BALL + 0.2),
                    velocity=(0.0, 0.1, -1.0),
                ),
            ),
        },
        "slaves": {"skin": (points, cg.motion.Attached("second"))},
        "contacts": [contact],
        "end": 5.0,
        "step": "auto",
    }
    return cg.Simulation(**(arguments | options))  # type: ignore[arg-type]


def momenta(state: cg.SystemState) -> tuple[np.ndarray, np.ndarray]:
    mass, rows = np.array([[50.0], [90.0]]), state.rigid
    linear = mass * rows[:, lanes.VELOCITY :][:, :3]
    angular = np.cross(rows[:, :3], linear) + rows[:, lanes.MOMENTUM :][:, :3]
    return linear.sum(axis=0), angular.sum(axis=0)


def test_two_balls_keep_momentum_and_energy() -> None:
    result = pair().run(keep=1)
    history = result.history
    assert history["n_contact"].max() > 20
    assert history["n_contact"][-1] == 0
    first = momenta(result.states[0])
    for state in result.states:
        for now, then in zip(momenta(state), first, strict=True):
            np.testing.assert_allclose(now, then, rtol=0.0, atol=1e-10)
    assert np.abs(history["energy.error"]).max() < 2e-4 * history["energy.total"][0]
    assert history["energy.friction"][-1] > 0.0
    assert history["energy.external"] == pytest.approx(0.0, abs=1e-12)


def test_its_columns_are_those_of_its_state() -> None:
    result = pair(step=0.05, end=1.0).run()
    row, history = result.state.rigid[1], result.history
    for k, name in enumerate("xyz"):
        assert history[f"second.{name}"][-1] == row[lanes.CENTRE + k]
        assert history[f"second.v{name}"][-1] == row[lanes.VELOCITY + k]
        assert history[f"second.a{name}"][-1] == row[lanes.FORCE + k] / 90.0
        spin = result.state.bodies["second"].twist.spin
        assert history[f"second.w{name}"][-1] == spin[k]


def test_a_body_attached_to_another_goes_with_it_and_adds_its_mass() -> None:
    base, hand = ball((0.0, 0.0, 0.0)), ball((0.0, 0.0, 30.0))
    pad = cg.Slave([[0.0, 0.0, 100.0]], area=[1.0])
    contact = cg.Contact(hand, pad, law=cg.PenaltyLaw(10.0))
    own = base.mass_properties(1.0), hand.mass_properties(1.0)
    simulation = cg.Simulation(
        bodies={
            "base": (base, cg.motion.Free(own[0], velocity=(0, 0, 1.0), spin=(0.2, 0.0, 0.0))),
            "hand": (hand, cg.motion.Attached("base", own[1])),
        },
        slaves={"pad": pad},
        contacts=[contact],
        end=2.0,
        step=0.1,
    )
    result = simulation.run(keep=1)
    for state in result.states:
        np.testing.assert_array_equal(state.bodies["base"].pose, state.bodies["hand"].pose)
    # The centre of both is between them, and goes straight.
    assert result.history["base.z"][0] == pytest.approx(15.0, rel=1e-12)
    assert result.history["base.z"][-1] == pytest.approx(17.0, rel=1e-12)
    assert result.history["energy.kinetic"][0] == pytest.approx(
        0.5 * 2.0 * own[0].mass + 0.5 * 0.04 * (2 * own[0].inertia[0, 0] + 2 * own[0].mass * 225.0)
    )


def test_free_nodes_fall_and_bounce() -> None:
    """A sheet of loose masses thrown at a fixed ball: momentum it gets is what they lose."""
    body, (nodes, quads) = ball((0.0, 0.0, -BALL)), square_sheet(30.0, 13)
    nodes[:, 2] += 0.1
    points = cg.Slave(nodes, quads, mass=np.full(169, 2.0))
    contact = cg.Contact(body, points, law=cg.PenaltyLaw(5.0, per_area=True))
    simulation = cg.Simulation(
        bodies={"ball": body},
        slaves={"sheet": (points, cg.motion.Free(velocity=(0.0, 0.0, -1.0)))},
        contacts=[contact],
        end=6.0,
        step="auto",
        gravity=(0.0, 0.0, -0.01),
    )
    result = simulation.run()
    history = result.history
    assert history["n_contact"].max() > 8
    assert np.abs(history["energy.error"]).max() < 1e-3 * history["energy.total"][0]
    untouched = np.hypot(nodes[:, 0], nodes[:, 1]) > BALL
    fallen = result.state.slaves["sheet"].velocities[untouched, 2]
    np.testing.assert_allclose(fallen, -1.06, rtol=1e-12)


def test_a_step_above_the_critical_one_is_refused_and_one_below_is_stable() -> None:
    body = ball((0.0, 0.0, BALL))
    hold = ("x", "y", "rx", "ry", "rz")
    point = cg.Slave([[0.0, 0.0, 0.0]], area=[1.0])
    contact = cg.Contact(body, point, law=cg.PenaltyLaw(100.0), search="penetration")

    def simulation(step: float, **options: bool) -> cg.Simulation:
        # It starts 0.5 deep, and gravity keeps it in contact: ω = 10.
        moved = body.transformed(cg.motion.pose.translation([0.0, 0.0, -0.5]))
        own = cg.Contact(moved, point, law=contact.law, search="penetration")
        free = cg.motion.Free(1.0, centre=(0, 0, BALL), hold=hold)
        return cg.Simulation(
            bodies={"ball": (moved, free)},
            slaves={"point": point},
            contacts=[own],
            end=30.0,
            step=step,
            gravity=(0.0, 0.0, -49.0),
            **options,  # type: ignore[arg-type]
        )

    critical = 2.0 / 10.0
    stable = simulation(0.99 * critical).run().history
    assert np.abs(stable["ball.vz"]).max() < 1.0
    with pytest.raises(RunError, match=r"critical one of 0\.2.*step = \"auto\""):
        simulation(1.01 * critical).run()
    grown = simulation(1.05 * critical, allow_unstable=True).run().history
    assert np.abs(grown["ball.vz"]).max() > 3.0


@pytest.mark.full
def test_a_killed_run_goes_on_with_the_same_bits(tmp_path: Path) -> None:
    whole = pair(end=3.0).run(tmp_path / "whole")
    count = len(whole.history["time"])
    for stop in (1, count // 3, count - 2):
        seen = 0

        def interrupt(_: cg.SystemState, stop: int = stop) -> None:
            nonlocal seen
            seen += 1
            if seen == stop:
                raise KeyboardInterrupt

        with pytest.raises(KeyboardInterrupt):
            pair(end=3.0).run(tmp_path / "cut", on_step=interrupt)
        again = pair(end=3.0).run(tmp_path / "cut", resume=True)
        for name, column in whole.history.items():
            if name != "wall_time":
                np.testing.assert_array_equal(again.history[name], column, err_msg=name)
        np.testing.assert_array_equal(again.state.rigid, whole.state.rigid)


def test_what_cannot_be_moved_is_told() -> None:
    body = ball((0.0, 0.0, 0.0))
    free = cg.motion.Free(1.0, hold=["rx", "ry", "rz"])
    point = cg.Slave([[0.0, 0.0, 20.0]], area=[1.0])
    contact = cg.Contact(body, point, law=cg.PenaltyLaw(1.0))

    def simulation(bodies: dict[str, object], slave: object = point, **rest: object) -> None:
        cg.Simulation(
            bodies=bodies,
            slaves={"point": slave},
            contacts=[contact],
            **({"end": 1.0, "step": 0.1} | rest),  # type: ignore[arg-type]
        )

    other = ball((50.0, 0.0, 0.0))
    attached = cg.motion.Attached
    with pytest.raises(InputError, match=r"in a circle.*ball -> other -> ball"):
        simulation({"ball": (body, attached("other")), "other": (other, attached("ball"))})
    with pytest.raises(InputError, match="no body of this name"):
        simulation({"ball": (body, attached("sled"))})
    with pytest.raises(InputError, match="needs one mass"):
        simulation({"ball": (body, cg.motion.Free())})
    with pytest.raises(InputError, match="free nodes need masses"):
        simulation({"ball": (body, free)}, (point, cg.motion.Free()))
    with pytest.raises(InputError, match="mass and a velocity only"):
        simulation({"ball": (body, free)}, (point, cg.motion.Free(1.0, hold="x")))
    with pytest.raises(InputError, match="attached to its master"):
        simulation({"ball": (body, free)}, (point, attached("ball")))
    pulse = cg.motion.Accelerated([[0.0, 1.0], [0.5, 0.0]], direction="x")
    with pytest.raises(InputError, match=r"stops at 0\.5, and the run needs it up to 1"):
        simulation({"ball": (body, pulse)})
    spring = cg.Spring(("ball", "sled"), at=[[0, 0, 0], [1, 0, 0]], curve=1.0)
    with pytest.raises(InputError, match="no body of this name"):
        simulation({"ball": (body, free)}, springs=[spring])
    with pytest.raises(InputError, match=r"must be a number, or .auto."):
        simulation({"ball": (body, free)}, step="fast")
    sensor = cg.Sensor("cg", "ball", criteria=["HIC15"])
    with pytest.raises(InputError, match="need units"):
        simulation({"ball": (body, free)}, sensors=[sensor])


def closes(history: dict[str, np.ndarray], tolerance: float) -> bool:
    most = np.abs(history["energy.total"]).max()
    return bool(np.abs(history["energy.error"]).max() < tolerance * most)


def test_points_that_are_driven_do_the_work_that_a_ball_gets() -> None:
    body, (nodes, quads) = ball((0.0, 0.0, BALL + 0.1)), square_sheet(12.0, 13)
    sheet = cg.Slave(nodes, quads)
    up = cg.motion.Velocity([[0.0, 0.0], [2.0, 1.0], [6.0, 1.0]], direction="z")
    free = cg.motion.Free(body.mass_properties(0.01), hold=("x", "y", "rx", "ry", "rz"))
    history = (
        cg.Simulation(
            bodies={"ball": (body, free)},
            slaves={"sheet": (sheet, up)},
            contacts=[cg.Contact(body, sheet, law=cg.PenaltyLaw(2.0, per_area=True))],
            end=6.0,
            step="auto",
        )
        .run()
        .history
    )
    assert history["ball.vz"][-1] > 0.5
    assert history["energy.external"][-1] > 0.5 * history["energy.kinetic"][-1]
    assert closes(history, 1e-3)


def test_a_body_that_is_turned_does_work_through_a_spring_on_its_arm() -> None:
    """The moment about its frame's origin turns with it; the force there stands still."""
    arm, bob = ball((0.0, 0.0, 0.0)), ball((60.0, 0.0, 0.0))
    turn = cg.motion.Rotate([[0.0, 0.0], [10.0, 40.0]], axis="z")
    free = cg.motion.Free(5.0, centre=(60.0, 0.0, 0.0), hold=("rx", "ry", "rz"))
    spring = cg.Spring(("arm", "bob"), at=[(30.0, 0.0, 0.0), (60.0, 0.0, 0.0)], curve=0.5)
    history = (
        cg.Simulation(
            bodies={"arm": (arm, turn), "bob": (bob, free)},
            slaves={},
            contacts=[],
            springs=[spring],
            end=10.0,
            step=0.01,
        )
        .run()
        .history
    )
    assert history["energy.external"][-1] > 5.0
    assert closes(history, 1e-4)


def test_a_body_attached_without_a_mass_adds_none() -> None:
    base, hand = ball((0.0, 0.0, 0.0)), ball((0.0, 0.0, 30.0))
    simulation = cg.Simulation(
        bodies={
            "base": (base, cg.motion.Free(base.mass_properties(1.0))),
            "hand": (hand, cg.motion.Attached("base")),
        },
        slaves={},
        contacts=[],
        end=1.0,
        step=0.5,
    )
    assert simulation.mechanism.fixed[0, lanes.MASS] == base.mass_properties(1.0).mass
