"""Row sums of the stiffness, and the critical step they bound."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import eigh
from tests.unit.matter import rig

from contiga.materials import Elastic, Foam, NeoHooke
from contiga.matter import MatterState
from contiga.matter.coefficients import Material
from contiga.matter.kernels import row_sums_nb
from contiga.matter.kernels.lanes_nb import LANES, SIZE
from contiga.matter.kernels.row_sums_nb import GRADIENTS_SIZE, ROW, TANGENT, X

MATERIALS = [
    NeoHooke(young=3.0, poisson=0.45),
    Elastic(young=3.0, poisson=0.3),
]


@pytest.mark.interpreted
@pytest.mark.parametrize("material", MATERIALS)
@pytest.mark.parametrize("kind", ["tet4", "tri3"])
def test_of_one_element_they_are_exact(kind: str, material: Material) -> None:
    more = {"thickness": 0.3} if kind == "tri3" else {}
    nodes = rig.ONE_TET[: 4 if kind == "tet4" else 3]
    matter = rig.one_part(kind, nodes, np.arange(len(nodes))[None], material, **more)
    q = rig.moved(nodes * 1.1, 0.05)
    exact = np.abs(rig.tangent(matter, q)).sum(axis=1).reshape(-1, 3).max(axis=1)
    told = matter.stiffness(matter.start()._replace(points=q))
    np.testing.assert_allclose(told, exact, rtol=1e-5)


def test_of_a_hexahedron_they_bound_what_its_springs_add() -> None:
    matter = rig.one_part("hex8", rig.ONE_HEX, rig.hexes((1, 1, 1)), MATERIALS[0])
    q = rig.moved(rig.ONE_HEX * 1.1, 0.02)
    exact = np.abs(rig.tangent(matter, q)).sum(axis=1).reshape(-1, 3).max(axis=1)
    told = matter.stiffness(matter.start()._replace(points=q))
    assert (told >= exact * (1.0 - 1e-6)).all()
    assert (told <= 1.2 * exact).all()


def test_of_a_number_of_corners_without_a_branch_they_are_nan(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """With the terms of eight corners, or with none, the bound would be wrong in silence."""
    for name in ("_add_row_of_4", "_add_row_of_8"):
        monkeypatch.setattr(row_sums_nb, name, lambda *_: None)
    add_rows = vars(row_sums_nb)["add_rows"]
    add_rows = getattr(add_rows, "py_func", add_rows)  # interpreted: it has no entry
    bank, full = np.zeros(SIZE), np.ones(GRADIENTS_SIZE)
    add_rows(bank, np.ones(TANGENT), full, 6, np.ones(LANES))
    end = X + 6 * ROW
    assert np.isnan(bank[X:end]).all()
    assert not bank[:X].any()
    assert not bank[end:].any()


SOFT = NeoHooke(young=3.0, poisson=0.499, volume="nodes")


@pytest.mark.parametrize(
    ("kind", "material"),
    [(kind, material) for kind in ("tet4", "hex8") for material in MATERIALS] + [("tet4", SOFT)],
)
def test_the_step_they_allow_is_stable_and_not_much_too_short(
    material: Material, kind: str
) -> None:
    """On a mesh distorted by a fifth; the exact step is 2/√(largest eigenvalue)."""
    counts = (3, 3, 3)
    nodes = rig.moved(rig.grid(counts), 0.2 / 3 / 3)
    elements = rig.tets(counts) if kind == "tet4" else rig.hexes(counts)
    matter = rig.one_part(kind, nodes, elements, material)
    stiffness = rig.tangent(matter, nodes)
    fastest = eigh(0.5 * (stiffness + stiffness.T), np.diag(np.repeat(matter.mass, 3)))[0][-1]
    allowed = 2.0 * np.sqrt(np.min(matter.mass / matter.stiffness(matter.start())))
    least = 0.2 if material is SOFT else 0.5
    assert least < allowed / (2.0 / np.sqrt(fastest)) <= 1.0


def test_cloth_that_is_slack_is_as_stiff_as_when_it_is_taut() -> None:
    """But for what pressure takes off, one part in a hundred here."""
    nodes = rig.grid((2, 2, 0))
    cloth = Elastic(young=3.0, poisson=0.3, compression=False)
    taut = Elastic(young=3.0, poisson=0.3)
    slack, pressed = (
        matter.stiffness(matter.start()._replace(points=0.99 * nodes))
        for matter in (
            rig.one_part("tri3", nodes, rig.sheet(2, 2), material, thickness=0.1)
            for material in (cloth, taut)
        )
    )
    assert (pressed < slack).all()
    np.testing.assert_allclose(slack, pressed, rtol=0.02)


def test_foam_is_as_stiff_as_it_unloads() -> None:
    """From its deepest state it goes back much more steeply than it came."""
    foam = Foam(loading=[[0, 0], [0.9, 2.0]], hysteresis=0.1, shape=9.0)
    nodes = rig.grid((1, 1, 1))
    matter = rig.one_part("hex8", nodes, rig.hexes((1, 1, 1)), foam)
    top = nodes[:, 2] == 1.0

    def pressed(strain: float, state: MatterState) -> tuple[float, MatterState]:
        answer = matter.forces(state, nodes * [1.0, 1.0, 1.0 - strain], 0.0 * nodes, 0.0)
        return float(answer.force[top, 2].sum()), answer.state

    deep, state = pressed(0.3, matter.start())
    more, _ = pressed(0.3 + 1e-6, state)
    back, _ = pressed(0.3 - 1e-6, state)
    loading, unloading = (more - deep) / 1e-6, (deep - back) / 1e-6
    assert unloading > 5.0 * loading
    assert matter.stiffness(state)[top].sum() >= unloading
