"""States and results as data sets of pyvista."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

import contiga as cg
from contiga.errors import InputError, MissingPackageError

BALL = cg.Body([cg.shapes.sphere(radius=1.0)], name="ball")
SHEET = cg.Slave(
    [[-1, -1, 1.2], [1, -1, 1.2], [1, 1, 1.2], [-1, 1, 1.2], [0, 0, 1.2]],
    [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]],
    name="sheet",
)
DOWN = cg.motion.Translate([[0, 0, 0, 0], [1, 0, 0, -0.4]])


def simulation() -> cg.Simulation:
    contact = cg.Contact(BALL, SHEET, law=cg.PenaltyLaw(100.0))
    return cg.Simulation(
        bodies={"ball": (BALL, cg.motion.Translate([[0, 0, 0, 0], [1, 3, 0, 0.5]]))},
        slaves={"sheet": (SHEET, DOWN)},
        contacts=[contact],
        end=1.0,
        step=0.5,
    )


def test_a_state_is_placed_and_has_the_forces_on_its_points() -> None:
    pytest.importorskip("pyvista")
    model = simulation()
    state = model.step(model.start())
    scene = model.to_pyvista(state)
    assert scene.keys() == ["ball", "sheet"]
    np.testing.assert_allclose(scene["ball"].center, [1.5, 0.0, 0.25], atol=1e-2)
    np.testing.assert_array_equal(scene["sheet"].points, state.slaves["sheet"].points)
    contact = state.contacts["ball-sheet"]
    np.testing.assert_array_equal(scene["sheet"].point_data["force"], contact.force)
    np.testing.assert_array_equal(scene["sheet"].point_data["penetration"], contact.penetration)
    assert scene["sheet"].n_cells == 4


def test_a_result_shows_the_recorded_step_that_is_asked_for(tmp_path: Path) -> None:
    pytest.importorskip("pyvista")
    result = simulation().run(tmp_path / "out")
    for shown in (result.to_pyvista(0.5), cg.open_result(tmp_path / "out").to_pyvista(0.5)):
        np.testing.assert_allclose(shown["ball"].center, [1.5, 0.0, 0.25], atol=1e-2)
        assert {"force", "pressure"} <= set(shown["sheet"].point_data.keys())
    np.testing.assert_allclose(result.to_pyvista()["ball"].center, [3.0, 0.0, 0.5], atol=1e-2)
    with pytest.raises(InputError, match=r"simulation\.to_pyvista\(state\)"):
        simulation().run().to_pyvista()


def test_bodies_and_slaves_keep_their_shape() -> None:
    pytest.importorskip("pyvista")
    assert BALL.to_pyvista(tol=1e-3).volume == pytest.approx(4.0 / 3.0 * np.pi, rel=5e-3)
    mesh = BALL.tessellate(0.01)
    np.testing.assert_array_equal(mesh.to_pyvista().points, mesh.vertices)
    assert SHEET.to_pyvista().area == pytest.approx(4.0)
    assert cg.Slave([[0.0, 0.0, 0.0]]).to_pyvista().n_points == 1


def test_without_pyvista_the_message_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pyvista", None)
    with pytest.raises(MissingPackageError, match=r"contiga\[pyvista\]"):
        BALL.to_pyvista()
