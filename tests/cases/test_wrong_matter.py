"""Matter that is wrong, each in a way that runs: what is said of it, before a run or after it."""

from __future__ import annotations

import re

import numpy as np
import pytest
from tests.cases.matter import (
    EPP,
    MATTER,
    SYSTEMS,
    Matter,
    Units,
    belt,
    fabric,
    foam,
    mesh,
    pressed,
    rubber,
    with_rates,
)
from tests.cases.test_right_matter import joined
from tests.scenes import box

import contiga as cg
from contiga.matter.skin import skin

UNITS = Units.of(SYSTEMS["mm-g-ms"])
MM = SYSTEMS["mm-g-ms"]


def rules(simulation: cg.Simulation) -> list[str]:
    return [finding.rule for finding in simulation.check()]


DENSITY = ["PU of a seat", "EPP of 60", "steel", "natural rubber", "nylon of an airbag", "brain"]
STRESS = ["PU of a seat", "EPP of 60", "steel", "EPS of 30", "aluminium foam", "gel"]


@pytest.mark.parametrize("factor", [1e-9, 1e-6, 1e6, 1e9])
@pytest.mark.parametrize("name", DENSITY)
def test_a_density_in_another_unit_is_told(name: str, factor: float) -> None:
    """kg/m³ for t/mm³, g/mm³ for kg/m³, and the other way round."""
    units, matter = Units.of(SYSTEMS["mm-g-ms"]), MATTER[name]
    found = pressed(matter._replace(density=factor * matter.density), units, ("mm", "g", "ms"))
    (finding,) = found.check()
    assert finding.rule in ("density", "modulus")
    assert finding.where == "slave pad"


@pytest.mark.parametrize(("name", "factor"), [
    *((name, 1e9) for name in STRESS),
    *((name, 1e-9) for name in STRESS),
    *((name, 1e6) for name in STRESS if name != "gel"),
    *((name, 1e-6) for name in STRESS if name != "steel"),
    *((name, 1e3) for name in ("steel", "EPP of 60", "EPS of 30", "aluminium foam")),
    *((name, 1e-3) for name in ("PU of a seat", "EPP of 60", "gel", "EPS of 30")),
])  # fmt: skip
def test_a_stress_in_another_unit_is_told(name: str, factor: float) -> None:
    """Pa for MPa, kPa for Pa; of steel a thousandth is a soft metal, of gel a million a plastic."""
    units, matter = Units.of(SYSTEMS["mm-g-ms"]), MATTER[name]
    wrong = matter._replace(made=lambda own: matter.made(_Stressed(*own, factor)))
    (finding,) = pressed(wrong, units, ("mm", "g", "ms")).check()
    assert finding.rule in ("modulus", "stress")


class _Stressed(Units):
    """Units of which that of stress is wrong."""

    def __new__(cls, length: float, mass: float, time: float, factor: float) -> _Stressed:
        self = super().__new__(cls, length, mass, time)
        self.factor = factor
        return self

    @property
    def stress(self) -> float:
        return self.factor * super().stress


@pytest.mark.parametrize(
    ("matter", "word"),
    [
        (foam(60.0, *((100.0 * strain, stress) for strain, stress in EPP)), "strains of 50 and 90"),
        (belt(1100.0, 5.8e-5, (3.0, 2.5e3), (6.0, 6e3), (12.0, 1.1e4)), "strains of 6 and 12"),
        (fabric(800.0, 3.5e-4, (2.0, 2e6), (10.0, 2.5e7), (30.0, 1e8)), "strains of 10 and 30"),
    ],
    ids=["foam", "webbing", "cloth"],
)
@pytest.mark.parametrize("names", [MM, ("", "", "")])
def test_strains_in_per_cent_are_told(matter: Matter, word: str, names) -> None:
    found = [one for one in pressed(matter, UNITS, names).check() if one.rule == "curve"]
    assert len(found) == (2 if "50" not in word and matter.kind == "triangle" else 1)
    assert word in found[0].text
    assert "0.5 is 50 %" in found[0].remedy


def test_strains_of_a_layer_in_per_cent_are_told() -> None:
    ball = cg.Body([cg.shapes.sphere(radius=30.0, centre=(0.0, 0.0, 30.2))])
    sheet = mesh("triangle", 8, 1000.0)
    law = cg.StressLaw([[0, 0], [5, 0.1], [60, 0.2], [90, 3]], thickness=20.0)
    down = cg.motion.Translate([[0, 0, 0, 0], [2, 0, 0, -3.0]])
    simulation = cg.Simulation(
        bodies={"ball": (ball, down)},
        slaves={"sheet": sheet},
        contacts=[cg.Contact(ball, sheet, law=law)],
        end=2.0,
        step=0.1,
    )
    (finding,) = simulation.check()
    assert finding.rule == "curve"
    assert "strains of 60 and 90" in finding.text


