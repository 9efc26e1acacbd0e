"""Pressures, nodal forces and driven nodes of what deforms: closed forms, ledger, bad input."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from tests.blocks import block

import contiga as cg
from contiga.errors import InputError

YOUNG = 1.0
SOFT = cg.materials.Elastic(young=YOUNG)
FAR = cg.Body([cg.shapes.sphere(radius=1.0, centre=(0.0, 0.0, -100.0))])
TOP = {"layer": ([0, 0, 1], 0.0)}
LOW = {"layer": ([0, 0, -1], 0.0)}
HEIGHT = 6.0


def _slave() -> cg.Slave:
    return block((2, 2, 3), (4.0, 4.0, HEIGHT), kind="hexahedron")


def _simulation(slave: cg.Slave, step: float | str = "auto", **options: object) -> cg.Simulation:
    motion = cg.motion.Deforming(material=SOFT, density=1e-3, **({"fixed": LOW} | options))
    return cg.Simulation(
        bodies={"far": FAR}, slaves={"block": (slave, motion)}, contacts=[], end=2.0, step=step
    )


def _strain(stress: float) -> float:
    """Of Saint-Venant and Kirchhoff: (1 + e) (e + e²/2) = σ/E."""
    return max(np.roots([0.5, 1.5, 1.0, -stress / YOUNG]).real, key=lambda e: e > -0.4)


def test_pressure_on_a_side_shortens_a_block_by_its_law() -> None:
    pressure = cg.motion.Pressure(0.05, on={"side": ([0, 0, 1], 20.0)})
    slave = block((2, 2, 3), (4.0, 4.0, HEIGHT))
    state = _simulation(slave, loads=pressure).settle()
    way = state.slaves["block"].points - slave.points
    exact = slave.points * [0.0, 0.0, _strain(-0.05)]
    np.testing.assert_allclose(way, exact, atol=3e-3 * HEIGHT * 0.05)


def test_its_forces_on_closed_facets_are_the_gradient_of_the_volume() -> None:
    slave = block((1, 1, 1), (1.0, 2.0, 3.0))
    acting = cg.motion.Pressure(0.7).nodes(slave, "pressure")
    rng = np.random.default_rng(3)
    points = slave.points + 0.1 * rng.normal(size=slave.points.shape)

    def volume(x: np.ndarray) -> float:
        a, b, c = (x[slave.facets[:, k]] for k in range(3))
        return float((a * np.cross(b, c)).sum() / 6.0)

    force, h = acting.at(points, 0.0), 1e-3  # of third order in all: differences are exact
    way = rng.normal(size=points.shape)
    slope = (volume(points + h * way) - volume(points - h * way)) / (2.0 * h)
    bend = volume(h * way) / h
    assert -0.7 * (slope - bend) == pytest.approx(float((force * way).sum()), rel=1e-9)
    np.testing.assert_allclose(force.sum(axis=0), 0.0, atol=1e-14)


@pytest.mark.parametrize(
    "options",
    [
        {"loads": cg.motion.Pressure([[0, 0], [1, 0.05], [2, 0.03]], on={"side": ([0, 0, 1], 20)})},
        {"loads": cg.motion.NodalForce([[0, 0, 0, 0], [2, 0.5, 0, 0]], on=TOP)},
        {"driven": TOP | {"motion": cg.motion.Rotate([[0, 0], [2, 20]], "z", [2, 2, 0])}},
    ],
)
def test_the_ledger_has_their_work(options: dict) -> None:
    off = []
    for step in (0.025, 0.0125):
        history = _simulation(_slave(), step, damping=0.2, **options).run().history
        came = np.abs(history["energy.external"]).max()
        assert history["energy.strain"].max() > 0.1 * came > 0.0
        off.append(np.abs(history["energy.error"]).max() / came)
    assert off[0] < 1e-3
    assert off[1] < off[0] / 3.0


def test_a_force_is_shared_by_areas_and_without_facets_evenly() -> None:
    slave = block((2, 1, 1), (2.0, 1.0, 1.0), kind="hexahedron")
    shared = cg.motion.NodalForce([0, 0, 2.0], on=TOP).nodes(slave, "load").at(slave.points, 0.0)
    top = slave.points[:, 2] == 1.0
    assert not shared[~top].any()
    # A quarter of each face to its corners, whatever the diagonals that they are drawn with.
    middle = slave.points[top, 0] == 1.0
    np.testing.assert_allclose(shared[top, 2], np.where(middle, 0.5, 0.25), atol=1e-15)
    pressed = cg.motion.Pressure(2.0, on=TOP).nodes(slave, "load").at(slave.points, 0.0)
    np.testing.assert_allclose(pressed, -2.0 * shared, atol=1e-15)
    edge = cg.motion.NodalForce([0, 0, 2.0], on={"box": [[0, 0, 1], [2, 0, 1]]})
    each = edge.nodes(slave, "load").at(slave.points, 0.0)[:, 2]
    assert sorted(each[each > 0.0].round(12).tolist()) == pytest.approx([2.0 / 3.0] * 3)


def test_a_load_over_time_is_zero_outside_its_rows_and_ends_steps_at_them() -> None:
    slave = _slave()
    load = cg.motion.NodalForce([[0.5, 0, 0, 1.0], [1.0, 0, 0, 3.0]], on=TOP)
    acting = load.nodes(slave, "load")
    at = [acting.at(slave.points, t).sum(axis=0)[2] for t in (0.4, 0.75, 1.1)]
    np.testing.assert_allclose(at, [0.0, 2.0, 0.0], atol=1e-14)
    constant = load.at_time(0.75)
    assert constant.span is None
    np.testing.assert_allclose(constant.value, [0.0, 0.0, 2.0])
    pushed = cg.motion.Pressure([[0.0, 0.0], [0.3, 1e-3], [2.0, 0.0]])
    assert 0.3 in _simulation(slave, loads=pushed).run().history["time"]
    with pytest.raises(InputError, match=r"loads\[0\].*stops at 1"):
        _simulation(slave, loads=load).run()


def test_driven_nodes_go_as_told_and_what_is_held_of_them_is_free_otherwise() -> None:
    slave = _slave()
    down = cg.motion.Translate([[0, 0, 0, 0], [2, 0.0, 0.0, -0.6]])
    simulation = _simulation(slave, driven=TOP | {"motion": down, "hold": ["z"]})
    result = simulation.run(keep=1)
    top = slave.points[:, 2] == HEIGHT
    for state in result.states:
        way = state.slaves["block"].points[top] - slave.points[top]
        np.testing.assert_allclose(way[:, 2], -0.3 * state.time, atol=1e-14)
    assert np.abs(state.slaves["block"].points[top, :2] - slave.points[top, :2]).max() < 1e-12
    # What drives has the kinetic energy of its nodes; the work on the others is theirs.
    static = 0.5 * YOUNG * (0.6 / HEIGHT) ** 2 * 16.0 * HEIGHT
    assert result.history["energy.external"][-1] == pytest.approx(static, rel=0.25)


def test_a_slave_that_is_driven_as_a_whole_is_not_called_unstable() -> None:
    away = cg.motion.Translate([[0, 0, 0, 0], [2, 90.0, 0.0, 0.0]])
    simulation = _simulation(_slave(), 0.05, fixed=None, driven={"motion": away})
    history = simulation.run().history
    assert history["energy.kinetic"].max() == 0.0
    assert abs(history["energy.external"][-1]) < 1e-12


def test_driven_nodes_wait_where_they_start_while_all_settles() -> None:
    slave = _slave()
    apart = cg.motion.Translate([[0, 0, 0, 0.3], [2, 0.0, 0.0, 5.0]])
    state = _simulation(slave, driven=TOP | {"motion": apart}).settle()
    way = (state.slaves["block"].points - slave.points)[:, 2]
    np.testing.assert_allclose(way, 0.3 * slave.points[:, 2] / HEIGHT, atol=1e-3)
    speed = state.slaves["block"].velocities[slave.points[:, 2] == HEIGHT]
    np.testing.assert_allclose(speed, np.tile([0.0, 0.0, 2.35], (len(speed), 1)))


def test_stopped_and_resumed_it_is_the_same_run(tmp_path: Path) -> None:
    pytest.importorskip("h5py")
    push = cg.motion.Pressure([[0, 0], [2, 0.05]], on={"side": ([1, 0, 0], 20.0)})
    turn = cg.motion.Rotate([[0, 0], [2, 20]], "z", [2, 2, 0])
    simulation = _simulation(_slave(), 0.025, loads=push, driven=TOP | {"motion": turn})

    def stop(done: int, *_: object) -> None:
        if done == 30:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        simulation.run(tmp_path, progress=stop)
    parts, whole = simulation.run(tmp_path, resume=True), simulation.run()
    for name, column in whole.history.items():
        if "wall" not in name:
            np.testing.assert_array_equal(parts.history[name], column)


DOWN = cg.motion.Translate([[0, 0, 0, 0], [2, 0, 0, -1]])


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"driven": LOW | {"motion": DOWN}}, "is held along x already"),
        ({"driven": [TOP | {"motion": DOWN}] * 2}, "is driven along x already"),
        ({"driven": TOP}, "must have the motion of a body"),
        ({"driven": [1]}, "must be tables"),
        ({"loads": [3.0]}, "load on nodes"),
        ({"loads": cg.motion.Pressure(1.0, on={"plane": [[0, 0, 1], [0, 0, 1]]})}, "no node"),
        ({"loads": cg.motion.Pressure(1.0, on={"nodes": [0, 1]})}, "no facet has all its corners"),
        ({"loads": cg.motion.Pressure(1.0, on={"place": 1})}, "a key is not known"),
        ({"fixed": {"layer": ([0, 0, 0], 0.0)}}, "a direction and a number"),
        ({"fixed": {"side": ([0, 0, 1], 200.0)}}, "in degrees"),
    ],
)
def test_what_cannot_be_is_refused(options: dict, text: str) -> None:
    with pytest.raises(InputError, match=text):
        _simulation(_slave(), **options)


@pytest.mark.parametrize("pressure", ["much", np.nan, [[0, 1]], [[1, 0], [0, 1]]])
def test_a_pressure_that_is_none_is_refused(pressure: object) -> None:
    with pytest.raises(InputError, match="pressure"):
        cg.motion.Pressure(pressure)
