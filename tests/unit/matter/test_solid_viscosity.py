"""Bulk viscosity: the pressure it adds and the energy it takes."""

from __future__ import annotations

import numpy as np
import pytest
from tests.unit.matter import rig

from contiga.errors import InputError
from contiga.materials import Elastic, NeoHooke
from contiga.matter import Assembled, Part, assemble


def cube(kind: str, viscosity: tuple[float, float]) -> Assembled:
    """A cube of side two."""
    counts = (1, 1, 1)
    elements = rig.hexes(counts) if kind == "hex8" else rig.tets(counts)
    material = NeoHooke(young=3.0, poisson=0.25)
    part = Part(
        kind=kind, elements=elements, material=material, density=1.2, bulk_viscosity=viscosity
    )
    return assemble(2.0 * rig.grid(counts), [part])


@pytest.mark.parametrize("kind", ["hex8", "tet4"])
def test_it_adds_its_pressure_where_the_volume_shrinks(kind: str) -> None:
    b, a = 0.06, 1.5
    matter, plain = cube(kind, (b, a)), cube(kind, (0.0, 0.0))
    q = matter.nodes * [1.0, 0.8, 1.1]
    rate = np.array([0.1, -0.5, 0.05])
    v = q * rate
    told, dry = (m.forces(m.start(), q, v, 0.01) for m in (matter, plain))
    extra = told.force - dry.force
    change = rate.sum()
    size = np.cbrt(8.0 if kind == "hex8" else 8.0 / 6.0)
    speed = np.sqrt((1.2 + 2.0 * 1.2) / 1.2)  # λ = μ = 1.2
    q_bulk = 1.2 / 0.88 * size * (b * speed * -change + a * size * change**2)
    upper = matter.nodes[:, 2] == 2.0
    assert extra[upper, 2].sum() == pytest.approx(q_bulk * 2.0 * 1.6, rel=1e-12)
    assert told.energy.viscosity == pytest.approx(-np.sum(extra * v) * 0.01, rel=1e-12)
    assert told.energy.viscosity > 0.0


def test_it_does_nothing_where_the_volume_grows() -> None:
    matter, plain = cube("hex8", (0.06, 1.5)), cube("hex8", (0.0, 0.0))
    q = 0.9 * matter.nodes
    told, dry = (m.forces(m.start(), q, q, 0.01) for m in (matter, plain))
    np.testing.assert_array_equal(told.force, dry.force)
    assert told.energy.viscosity == 0.0


@pytest.mark.parametrize(("kind", "wrong"), [("tet4", (-0.1, 0.0)), ("tri3", (0.06, 1.5))])
def test_a_wrong_one_is_refused(kind: str, wrong: tuple[float, float]) -> None:
    more = {"thickness": 1.0} if kind == "tri3" else {}
    elements = np.array([[0, 1, 2, 3][: 3 if kind == "tri3" else 4]])
    with pytest.raises(InputError, match="bulk_viscosity"):
        Part(
            kind=kind,
            elements=elements,
            material=Elastic(young=1.0),
            density=1.0,
            bulk_viscosity=wrong,
            **more,
        )
