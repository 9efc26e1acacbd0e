"""Bodies as points and triangles of a size: on the surface, closed, and none slips through."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import contiga as cg
from contiga.masters.sampling import MAX_TRIANGLES, default_size, refined


def test_new_points_lie_on_the_body() -> None:
    ball = cg.Body(cg.shapes.sphere(radius=10.0), name="ball", unit="mm")
    mesh = ball.tessellate(0.5, size=2.0)
    np.testing.assert_allclose(np.linalg.norm(mesh.vertices, axis=1), 10.0, rtol=1e-9)
    assert mesh.closed
    assert (mesh.name, mesh.unit) == ("ball", "mm")
    assert ball.tessellate(0.5).vertices.shape < mesh.vertices.shape


def test_a_mesh_is_cut_in_its_planes() -> None:
    ball = cg.Body(cg.shapes.sphere(radius=1.0)).tessellate(0.1)
    finer = refined(ball, ball, 0.2)
    assert finer.area() == pytest.approx(ball.area(), rel=1e-12)
    assert len(finer.triangles) > 4 * len(ball.triangles)


def test_sides_are_as_short_as_what_is_met_asks_for() -> None:
    plate = cg.Body(cg.shapes.plane(width=600.0, length=600.0))
    mesh = plate.tessellate(0.5)
    assert default_size(plate, mesh) == pytest.approx(0.1 * plate.size)
    assert default_size(plate, mesh, [4000.0, 173.2]) == pytest.approx(0.25 * 173.2)
    least = default_size(plate, mesh, [1e-3])
    assert 0.2 * MAX_TRIANGLES < len(refined(plate, mesh, least).triangles) <= MAX_TRIANGLES


CASE = """
units = { length = "mm", mass = "kg", time = "ms" }
time = { end = 4.0, step = 0.05 }
[[body]]
name = "post"
geometry = { shape = "sphere", radius = 50.0, centre = [130.0, 70.0, -50.0] }
[[body]]
name = "plate"
geometry = { shape = "plane", width = 600.0, length = 600.0, centre = [0, 0, 1], axis = [0, 0, -1] }
mass = { total = 2.7, centre = [0, 0, 1], inertia = [8e4, 8e4, 16e4, 0, 0, 0] }
motion = { kind = "free", velocity = [0, 0, -1] }
[[slave]]
name = "skin"
points = { body = "plate", tolerance = 0.5 }
[[contact]]
master = "post"
slave = "skin"
law = { kind = "penalty", stiffness = 1e-2, per_area = true }
[output]
report = false
"""


def test_a_plate_does_not_fall_through_what_is_under_its_middle(tmp_path: Path) -> None:
    path = tmp_path / "case.toml"
    path.write_text(CASE, encoding="utf-8")
    case = cg.load_case(path)
    assert len(cg.build(case).slaves["skin"].slave) > 200
    assert cg.run(case).history["n_contact"].max() > 0
    coarse = cg.load_case(path, set={"slave.skin.points.size": 1000.0})
    assert len(cg.build(coarse).slaves["skin"].slave) == 4
