"""Masses that are scaled for a step: enough of them, no more, and told part by part."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import eigh
from tests.blocks import block
from tests.unit.matter import rig

import contiga as cg
from contiga.errors import InputError
from contiga.materials import Elastic, NeoHooke
from contiga.matter import Assembled, Part, assemble

STEP = 0.05


def uneven(mass_scaling: float | None = None, free: np.ndarray | None = None) -> Assembled:
    """Two parts, of which the upper one has flat elements."""
    counts = (2, 2, 4)
    nodes, elements = rig.grid(counts), rig.hexes(counts)
    nodes[:, 2] = np.array([0.0, 0.45, 0.9, 0.95, 1.0])[np.rint(4.0 * nodes[:, 2]).astype(int)]
    upper = nodes[elements][:, :, 2].mean(axis=1) > 0.9
    parts = [
        Part(kind="hex8", elements=elements[~upper], material=Elastic(young=5.0, poisson=0.3),
             density=1.0, name="lower"),
        Part(kind="hex8", elements=elements[upper], material=NeoHooke(young=5.0, poisson=0.3),
             density=1.0, name="upper"),
    ]  # fmt: skip
    return assemble(nodes, parts, mass_scaling=mass_scaling, free=free)


def fastest(matter: Assembled) -> float:
    """ω by the eigenvalues of the tangent, by differences of forces."""
    n, h = matter.nodes.size, 1e-6
    columns = []
    for k in range(n):
        way = np.zeros(n)
        way[k] = h
        way = way.reshape(-1, 3)
        ends = [rig.still(matter, matter.nodes + sign * way)[0].ravel() for sign in (-1.0, 1.0)]
        columns.append((ends[0] - ends[1]) / (2.0 * h))
    stiff = np.stack(columns, axis=1)
    return float(
        np.sqrt(eigh(0.5 * (stiff + stiff.T), np.diag(np.repeat(matter.mass, 3)))[0].max())
    )


def test_the_step_asked_for_is_stable_and_was_not_before() -> None:
    assert 2.0 / fastest(uneven()) < STEP
    scaled = uneven(STEP)
    assert 2.0 / fastest(scaled) >= STEP
    # Gershgorin's bound is no more than twice too high in ω².
    assert 0.6 * 2.0 / fastest(scaled) < STEP


def test_only_what_is_too_light_gets_more_and_the_parts_tell_all_of_it() -> None:
    plain, scaled = uneven(), uneven(STEP)
    more = scaled.mass - plain.mass
    low = plain.nodes[:, 2] < 0.4
    np.testing.assert_array_equal(more[low], 0.0)
    assert (more[plain.nodes[:, 2] > 0.94] > 0.0).all()
    assert sum(one.added for one in scaled.added) == pytest.approx(more.sum(), rel=1e-12)
    assert sum(one.mass for one in scaled.added) == pytest.approx(plain.mass.sum(), rel=1e-12)
    lower, upper = scaled.added
    assert (lower.part, upper.part) == ("lower", "upper")
    assert lower.added == 0.0
    assert upper.share == pytest.approx(more.sum() / upper.mass, rel=1e-12)
    assert plain.added == ()


def test_what_no_force_moves_gets_none() -> None:
    free = np.arange(len(uneven().mass)) % 2 == 0
    scaled = uneven(STEP, free)
    np.testing.assert_array_equal(scaled.mass[~free], uneven().mass[~free])
    np.testing.assert_array_equal(scaled.mass[free], uneven(STEP).mass[free])


def run(mass_scaling: float | None) -> cg.Result:
    """A block of flat hexahedra that falls on a plane."""
    soft = block((3, 3, 6), (1.0, 1.0, 0.3), (-0.5, -0.5, 0.01), kind="hexahedron")
    ground = cg.Body([cg.shapes.plane(width=4.0, length=4.0)])
    motion = cg.motion.Deforming(
        material=Elastic(young=5e4, poisson=0.3),
        density=1.0,
        velocity=(0.0, 0.0, -0.2),
        mass_scaling=mass_scaling,
    )
    return cg.Simulation(
        bodies={"ground": ground},
        slaves={"block": (soft, motion)},
        contacts=[cg.Contact(ground, soft, law=cg.PenaltyLaw(1e5, per_area=True), quadrature=3)],
        end=0.1,
        step="auto",
    ).run()


def test_a_run_takes_longer_steps_and_says_what_they_cost() -> None:
    plain, scaled = run(None), run(1e-3)
    # Contacts shorten both.
    assert np.median(np.diff(scaled.history["time"])) > 2.0 * np.median(
        np.diff(plain.history["time"])
    )
    assert plain.summary["mass_scaling"] == {}
    ((part,),) = scaled.summary["mass_scaling"].values()
    assert part["share"] == pytest.approx(part["added"] / part["mass"])
    assert part["mass"] == pytest.approx(0.3, rel=1e-12)
    (told,) = [one for one in scaled.summary["findings"] if one["rule"] == "scaled"]
    assert "mass scaling gives" in told["text"]
    energy = scaled.history["energy.total"][0]
    assert energy == pytest.approx(0.5 * (part["mass"] + part["added"]) * 0.2**2, rel=1e-12)
    assert np.abs(scaled.history["energy.error"]).max() < 1e-3 * energy


def test_wrong_times_and_matter_of_ones_own_are_refused() -> None:
    with pytest.raises(InputError, match="mass_scaling"):
        cg.motion.Deforming(material=Elastic(young=1.0), density=1.0, mass_scaling=0.0)
    with pytest.raises(InputError, match="mass_scaling: asks for masses beyond"):
        uneven(1e200)
    with pytest.raises(InputError, match="its masses"):
        cg.motion.Deforming(material=uneven(), mass_scaling=1.0)
