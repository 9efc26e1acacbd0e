"""Matter as it is: nothing is told of it, in any units, before a run or after it."""

from __future__ import annotations

import numpy as np
import pytest
from tests.cases.matter import MATTER, SYSTEMS, Units, belt, mesh, pressed
from tests.sample import full
from tests.scenes import box

import contiga as cg
from contiga.materials import Foam


@pytest.mark.parametrize("system", [*SYSTEMS, "none"])
@pytest.mark.parametrize("name", MATTER)
def test_matter_as_it_is_is_told_nothing(name: str, system: str) -> None:
    named = SYSTEMS.get(system, ("mm", "g", "ms"))
    names = ("", "", "") if system == "none" else named
    assert pressed(MATTER[name], Units.of(named), names).check() == ()


@pytest.mark.parametrize("system", SYSTEMS)
def test_a_section_of_one_makes_a_density_the_mass_of_a_length(system: str) -> None:
    """64 g/m: by the volume that would be more than osmium, or less than air."""
    units = Units.of(SYSTEMS[system])
    webbing = belt(1.0, 1.0, (0.03, 2.5e3), (0.12, 1.1e4))
    of_length = {"density": 0.064 * units.mass / units.length, "section": 1.0}
    assert pressed(webbing, units, SYSTEMS[system], **of_length).check() == ()


@pytest.mark.parametrize("name", ["EPP of 60", "natural rubber", *full("silicone, tetrahedra")])
def test_a_run_of_it_is_told_nothing(name: str) -> None:
    units = Units.of(SYSTEMS["mm-g-ms"])
    summary = pressed(MATTER[name], units, SYSTEMS["mm-g-ms"], n=6, deep=3e-3).run().summary
    assert summary["warnings"] == []


def test_webbing_within_its_table_is_told_nothing() -> None:
    """Its ends are driven apart by a tenth."""
    units = Units.of(SYSTEMS["mm-kg-ms"])
    pull = cg.motion.Translate([[0, 0, 0, 0], [5, 8.0, 0, 0]])
    webbing = pressed(
        MATTER["webbing"],
        units,
        SYSTEMS["mm-kg-ms"],
        fixed={"nodes": [0]},
        driven={"nodes": [6], "motion": pull},
    )
    run = webbing.run()
    assert "table" not in [one["rule"] for one in run.summary["findings"]]
    assert run.state.slaves["pad"].points[6, 0] > 44.0


def joined(first: cg.Slave, second: cg.Slave, **motion: object) -> cg.Simulation:
    """Two blocks of one slave under a ball."""
    n = len(first)
    rows = np.concatenate([first.elements["hexahedron"], second.elements["hexahedron"] + n])
    facets = np.concatenate([first.facets, second.facets + n])
    both = cg.Slave(
        np.concatenate([first.points, second.points]), facets, elements={"hexahedron": rows}
    )
    foam = Foam(loading=[[0, 0], [0.05, 0.1], [0.6, 0.2], [0.9, 3.0]])
    moved = cg.motion.Deforming(material=foam, density=6e-5, **motion)
    ball = cg.Body([cg.shapes.sphere(radius=30.0, centre=(0.0, 0.0, 30.2))])
    down = cg.motion.Translate([[0, 0, 0, 0], [2, 0, 0, -3.0]])
    return cg.Simulation(
        bodies={"ball": (ball, down)},
        slaves={"pad": (both, moved)},
        contacts=[cg.Contact(ball, both, law=cg.PenaltyLaw(0.01, per_area=True), quadrature=3)],
        end=2.0,
        step="auto",
        units=("mm", "g", "ms"),
    )


@pytest.mark.parametrize("gap", [0.01, 1.0, 100.0])
def test_blocks_that_stand_apart_are_told_nothing(gap: float) -> None:
    block = mesh("hexahedron", 2, 1000.0)
    beside = block.transformed(cg.motion.pose.translation([40.0 + gap, 0.0, 0.0]))
    assert joined(block, beside, fixed={"layer": ([0, 0, -1], 0.0)}).check() == ()


def test_blocks_that_touch_in_an_edge_of_held_nodes_are_told_nothing() -> None:
    """What is held goes nowhere, whether it is joined or not."""
    block = mesh("hexahedron", 2, 1000.0)
    beside = block.transformed(cg.motion.pose.translation([40.0, 0.0, 0.0]))
    held = {"box": [[19.9, -100, -100], [20.1, 100, 100]]}
    assert joined(block, beside, fixed=[held, {"layer": ([0, 0, -1], 0.0)}]).check() == ()