@pytest.mark.parametrize("rates", [(1e3, 1e5), (1e-6, 1e-4)])
def test_rates_in_another_unit_are_told(rates: tuple[float, float]) -> None:
    (finding,) = pressed(with_rates(60.0, EPP, *rates), UNITS, MM).check()
    assert finding.rule == "rates"
    assert f"{rates[1]:.4g} 1/s" in finding.text
    assert "Give rates in 1/ms: 100/s is 0.1" in finding.remedy


def test_rates_that_are_smoothed_over_more_than_the_run_are_told() -> None:
    def slow(units: Units) -> object:
        table = np.array([(0.0, 0.0), *EPP]) * [1.0, units.stress]
        return cg.materials.Foam(loading=table, rates=[(0.1, table * [1.0, 1.2])], filter=10.0)

    (finding,) = pressed(Matter(60.0, slow), UNITS, MM).check()
    assert finding.rule == "rates"
    assert "smoothed over 10 ms" in finding.text


@pytest.mark.parametrize(
    ("kind", "poisson", "volume", "told"),
    [
        ("tetra", 0.4999, "element", True),
        ("tetra", 0.48, "element", True),
        ("tetra", 0.46, "element", False),
        ("tetra", 0.4999, "nodes", False),
        ("hexahedron", 0.4999, "element", False),
    ],
)
def test_tetrahedra_that_lock_are_told(kind: str, poisson: float, volume: str, told: bool) -> None:
    matter = rubber(1000.0, 1e6, poisson, volume, kind=kind)
    assert rules(pressed(matter, UNITS, MM)) == ["locking"] * told


@pytest.mark.parametrize("off", [0.0, 1e-5])
def test_halves_that_share_no_node_are_told(off: float) -> None:
    block = mesh("hexahedron", 2, 1000.0)
    beside = block.transformed(cg.motion.pose.translation([40.0 + off, 0.0, 0.0]))
    (finding,) = joined(block, beside, fixed={"layer": ([0, 0, -1], 0.0)}).check()
    assert (finding.rule, finding.where) == ("torn", "slave pad")
    assert "6 nodes of one lie where nodes of another are" in finding.text  # 9, three are held


def test_belts_that_share_no_end_are_told() -> None:
    units, row = UNITS, mesh("line", 2, 1000.0)
    x = np.concatenate([row.points, row.points + np.array([80.0, 0.0, 0.0])])
    rows = np.concatenate([row.elements["line"], row.elements["line"] + len(row)])
    torn = cg.Slave(x, area=np.full(len(x), 100.0), elements={"line": rows})
    webbing = MATTER["webbing"]
    motion = cg.motion.Deforming(
        material=webbing.made(units),
        density=webbing.density * units.density,
        section=58.0,
        fixed={"nodes": [0, len(x) - 1]},
    )
    ball = cg.Body([cg.shapes.sphere(radius=30.0, centre=(0.0, 0.0, 30.2))])
    down = cg.motion.Translate([[0, 0, 0, 0], [2, 0, 0, -3.0]])
    simulation = cg.Simulation(
        bodies={"ball": (ball, down)},
        slaves={"belt": (torn, motion)},
        contacts=[cg.Contact(ball, torn, law=cg.PenaltyLaw(1.0))],
        end=2.0,
        step="auto",
    )
    assert rules(simulation) == ["torn"]


@pytest.mark.parametrize("kind", ["hexahedron", "triangle"])
def test_elements_given_twice_are_told(kind: str) -> None:
    """Whatever corner they begin at."""
    block = mesh(kind, 3, 1000.0)
    rows = block.facets if kind == "triangle" else block.elements[kind]
    again = (
        np.roll(rows[:5], 1, axis=1) if kind == "triangle" else rows[:5, [1, 2, 3, 0, 5, 6, 7, 4]]
    )
    facets = np.concatenate([rows, again]) if kind == "triangle" else block.facets
    elements = {} if kind == "triangle" else {kind: np.concatenate([rows, again])}
    slave = cg.Slave(block.points, facets, elements=elements)
    motion = cg.motion.Deforming(
        material=cg.materials.Elastic(young=10.0),
        density=1e-3,
        thickness=0.3 if kind == "triangle" else None,
        fixed={"nodes": [0]},
    )
    ball = cg.Body([cg.shapes.sphere(radius=30.0, centre=(0.0, 0.0, 30.2))])
    down = cg.motion.Translate([[0, 0, 0, 0], [2, 0, 0, -3.0]])
    simulation = cg.Simulation(
        bodies={"ball": (ball, down)},
        slaves={"pad": (slave, motion)},
        contacts=[cg.Contact(ball, slave, law=cg.PenaltyLaw(0.01, per_area=True), quadrature=3)],
        end=2.0,
        step="auto",
    )
    (finding,) = simulation.check()
    assert finding.rule == "twice"
    assert "5 of its elements" in finding.text


