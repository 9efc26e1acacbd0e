"""Maps: triangles made finer without gaps, values linear between targets."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from tests.figures import checked

import contiga as cg
from contiga.errors import CaseError
from contiga.report.figure import Figure
from contiga.studies.maps import between, draw_map, map_figure, map_of, nearest, refined
from contiga.studies.row import DONE, FAILED, Row

from .conftest import base_in, study_from

TEXT = """
base = "case.toml"
collect = ["max(force)"]
map = { body = "ball", at = ["x", "y", "z"] }
table = "targets.csv"
""" + "".join(
    f'[[variable]]\nname = "{a}"\nkey = "body.ball.geometry.centre[{k}]"\ncolumn = "{a}"\n'
    for k, a in enumerate("xyz")
)


def test_finer_triangles_are_the_same_surface_without_gaps() -> None:
    mesh = cg.Body([cg.shapes.sphere(radius=10.0)]).tessellate(0.5)
    points, triangles = refined(mesh.vertices, mesh.triangles, 1.5)
    finer = cg.TriMesh(points, triangles)
    assert finer.closed
    assert finer.area() == pytest.approx(mesh.area(), rel=1e-12)
    edges = points[triangles] - points[np.roll(triangles, 1, axis=1)]
    assert np.linalg.norm(edges, axis=2).max() <= 1.5
    assert len(triangles) > 2 * len(mesh.triangles)


def test_values_are_linear_between_targets_whatever_their_plane() -> None:
    rng = np.random.default_rng(3)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    flat = np.column_stack([rng.uniform(-1, 1, (40, 2)), np.zeros(40)])
    inside = np.column_stack([rng.uniform(-0.4, 0.4, (20, 2)), np.zeros(20)])

    def field(p: np.ndarray) -> np.ndarray:
        return np.asarray(3.0 + 2.0 * p[:, 0] - p[:, 1])

    actual = between(flat @ turn, field(flat), inside @ turn)
    assert actual == pytest.approx(field(inside), abs=1e-12)
    assert np.isnan(between(flat @ turn, field(flat), np.array([[5.0, 0.0, 0.0]]) @ turn)).all()
    line = np.outer(np.arange(5.0), [1.0, 2.0, 3.0])
    assert np.isnan(between(line, np.arange(5.0), inside)).all()


def test_a_map_has_the_greatest_value_of_each_target(folder: Path) -> None:
    (folder / "targets.csv").write_text("x,y,z\n0,0,0\n", encoding="utf-8")
    study, base = study_from(TEXT, folder), base_in(folder)
    at = [(0.0, 0.0, 10.5), (4.0, 0.0, 9.0), (0.0, 4.0, 9.0), (4.0, 0.0, 9.0), (9.0, 9.0, 9.0)]
    forces = [1.0, 2.0, 3.0, 7.0, float("nan")]

    def row(number: int, place: tuple[float, ...], force: float) -> Row:
        status = FAILED if force != force else DONE
        values = dict(zip("xyz", place, strict=True))
        return Row(number, status, "", values, {"max(force)": force}, 0.0)

    rows = tuple(map(row, range(1, 6), at, forces))
    actual = map_of(study, base, rows)
    assert actual is not None
    assert actual.cases == [1, 4, 3, 5]
    assert actual.shades.limits == (1.0, 7.0)
    assert actual.label == "max(force) [N]"
    assert actual.hit[1] == 7.0
    assert np.isfinite(actual.values).any()
    assert np.isnan(actual.values).any()
    draw_map(actual, "Ball", folder / "map.png")
    assert (folder / "map.png").read_bytes()[:4] == b"\x89PNG"
    drawn = map_figure(actual, {row.number: row.number - 1 for row in rows})
    assert drawn["data"][1]["customdata"] == [0, 3, 2, 4]
    assert len(checked(Figure(drawn["data"], drawn["layout"])).data) == 2
    assert map_of(study, base, rows[4:]) is None


def test_the_nearest_target_colours_what_is_about_it() -> None:
    x = np.arange(5.0)
    grid = np.stack([*np.meshgrid(x, x, indexing="ij"), np.zeros((5, 5))], axis=-1).reshape(-1, 3)
    rng = np.random.default_rng(4)
    hit, points = rng.normal(size=25), rng.uniform(0.0, 4.0, (200, 3)) * [1.0, 1.0, 0.0]
    brute = hit[np.linalg.norm(points[:, None] - grid, axis=2).argmin(axis=1)]
    assert nearest(grid, hit, points).tolist() == brute.tolist()
    assert np.isnan(nearest(grid, hit, np.array([[-0.8, 2.0, 0.0], [2.0, 2.0, 0.9]]))).all()
    hit[12] = np.nan  # a case that failed colours nothing, its neighbours reach what they reach
    assert np.isnan(nearest(grid, hit, grid[12:13])).all()
    assert np.isnan(nearest(grid[:1], hit[:1], points)).all()


@pytest.mark.parametrize(
    ("way", "said"), [("linear", "are linear"), ("nearest", "those of the nearest")]
)
def test_a_map_has_bands_and_says_what_is_between(folder: Path, way: str, said: str) -> None:
    (folder / "targets.csv").write_text("x,y,z\n0,0,0\n", encoding="utf-8")
    more = f'"z"], bands = [650, 1000, 1350, 1700], between = "{way}" }}'
    study = study_from(TEXT.replace('"z"] }', more), folder)
    at = [(0.0, 0.0, 0.0), (10.0, 0.0, 0.0), (0.0, 10.0, 0.0), (-10.0, 0.0, 0.0), (0.0, -10.0, 0.0)]
    values = [600.0, 650.0, 1200.0, 1699.0, 2000.0]
    rows = tuple(
        Row(k, DONE, "", dict(zip("xyz", p, strict=True)), {"max(force)": v}, 0.0)
        for k, (p, v) in enumerate(zip(at, values, strict=True), start=1)
    )
    actual = map_of(study, base_in(folder), rows)
    assert actual is not None
    assert said in actual.between
    assert np.isfinite(actual.values).any()
    draw_map(actual, "Ball", folder / "map.png")
    drawn = map_figure(actual, {k: k for k in range(1, 6)})
    marker = checked(Figure(drawn["data"], drawn["layout"])).data[1].marker
    assert actual.shades.places(actual.hit).tolist() == [0, 1, 2, 3, 4]
    assert marker.colorbar.ticktext[0] == "650"


@pytest.mark.parametrize(
    ("more", "match"),
    [
        ("bands = [650, 650]", "map.bands: must rise"),
        ("bands = []", "map.bands"),
        ("limits = [3, 1]", "map.limits: must rise"),
        ("limits = [1, 3], bands = [2]", "one of the two"),
        ('between = "natural"', "map.between.*linear"),
    ],
)
def test_wrong_maps_are_told(folder: Path, more: str, match: str) -> None:
    (folder / "targets.csv").write_text("x,y,z\n0,0,0\n", encoding="utf-8")
    with pytest.raises(CaseError, match=match):
        study_from(TEXT.replace('"z"] }', f'"z"], {more} }}'), folder)
