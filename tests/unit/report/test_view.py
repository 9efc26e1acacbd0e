"""Pictures in space: what hides what, and that it is drawn where it is."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from contiga.geometry import shapes
from contiga.masters.body import Body
from contiga.report.view import View, _fine

BALL = shapes.sphere(radius=1.0)
TOWARDS = np.array([0.0, 1.0, 0.0])


def view() -> View:
    figure = Figure()
    FigureCanvasAgg(figure)
    return View(figure.subplots(), BALL.control_points, towards=TOWARDS, shape=(200, 160))


def test_points_behind_a_surface_are_hidden() -> None:
    scene = view().surface(BALL)
    _, seen = scene._projected(np.array([[0.0, -1.2, 0.0], [0.0, 1.2, 0.0], [0.0, 0.0, 0.0]]))
    assert seen.tolist() == [True, False, False]


def test_a_surface_that_hides_nothing_leaves_points_seen() -> None:
    scene = view().surface(BALL, hides=False)
    assert scene._projected(np.array([[0.0, 1.2, 0.0]]))[1].all()


def test_points_land_where_the_eye_sees_them() -> None:
    at, _ = view()._projected(np.array([[0.0, 0.0, 0.0], [0.5, 0.0, 0.0], [0.0, 0.0, 0.5]]))
    np.testing.assert_allclose(at[0], [99.75, 79.75], rtol=0, atol=0.5)
    assert at[1, 0] > at[0, 0] + 10
    assert at[1, 1] == pytest.approx(at[0, 1])
    assert at[2, 1] < at[0, 1] - 10


def test_a_line_is_cut_so_that_parts_of_it_can_hide() -> None:
    fine = _fine(np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.0, 0.05]]), 0.1)
    np.testing.assert_allclose(fine[:11, 0], np.linspace(0.0, 1.0, 11), atol=1e-15)
    assert np.linalg.norm(np.diff(fine, axis=0), axis=1).max() <= 0.1 + 1e-12
    np.testing.assert_array_equal(fine[-1], [1.0, 0.0, 0.05])


def test_a_shaded_surface_shows_in_the_picture() -> None:
    def draw(figure: Figure) -> None:
        scene = View(figure.subplots(), BALL.control_points, shape=(120, 90))
        scene.surface(BALL, "#4060a0").iso_lines(BALL, 5).dots([[0.0, 0.0, 1.5]])
        scene.arrow((0, 0, 1), (0, 0, 1.5)).text((0, 0, 1.5), "top").show()

    from io import BytesIO

    from matplotlib.image import imread

    figure, content = Figure(figsize=(2.0, 1.5)), BytesIO()
    FigureCanvasAgg(figure)
    draw(figure)
    figure.savefig(content, format="png")
    content.seek(0)
    image = imread(content)[..., :3]
    middle = image[image.shape[0] // 2, image.shape[1] // 2]
    assert middle[2] > middle[0] + 0.1
    assert (image[0, 0] == 1.0).all()


def test_a_mesh_may_have_colours_of_its_vertices() -> None:
    mesh = Body([BALL]).tessellate(0.01)
    right = mesh.vertices[:, 0] > 0.0
    scene = view()
    scene.surface(mesh, colours=np.where(right[:, None], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]))
    rows, columns = scene._picture.shape[:2]
    left_side, right_side = (
        scene._picture[rows // 2, columns // 2 + k * columns // 10] for k in (-1, 1)
    )
    assert left_side[2] > left_side[0] + 0.3
    assert right_side[0] > right_side[2] + 0.3
