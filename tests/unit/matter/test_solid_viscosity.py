"""Bulk viscosity: the pressure it adds and the energy it takes."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
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
    # from rest, where there was none, to J = 0.88: the mean of both ends
    assert told.energy.viscosity == pytest.approx(0.5 * q_bulk * 0.12 * 8.0, rel=1e-12)


def test_what_it_takes_closes_the_balance_to_second_order() -> None:
    """A cube pressed, turned and let go: the work of the forces less what is stored."""
    matter, errors = cube("hex8", (0.06, 1.5)), []
    for n in (50, 100):
        state, lost, work, force = matter.start(), 0.0, 0.0, np.zeros_like(matter.nodes)
        for t in np.linspace(0.0, 1.0, n + 1)[1:]:
            turn = Rotation.from_rotvec([0.0, 0.4 * t, t]).as_matrix()
            q = matter.nodes * (1.0 - np.array([0.1, 0.2, 0.3]) * np.sin(np.pi * t) ** 2) @ turn
            way = q - state.points
            answer = matter.forces(state, q, way * n, 1.0 / n)
            work -= 0.5 * float(np.sum((force + answer.force) * way))
            state, force = answer.state, answer.force
            lost += answer.energy.viscosity
        errors.append(abs(work - lost - answer.energy.strain - answer.energy.hourglass) / lost)
    assert lost > 0.0
    assert errors[1] < min(errors[0] / 3.5, 1e-3)


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
