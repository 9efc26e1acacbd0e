"""The still picture shows the contact where it is."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from contiga.io.vtkhdf import read_fields
from contiga.report.camera import project
from contiga.report.peak import Peak, at_frame
from contiga.report.scene import (
    SLAVE,
    draw_still,
    outside_direction,
    outside_view,
    render,
    slave_colours,
    through_view,
    upwards,
)
from contiga.report.shading import mesh_layer

from .conftest import write_fields


def peak_at(tmp_path: Path, frame: int, *, cloud: bool = False) -> Peak:
    write_fields(tmp_path / "fields.vtkhdf", cloud=cloud)
    return at_frame(read_fields(tmp_path / "fields.vtkhdf"), frame)


def test_contact_is_coloured_and_the_rest_is_not(tmp_path: Path) -> None:
    peak = peak_at(tmp_path, 2)
    camera = through_view(peak, (150, 160))
    layer = mesh_layer(camera, peak.slave_points, peak.slave_triangles)
    colours = slave_colours(layer, peak)
    plain = (colours == SLAVE).all(axis=1)
    touching = layer.at_pixels(peak.in_contact.astype(float)) > 0.5
    np.testing.assert_array_equal(plain, ~touching)
    assert touching.any()
    deepest = layer.at_pixels(peak.penetration).argmax()
    assert colours[deepest].sum() == colours[touching].sum(axis=1).min(), "deepest is darkest"


def test_both_views_hold_the_contact(tmp_path: Path) -> None:
    peak = peak_at(tmp_path, 2)
    for view in (outside_view, through_view):
        column, row, _ = project(view(peak, (150, 160)), peak.slave_points[peak.in_contact]).T
        assert column.min() >= 0.0
        assert column.max() < 160.0
        assert row.min() >= 0.0
        assert row.max() < 150.0


def test_through_view_looks_from_the_body_to_the_free_side(tmp_path: Path) -> None:
    peak = peak_at(tmp_path, 2)
    assert through_view(peak, (150, 160)).axes[2] @ peak.direction > 0.8


@pytest.mark.parametrize("through", [True, False])
@pytest.mark.parametrize("cloud", [True, False])
@pytest.mark.parametrize("frame", [0, 2])
def test_every_scene_can_be_drawn(tmp_path: Path, through: bool, cloud: bool, frame: int) -> None:
    peak = peak_at(tmp_path, frame, cloud=cloud)
    camera = (through_view if through else outside_view)(peak, (90, 100))
    picture = render(camera, peak, through=through)
    assert picture.shape == (90, 100, 3)
    assert np.isfinite(picture).all()
    assert 0.02 < (picture < 0.99).any(axis=2).mean() < 1.0


def test_plane_problems_are_seen_along_z(tmp_path: Path) -> None:
    peak = peak_at(tmp_path, 2)
    flat = [0.0, 1.0, 0.0]
    plane = peak._replace(
        body_points=peak.body_points * [1, 1, 0], slave_points=peak.slave_points * [1, 1, 0]
    )
    assert upwards(plane).tolist() == flat
    assert upwards(peak).tolist() == [0.0, 0.0, 1.0]
    assert np.isfinite(outside_direction(plane._replace(direction=np.array(flat)))).all()


def test_picture_is_a_png_of_its_size(tmp_path: Path) -> None:
    path = tmp_path / "peak.png"
    draw_still(peak_at(tmp_path, 2), path, length="mm", time="ms")
    head = path.read_bytes()[:24]
    assert head[:8] == b"\x89PNG\r\n\x1a\n"
    assert (int.from_bytes(head[16:20]), int.from_bytes(head[20:24])) == (1640, 840)