@pytest.mark.parametrize("several", [False, True])
def test_a_place_that_holds_nothing_is_told(several: bool) -> None:
    place = {"layer": ([0, 0, -1], 0.0), "hold": []}
    other = {"nodes": [0]}
    fixed = [other, place] if several else place
    (finding,) = pressed(MATTER["EPP of 60"], UNITS, MM, fixed=fixed).check()
    assert (finding.rule, finding.where) == ("held", "slave pad")
    assert rules(pressed(MATTER["EPP of 60"], UNITS, MM, fixed=np.zeros(64, bool))) == []


def strained(matter: Matter, far: float, strain: float) -> cg.Simulation:
    """One element whose one end a motion drives by a strain, and back again."""
    slave = mesh(matter.kind, 1, UNITS.length)
    axis = 2 if matter.kind == "hexahedron" else 0
    low = slave.points[:, axis] == slave.points[:, axis].min()
    way = np.zeros((3, 4))
    way[:, 0] = 0.0, 1.0, 2.0
    way[1, 1 + axis] = strain * np.ptp(slave.points[:, axis])
    driven = {"nodes": np.flatnonzero(~low).tolist(), "motion": cg.motion.Translate(way)}
    if matter.kind == "line":
        driven["nodes"] = [2]
    across = {"triangle": "thickness", "line": "section"}.get(matter.kind)
    motion = cg.motion.Deforming(
        material=matter.made(UNITS),
        density=matter.density * UNITS.density,
        fixed={"nodes": np.flatnonzero(low).tolist()},
        driven=driven,
        **({} if across is None else {across: 0.35 if across == "thickness" else 58.0}),
    )
    return cg.Simulation(
        bodies={}, slaves={"pad": (slave, motion)}, contacts=[], end=2.0, step="auto", units=MM
    )


@pytest.mark.parametrize(
    ("matter", "end", "sign", "measure"),
    [
        (foam(60.0, (0.05, 1.5e5), (0.4, 2e5), (0.5, 1e6)), 0.5, -1.0, lambda e: e),
        (fabric(800.0, 3.5e-4, (0.1, 1e7), (0.3, 1e8)), 0.3, 1.0, lambda e: e + 0.5 * e * e),
        (belt(1100.0, 5.8e-5, (0.03, 2.5e3), (0.15, 2e4)), 0.15, 1.0, lambda e: e),
    ],
    ids=["foam", "cloth", "webbing"],
)
def test_matter_beyond_its_table_is_told_after_a_run(matter, end, sign, measure) -> None:
    """The largest strain of the run, although it is gone at the end of it: known from the ends."""
    within, beyond = 0.9 * end, 1.25 * end
    for strain in (within, beyond):
        run = strained(matter, end, sign * strain).run()
        found = [one for one in run.summary["findings"] if one["rule"] == "table"]
        if measure(strain) <= end:
            assert found == []
        else:
            (finding,) = found
            reached = float(finding["text"].split("reaches ")[1].split(",")[0])
            assert reached == pytest.approx(measure(strain), rel=0.05)
            assert f"ends at {end}" in finding["text"]
    assert measure(beyond) > end >= measure(0.5 * end)


