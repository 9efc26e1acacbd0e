"""What results tell of springs: forces, elongations, rates and energies, beside closed forms."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg
from contiga.errors import InputError
from contiga.simulation.parts import spring_parts

MASS, STIFFNESS, SPEED = 2.0, 800.0, 3.0
OMEGA = np.sqrt(STIFFNESS / MASS)


def swung(*springs: cg.Spring, **options: object) -> cg.Result:
    """A ball that flies off along x at its springs, three quarters of a swing, for kg, m, s."""
    ball = cg.Body([cg.shapes.sphere(radius=0.1)])
    motion = cg.motion.Free(MASS, inertia=np.eye(3), velocity=(SPEED, 0, 0), hold=("ry", "rz"))
    arguments: dict[str, object] = {"end": 1.5 * np.pi / OMEGA, "step": 1e-4, **options}
    return cg.Simulation(
        bodies={"ball": (ball, motion)},
        slaves={},
        contacts=[],
        springs=springs,
        units=("m", "kg", "s"),
        **arguments,  # type: ignore[arg-type]
    ).run()


def belt(**options: object) -> cg.Spring:
    given: dict[str, object] = {"curve": STIFFNESS, "name": "belt"} | options
    return cg.Spring(("ground", "ball"), at=[[-1, 0, 0], [0, 0, 0]], **given)  # type: ignore[arg-type]


def test_a_spring_tells_its_force_elongation_rate_and_energy() -> None:
    result = swung(belt())
    told, t = result.history, result.history["time"]
    x = SPEED / OMEGA * np.sin(OMEGA * t)
    np.testing.assert_allclose(told["belt.elongation"], x, atol=1e-6)
    np.testing.assert_allclose(told["belt.force"], STIFFNESS * told["belt.elongation"], rtol=1e-12)
    np.testing.assert_allclose(told["belt.rate"], told["ball.vx"], rtol=1e-12)
    stored = 0.5 * STIFFNESS * told["belt.elongation"] ** 2
    np.testing.assert_allclose(told["belt.energy_stored"], stored, rtol=1e-12, atol=1e-15)
    assert not told["belt.energy_damping"].any()
    units = {name: result.summary["columns"][f"belt.{name}"] for name in ("force", "elongation")}
    assert units == {"force": "N", "elongation": "m"}
    assert result.summary["columns"]["belt.rate"] == "m/s"
    assert result.summary["columns"]["belt.energy_stored"] == "J"
    assert result.summary["springs"]["belt"]["between"] == ["ground", "ball"]


def test_springs_add_up_to_the_energies_of_the_system() -> None:
    damper = cg.Spring(("ball", "ground"), at=[[0, 0, 0], [0, 1, 0]], damping=5.0, name="oil")
    history = swung(belt(damping=2.0), damper).history
    for mine, whole in (("energy_stored", "strain"), ("energy_damping", "damping")):
        np.testing.assert_allclose(
            history[f"belt.{mine}"] + history[f"oil.{mine}"], history[f"energy.{whole}"], rtol=1e-12
        )


def test_a_filtered_force_is_that_of_the_class() -> None:
    history = swung(belt(filter="CFC60"), step=5e-4, end=0.2).history
    smooth = cg.criteria.cfc(history["belt.force"], 5e-4, 60)
    np.testing.assert_allclose(history["belt.filtered_force"], smooth, rtol=1e-9)
    coarse = swung(belt(filter="CFC1000"), step=5e-4)
    assert "belt.filtered_force" not in coarse.history
    assert any("belt: the steps are too long for CFC1000" in w for w in coarse.summary["warnings"])


def test_steps_that_choose_themselves_are_short_enough_for_the_filter() -> None:
    history = swung(belt(filter="CFC600"), step="auto", end=0.02).history
    assert np.diff(history["time"]).max() <= 1.0 / 6000.0 * (1.0 + 1e-6)
    assert "belt.filtered_force" in history


def test_springs_are_not_called_as_others_are() -> None:
    with pytest.raises(InputError, match=r"springs\['ball'\]: name: must have a name of its own"):
        swung(belt(name="ball"))
    with pytest.raises(InputError, match="filter: is not known; found 'CFC6'; allowed: 'CFC60', "):
        belt(filter="CFC6")
    still = cg.Body([cg.shapes.sphere(radius=0.1)])
    with pytest.raises(InputError, match=r"springs\['belt'\]: filter: needs units"):
        cg.Simulation(
            bodies={"ball": (still, cg.motion.Free(1.0, inertia=np.eye(3)))},
            slaves={},
            contacts=[],
            springs=[belt(filter="CFC60")],
            end=1.0,
            step=0.1,
        )


def test_a_single_spring_needs_no_list() -> None:
    ends = {"at": [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]], "curve": 1.0}
    named = cg.Spring(("a", "ground"), name="tie", **ends)
    unnamed = cg.Spring(("a", "ground"), **ends)
    assert list(spring_parts(named)) == list(spring_parts([named])) == ["tie"]
    assert list(spring_parts(unnamed)) == list(spring_parts([unnamed]))
    with pytest.raises(InputError, match="must be springs"):
        spring_parts(3.0)
