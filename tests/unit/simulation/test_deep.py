"""A penalty that matter penetrates by more than a tenth of its elements is told, with a remedy."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest
from tests.blocks import block
from tests.scenes import square_sheet

import contiga as cg

LOW = {"layer": ([0, 0, -1], 0.0)}
RUBBER = cg.materials.NeoHooke(young=2.0, poisson=0.3)


def _block(size: float, kind: str = "hexahedron") -> cg.Slave:
    """Of elements of 10 lengths."""
    return block((3, 3, 2), (30.0 * size, 30.0 * size, 20.0 * size), kind=kind)


def _pressed(slave: cg.Slave, motion: Any, law: Any, size: float = 1.0) -> Any:
    """A ball that goes 6 lengths into the middle of a block, slowly, and half the way back."""
    top = slave.points[:, 2].max()
    ball = cg.Body([cg.shapes.sphere(radius=40.0 * size, centre=(15 * size, 15 * size, 0))])
    ways = [[0, 0, 0, top + 40.5 * size], [20, 0, 0, top + 34 * size], [24, 0, 0, top + 37 * size]]
    run = cg.Simulation(
        bodies={"ball": (ball, cg.motion.Translate(ways))},
        slaves={"pad": (slave, motion)},
        contacts=[cg.Contact(ball, slave, law=law, quadrature=3)],
        end=22.0,
        step="auto",
    ).run()
    return [cg.Finding(**one) for one in run.summary["findings"]], run.history


def _deforming(density: float, **options: Any) -> cg.motion.Deforming:
    return cg.motion.Deforming(
        **({"material": RUBBER, "fixed": LOW} | options), density=density, damping=0.1
    )


@pytest.mark.parametrize(("size", "kind"), [(1e-3, "hexahedron"), (1e3, "tetra")])
def test_it_is_told_and_the_stiffness_it_names_keeps_surfaces_apart(size: float, kind: str) -> None:
    slave, motion = _block(size, kind), _deforming(1e-3 / size**2)
    unit = motion.contact_stiffness(slave)
    found, soft = _pressed(slave, motion, cg.PenaltyLaw(0.1 * unit, per_area=True), size)
    (deep,) = [one for one in found if one.rule == "deep"]
    assert soft["max_penetration"].max() > 2.0 * size
    assert f"elements of pad are {10.0 * size:.4g}" in deep.text
    scale = float(re.search(r"scale = ([\d.e+-]+)", deep.remedy).group(1))
    found, stiff = _pressed(slave, motion, cg.PenaltyLaw(scale * unit, per_area=True), size)
    assert "deep" not in [one.rule for one in found]
    assert 0.1 * size < stiff["max_penetration"].max() < size
    assert stiff["force"].max() > 1.3 * soft["force"].max()


def test_other_laws_and_what_has_no_solid_elements_may_go_deep() -> None:
    curve = cg.StressLaw([[0, 0], [1.0, 0.5]], thickness=10.0)
    found, history = _pressed(_block(1.0), _deforming(1e-3), curve)
    assert history["max_penetration"].max() > 1.0
    assert "deep" not in [one.rule for one in found]
    nodes, quads = square_sheet(30.0, 4)
    sheet = cg.Slave(nodes + np.array([15.0, 15.0, 0.0]), quads)
    free = cg.motion.Free(mass=50.0)
    found, history = _pressed(sheet, free, cg.PenaltyLaw(1e-3, per_area=True))
    assert history["max_penetration"].max() > 1.0
    assert "deep" not in [one.rule for one in found]


def test_a_stiffness_a_point_is_told_as_one() -> None:
    slave, motion = _block(1.0), _deforming(1e-3)
    top = slave.points[:, 2].max()
    ball = cg.Body([cg.shapes.sphere(radius=40.0, centre=(15.0, 15.0, top + 40.5))])
    down = cg.motion.Translate([[0, 0, 0, 0], [20, 0, 0, -6.5]])
    found = (
        cg.Simulation(
            bodies={"ball": (ball, down)},
            slaves={"pad": (slave, motion)},
            contacts=[cg.Contact(ball, slave, law=cg.PenaltyLaw(3.0))],
            end=20.0,
            step="auto",
        )
        .run()
        .summary["findings"]
    )
    (deep,) = [one for one in found if one["rule"] == "deep"]
    assert re.search(r"stiffness = \d", deep["remedy"])