def bent(nodal: bool) -> cg.Simulation:
    """A plate of foam, pushed at one node or pressed all over."""
    n = (8, 8, 1)
    x = np.stack(np.meshgrid(*[np.arange(k + 1.0) for k in n], indexing="ij"), -1).reshape(-1, 3)
    g = np.arange(len(x)).reshape(9, 9, 2)
    low, high = (slice(0, 8), slice(1, 9)), (0, 1)
    ring = ((0, 0), (1, 0), (1, 1), (0, 1))
    rows = np.stack([g[low[i], low[j], k].ravel() for k in high for i, j in ring], axis=1)
    slave = cg.Slave(x, skin([("hex8", rows)]), elements={"hexahedron": rows})
    at = {"nodes": [int(g[4, 4, 1])]} if nodal else {"nodes": g[:, :, 1].ravel().tolist()}
    load = cg.motion.NodalForce([[0, 0, 0, 0], [2, 0, 0, -0.3 if nodal else -3.0]], on=at)
    motion = cg.motion.Deforming(
        material=cg.materials.Foam(loading=[[0, 0], [0.05, 0.1], [0.6, 0.2], [0.9, 3]]),
        density=1e-3,
        fixed={"layer": ([0, 0, -1], 0.0)},
        loads=load,
    )
    return cg.Simulation(
        bodies={}, slaves={"s": (slave, motion)}, contacts=[], end=2.0, step="auto"
    )


@pytest.mark.parametrize("nodal", [True, False])
def test_energy_in_hourglass_modes_is_told(nodal: bool) -> None:
    run = bent(nodal).run()
    found = [one for one in run.summary["findings"] if one["rule"] == "hourglass"]
    share = run.history["energy.hourglass"].max() / run.history["energy.strain"].max()
    assert (share > 0.1) == nodal
    assert len(found) == nodal
    if found:
        assert f"{100.0 * share:.3g} %" in found[0]["text"]


def test_energies_of_rounding_are_no_hourglass_modes() -> None:
    """A block that flies on, its springs against these modes fifty times as stiff as they are."""
    fly = {"fixed": None, "velocity": [0.0, 0.0, -40.0], "hourglass": 50.0}
    run = pressed(MATTER["EPP of 60"], UNITS, MM, deep=0.0, **fly).run()
    modes, strain = (run.history[f"energy.{name}"].max() for name in ("hourglass", "strain"))
    assert modes > 0.1 * strain
    assert "hourglass" not in [one["rule"] for one in run.summary["findings"]]