def test_sheets_that_are_sewn_at_their_rim_are_told_nothing() -> None:
    """A flat bag: nodes of both lie together, triangles of its corners have all nodes in common."""
    sheet, n = mesh("triangle", 4, 1000.0), 25
    x, y = sheet.points[:, 0], sheet.points[:, 1]
    rim = np.isclose(np.maximum(np.abs(x), np.abs(y)), 20.0)
    below = np.arange(n) + n
    below[rim] = np.flatnonzero(rim)
    used, facets = np.unique(
        np.concatenate([sheet.facets, below[sheet.facets[:, ::-1]]]), return_inverse=True
    )
    bag = cg.Slave(np.concatenate([sheet.points] * 2)[used], facets.reshape(-1, 3))
    same = np.sort(bag.facets, axis=1)
    assert len(np.unique(same, axis=0)) < len(same)
    cloth = cg.motion.Deforming(
        material=cg.materials.Elastic(young=100.0), density=8e-4, thickness=0.3
    )
    ball = cg.Body([cg.shapes.sphere(radius=30.0, centre=(0.0, 0.0, 30.2))])
    down = cg.motion.Translate([[0, 0, 0, 0], [2, 0, 0, -3.0]])
    simulation = cg.Simulation(
        bodies={"ball": (ball, down)},
        slaves={"bag": (bag, cloth)},
        contacts=[cg.Contact(ball, bag, law=cg.PenaltyLaw(0.01, per_area=True), quadrature=3)],
        end=2.0,
        step="auto",
        units=("mm", "g", "ms"),
    )
    assert simulation.check() == ()


def corner() -> cg.Body:
    """A cube that stands on a corner."""
    turned = cg.motion.pose.rotation([1.0, -1.0, 0.0], np.arctan(np.sqrt(2.0)))
    return box((0, 0, 0), (20, 20, 20)).transformed(turned)


@pytest.mark.parametrize("size", [1e-6, 1.0, 1e3])
@pytest.mark.parametrize(
    ("body", "quadrature"),
    [
        (cg.Body([cg.shapes.sphere(radius=15.0, centre=(0.0, 0.0, 15.0))]), "nodes"),
        (cg.Body([cg.shapes.sphere(radius=6.0, centre=(0.0, 0.0, 6.0))]), 3),
        (corner(), 3),
    ],
    ids=["a ball three facets across", "a ball between facets' points", "a corner between them"],
)
def test_facets_are_fine_enough_for_what_finds_their_points(body, quadrature, size: float) -> None:
    sheet = mesh("triangle", 4, 1000.0 * size)  # facets of 10
    place = np.diag([size, size, size, 1.0])
    place[:3, 3] = np.array([5.0, 5.0, 0.2]) * size
    body = body.transformed(place)
    down = cg.motion.Translate([[0, 0, 0, 0], [1, 0, 0, -12.0 * size]])
    simulation = cg.Simulation(
        bodies={"body": (body, down)},
        slaves={"sheet": sheet},
        contacts=[
            cg.Contact(body, sheet, law=cg.PenaltyLaw(0.01, per_area=True), quadrature=quadrature)
        ],
        end=1.0,
        step=0.01,
    )
    assert "coarse" not in [one.rule for one in simulation.check()]


@pytest.mark.parametrize("way", ["rolls", "hops"])
def test_a_wheel_between_points_does_not_go_through(way: str) -> None:
    """It turns on a facet between its nodes, or dips in there and goes up again."""
    sheet = mesh("triangle", 2, 1000.0)  # facets of 20
    centre = (10.0, 10.0, 30.1)
    wheel = cg.shapes.sphere(radius=30.0, centre=centre)
    down = cg.motion.Translate([[0, 0, 0, 0], [1, 0, 0, -2.0], [3, 0, 0, 60.0]])
    if way == "rolls":
        down = cg.motion.Translate([[0, 0, 0, 0], [1, 0, 0, -2.0], [3, 0, 0, -2.0]])
        times = np.linspace(0.0, 3.0, 61)
        turned = [cg.motion.pose.rotation("y", 2.0 * t, centre) for t in times]
        down = cg.motion.Poses(
            times, [down.pose(t) @ X for t, X in zip(times, turned, strict=True)]
        )
    body = cg.Body([wheel])
    simulation = cg.Simulation(
        bodies={"wheel": (body, down)},
        slaves={"sheet": sheet},
        contacts=[cg.Contact(body, sheet, law=cg.PenaltyLaw(0.01, per_area=True))],
        end=3.0,
        step=0.01,
    )
    assert "coarse" not in [one.rule for one in simulation.check()]
