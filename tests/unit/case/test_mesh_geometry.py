"""`geometry = { mesh = … }` of a case: what it makes, and what it refuses."""

from __future__ import annotations

from pathlib import Path

import meshio
import numpy as np
import pytest

import contiga as cg
from contiga.case.build import build
from contiga.case.describe import description
from contiga.errors import InputError

BALL = cg.shapes.sphere(radius=1.0).tessellate(0.05)
GOOD = 'geometry = { mesh = "ball.vtu" }'
CASE = """
title = "Mesh"
units = { length = "mm", mass = "g", time = "ms" }
time = { end = 1.0, step = 0.5 }
[[body]]
name = "ball"
geometry = { mesh = "ball.vtu" }
[[slave]]
name = "sheet"
points = { grid = { shape = "plane", width = 2, length = 2, nu = 5, nv = 5 } }
[[contact]]
master = "ball"
slave = "sheet"
law = { kind = "penalty", stiffness = 1.0 }
"""


def write(path: Path, points: np.ndarray, triangles: np.ndarray) -> None:
    meshio.write(path, meshio.Mesh(points, [("triangle", triangles)]))


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    write(tmp_path / "ball.vtu", BALL.vertices, BALL.triangles)
    return tmp_path


def load(folder: Path, geometry: str = GOOD, area: str = "") -> cg.TriMesh:
    case = folder / "case.toml"
    case.write_text(CASE.replace(GOOD, geometry) + area, encoding="utf-8")
    body = build(cg.load_case(case)).bodies["ball"].body
    assert isinstance(body, cg.TriMesh)
    return body


def test_a_mesh_is_placed_flipped_and_named(folder: Path) -> None:
    mesh = load(
        folder,
        'geometry = { mesh = "ball.vtu", unit = "m", normals = "vertex", flip = true, '
        "transform = [{ translate = [1, 0, 0] }] }\nreference_point = [0, 2, 0]",
    )
    assert (mesh.name, mesh.normal_kind, mesh.unit) == ("ball", "vertex", "mm")
    assert mesh.volume() == pytest.approx(-1e9 * BALL.volume())
    np.testing.assert_allclose(mesh.bounds(), 1e3 * BALL.bounds() + [1, 0, 0], rtol=0, atol=1e-9)
    assert mesh.reference_point.tolist() == [0.0, 2.0, 0.0]


def test_a_case_says_what_its_mesh_is(folder: Path) -> None:
    load(folder)
    assert "ball.vtu, facet normals" in description(cg.load_case(folder / "case.toml"))


def test_triangles_are_turned_on_demand(folder: Path) -> None:
    triangles = BALL.triangles.copy()
    triangles[::3] = triangles[::3, ::-1]
    write(folder / "ball.vtu", BALL.vertices, triangles)
    with pytest.raises(InputError, match=r"body\[0\]\.geometry.*opposite ways.*orient = true"):
        load(folder)
    mesh = load(folder, 'geometry = { mesh = "ball.vtu", orient = true }')
    assert mesh.volume() == pytest.approx(BALL.volume())


@pytest.mark.parametrize(
    ("geometry", "message"),
    [
        ('{ mesh = "none.vtu" }', r"body\[0\]\.geometry\.mesh: no such file"),
        ('{ mesh = "ball.vtu", normals = "smooth" }', r"body\[0\]\.geometry\.normals"),
        ('{ mesh = "ball.vtu", normal = "facet" }', "Did you mean 'normals'"),
        ('{ mesh = "ball.vtu", file = "ball.vtu" }', "exactly one of the keys"),
        ('{ mesh = "ball.vtu", parts = [] }', r"body\[0\]\.geometry\.parts"),
        ('{ mesh = "ball.vtu", parts = ["rim"] }', "rim"),
        ('{ mesh = "cloud.csv" }', "points alone cannot be a master"),
        ('{ mesh = "ball.step" }', r"is CAD, not a mesh.*geometry = { file"),
        ('{ file = "ball.vtu" }', r"is not a CAD file.*geometry = { mesh"),
        ('{ mesh = "flat.vtu" }', "none of the triangles has an area"),
    ],
)
def test_wrong_meshes_are_refused_with_the_key(folder: Path, geometry: str, message: str) -> None:
    np.savetxt(folder / "cloud.csv", BALL.vertices, delimiter=",")
    (folder / "ball.step").write_text("ISO-10303-21;")
    line = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0]])
    write(folder / "flat.vtu", line, np.array([[0, 1, 2]]))
    with pytest.raises(InputError, match=message) as caught:
        load(folder, f"geometry = {geometry}")
    assert "body[0].geometry" in str(caught.value)


def test_hulls_on_a_mesh_are_refused(folder: Path) -> None:
    with pytest.raises(InputError, match=r"contact\[0\].*a mesh does not have.*FacetArea"):
        load(folder, GOOD, 'area = { kind = "hull" }\n')
