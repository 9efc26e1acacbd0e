"""The small picture of an object in a notebook, and its PNG."""

from __future__ import annotations

from io import BytesIO

import numpy as np
from PIL import Image

import contiga as cg
from contiga.rendering.picture import picture_of, png

CUBE = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
SQUARES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
FACETS = np.array([t for a, b, c, d in SQUARES for t in ((a, b, c), (a, c, d))], dtype=np.int32)


def pixels(content: bytes) -> np.ndarray:
    with Image.open(BytesIO(content)) as picture:
        return np.asarray(picture.convert("RGB"))


def test_png_holds_the_pixels() -> None:
    given = np.random.default_rng(0).integers(0, 256, (7, 5, 3), dtype=np.uint8)
    np.testing.assert_array_equal(pixels(png(given)), given)


def test_a_cube_has_three_flat_faces_between_sharp_edges() -> None:
    shown = pixels(picture_of(CUBE, FACETS))
    assert shown.shape == (300, 400, 3)
    _, counts = np.unique(shown.reshape(-1, 3) // 8, axis=0, return_counts=True)
    # the background, and each face in one or two neighbouring shades: flat across its diagonal
    assert counts[counts > 1500].sum() > 0.93 * counts.sum()
    assert (counts > 1500).sum() <= 8
    grey = shown.astype(int).sum(axis=2)
    edge = grey[150, 180:250]  # across the vertical edge in front: flat on both sides of it
    line = int(edge.argmin())
    assert np.ptp(edge[: line - 2]) <= 6 >= np.ptp(edge[line + 3 :])
    assert edge[line] < 0.93 * min(edge[0], edge[-1])


def test_bodies_meshes_and_slaves_show_a_picture_of_less_than_200_kb() -> None:
    ball = cg.Body([cg.shapes.sphere(radius=2.0)], name="ball")
    bumps = cg.shapes.bumpy_plate()
    slave = cg.Slave([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]], name="sheet")
    for shown in (ball, ball.tessellate(0.01), slave):
        html = shown._repr_html_()
        assert "<img alt=" in html
        assert len(html) < 200_000
    assert len(bumps._repr_png_()) < 150_000
    cloud = cg.Slave([[0.0, 0.0, 0.0]], name="cloud")
    assert "<img" not in cloud._repr_html_()