def pierced(side: float, radius: float, quadrature: str | int = 3, length: float = 30.0):
    """A pin that comes down at the middle of a square of a held cloth, between its points."""
    n = round(80.0 / side)
    grid = np.linspace(-40.0, 40.0, n + 1)
    x = np.stack(np.meshgrid(grid, grid, [0.0], indexing="ij"), axis=-1).reshape(-1, 3)
    g = np.arange(len(x)).reshape(n + 1, n + 1)
    a, b, c, d = g[:-1, :-1].ravel(), g[1:, :-1].ravel(), g[1:, 1:].ravel(), g[:-1, 1:].ravel()
    cloth = cg.Slave(x, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]))
    motion = cg.motion.Deforming(
        material=cg.materials.Elastic(young=50.0, poisson=0.3, compression=False),
        density=1e-3,
        thickness=0.5,
        fixed={"box": [[-50, -50, -1], [-39.9, 50, 1]]},
    )
    middle = 0.5 * (grid[n // 2] + grid[n // 2 + 1])
    pin = cg.Body([cg.shapes.ellipsoid(axes=(radius, radius, 0.5 * length))]).transformed(
        cg.motion.pose.translation([middle, middle, 1.0 + 0.5 * length])
    )
    down = cg.motion.Translate([[0, 0, 0, 0], [10, 0, 0, -25.0]])
    law = cg.PenaltyLaw(1.0, per_area=True)
    return cg.Simulation(
        bodies={"pin": (pin, down)},
        slaves={"cloth": (cloth, motion)},
        contacts=[cg.Contact(pin, cloth, law=law, quadrature=quadrature)],
        end=10.0,
        step="auto",
        units=MM,
    )


def test_a_pin_that_is_thinner_than_facets_is_told() -> None:
    (finding,) = pierced(20.0, 3.0).check()
    assert (finding.rule, finding.where) == ("coarse", "contact pin-cloth")
    assert "through a facet of cloth with a side of 28.28 mm" in finding.text
    width = float(re.search(r"it is some ([\d.]+) mm wide", finding.text)[1])
    assert width == pytest.approx(6.0, rel=0.05)
    assert "Take facets of" in finding.remedy


@pytest.mark.parametrize(
    ("side", "radius", "quadrature"), [(4.0, 3.0, 3), (20.0, 12.0, 3), (20.0, 3.0, 6)]
)
def test_a_pin_that_points_of_facets_see_is_not_told(side, radius, quadrature) -> None:
    assert pierced(side, radius, quadrature).check() == ()


def test_contact_that_begins_deeper_than_facets_are_wide_is_told_as_too_coarse() -> None:
    """A ball that is there from one step to the next."""
    sheet = mesh("triangle", 8, 1000.0)
    ball = cg.Body([cg.shapes.sphere(radius=30.0, centre=(0.0, 0.0, 40.0))])
    jump = cg.motion.Translate([[0, 0, 0, 0], [1.0, 0, 0, 0], [1.1, 0, 0, -20.0], [2, 0, 0, -20.0]])
    simulation = cg.Simulation(
        bodies={"ball": (ball, jump)},
        slaves={"sheet": sheet},
        contacts=[cg.Contact(ball, sheet, law=cg.PenaltyLaw(1.0))],
        end=2.0,
        step=0.1,
    )
    found = [one for one in simulation.run().summary["findings"] if one["rule"] == "coarse"]
    assert "10 deep, and facets of sheet are 5 wide: too coarse" in found[0]["text"]


def test_a_body_that_a_flaw_makes_open_is_told() -> None:
    """Two balls that overlap; neither one ball nor a sheet, which merely ends."""
    balls = [cg.shapes.sphere(radius=10.0, centre=(x, 0.0, 10.2)) for x in (0.0, 12.0)]
    plane = cg.Body([cg.shapes.plane(width=60.0, length=60.0, centre=(0, 0, 0.2))]).flipped()
    for body, told in ((cg.Body(balls), True), (cg.Body(balls[:1]), False), (plane, False)):
        sheet = mesh("triangle", 8, 1000.0)
        down = cg.motion.Translate([[0, 0, 0, 0], [1, 0, 0, -2.0]])
        simulation = cg.Simulation(
            bodies={"master": (body, down)},
            slaves={"sheet": sheet},
            contacts=[cg.Contact(body, sheet, law=cg.PenaltyLaw(1.0))],
            end=1.0,
            step=0.1,
        )
        found = simulation.check()
        assert [one.rule for one in found] == ["open"] * told
        assert simulation.run().summary["warnings"] == [str(one) for one in found]


def rocking() -> cg.Simulation:
    """A box of four feet that is dropped on an open plane at 4°, and rocks: two feet lift off from
    a depth of micrometres while the other two carry."""
    tilt = cg.motion.pose.rotation("y", np.deg2rad(4.0))
    feet = np.array([[x, y, 0.0] for x in (-0.1, 0.1) for y in (-0.1, 0.1)])
    feet = cg.motion.pose.apply(tilt, feet)
    up = np.array([0.0, 0.0, 1e-4 - feet[:, 2].min()])
    centre = cg.motion.pose.apply(tilt, [[0.0, 0.0, 0.2]])[0] + up
    floor = cg.Body([cg.shapes.plane(width=10.0, length=10.0)])
    body = cg.Body([cg.shapes.sphere(radius=0.1, centre=tuple(centre))])
    slave = cg.Slave(feet + up, area=np.ones(4))
    free = cg.motion.Free(mass=2.0, inertia=0.02 * np.eye(3), centre=centre)
    return cg.Simulation(
        bodies={"floor": floor, "box": (body, free)},
        slaves={"feet": (slave, cg.motion.Attached("box"))},
        contacts=[cg.Contact(floor, slave, law=cg.PenaltyLaw(2e4))],
        end=0.08,
        step=1e-4,
        gravity=(0.0, 0.0, -9.81),
    )


def test_feet_of_a_box_that_rocks_do_not_go_through_the_floor() -> None:
    run = rocking().run()
    assert run.history["n_released"].max() == 2
    assert run.history["n_tunnelled"].sum() == 0
    assert "through" not in [one["rule"] for one in run.summary["findings"]]


def test_points_that_go_through_a_plate_do() -> None:
    """They are let go by its other side, and feet that slide off are not counted."""
    plate = box((-10, -10, 0), (10, 10, 1))
    points = cg.Slave([[0.0, 0.0, 1.1], [3.0, 0.0, 1.1], [9.0, 0.0, 1.1]], area=[1.0] * 3)
    down = cg.motion.Translate(
        [[0, 0, 0, 0], [1, 0, 0, -0.6], [2, 4.0, 0, -0.6], [3, 4.0, 0, -0.6], [4, 4.0, 0, -3.0]]
    )
    run = cg.Simulation(
        bodies={"plate": plate},
        slaves={"points": (points, down)},
        contacts=[cg.Contact(plate, points, law=cg.PenaltyLaw(1.0))],
        end=4.0,
        step=0.1,
    ).run()
    assert run.history["n_tunnelled"].sum() == 2
    (found,) = [one for one in run.summary["findings"] if one["rule"] == "through"]
    assert "2 of 2 points leave plate" in found["text"]
