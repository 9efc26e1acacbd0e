"""The views of the peak show the contact where it is."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from contiga.io.out.vtkhdf import read_fields
from contiga.rendering.camera import look, project
from contiga.rendering.shading import mesh_layer, thickened
from contiga.report.coloured import REGIONS, fields_of, first_field, region_colours
from contiga.report.peak import Peak, at_frame
from contiga.report.run_folder import Units
from contiga.report.scene import (
    SLAVE,
    _slave_layer,
    outside_direction,
    outside_view,
    render,
    slave_colours,
    through_view,
    upwards,
)

from .conftest import outlined, write_fields

UP = np.array([0.0, 0.0, 1.0])
UNITS = Units("mm", "g", "ms", "mm²", "N", "N·mm", "MPa")


def peak_at(tmp_path: Path, frame: int, *, cloud: bool = False) -> Peak:
    write_fields(tmp_path / "fields.vtkhdf", cloud=cloud)
    return at_frame(read_fields(tmp_path / "fields.vtkhdf"), frame)


def test_contact_is_coloured_and_the_rest_is_not(tmp_path: Path) -> None:
    peak = peak_at(tmp_path, 2)
    camera = through_view(peak, (150, 160))
    layer = mesh_layer(camera, peak.slave_points, peak.slave_triangles)
    colours = slave_colours(layer, peak, first_field(peak, UNITS))
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
    picture = render(camera, peak, first_field(peak, UNITS), through=through)
    assert picture.shape == (90, 100, 3)
    assert np.isfinite(picture).all()
    assert 0.02 < (picture < 0.99).any(axis=2).mean() < 1.0


@pytest.mark.parametrize("cloud", [True, False])
def test_nearer_parts_hide_the_others(tmp_path: Path, cloud: bool) -> None:
    peak = peak_at(tmp_path, 2, cloud=cloud)
    shown = first_field(peak, UNITS)
    for camera in (
        outside_view(peak, (90, 100)),
        look(np.array([0.3, 0.0, 1.0]), UP, peak.seen, (90, 100)),
    ):
        body = mesh_layer(camera, peak.body_points, peak.body_triangles)
        slave = _slave_layer(camera, peak)
        picture = render(camera, peak, shown, through=False)
        warm = picture[..., 0] > picture[..., 2]  # a slave is, bodies and lines are not
        hidden = slave.seen & (body.buffer.depth < slave.buffer.depth)
        assert hidden.any()
        assert not warm[hidden].any()
        free = slave.seen & ~hidden
        assert warm[free].mean() > 0.5


def test_plane_problems_are_seen_along_z(tmp_path: Path) -> None:
    peak = peak_at(tmp_path, 2)
    flat = [0.0, 1.0, 0.0]
    plane = peak._replace(
        body_points=peak.body_points * [1, 1, 0], slave_points=peak.slave_points * [1, 1, 0]
    )
    assert upwards(plane).tolist() == flat
    assert upwards(peak).tolist() == [0.0, 0.0, 1.0]
    assert np.isfinite(outside_direction(plane._replace(direction=np.array(flat)))).all()


def test_pressure_is_shown_where_there_is_some(tmp_path: Path) -> None:
    peak = peak_at(tmp_path, 2)
    assert first_field(peak, UNITS).label == "Penetration"
    pressed = peak._replace(pressure=2.0 * peak.penetration)
    shown = first_field(pressed, UNITS)
    assert (shown.label, shown.unit) == ("Pressure", "MPa")
    assert shown.top == 2.0 * peak.penetration.max()
    assert not shown.cut
    assert list(fields_of(pressed, UNITS)) == ["penetration", "pressure"]


def test_one_wild_node_does_not_take_the_colours_from_the_others(tmp_path: Path) -> None:
    peak = peak_at(tmp_path, 2)
    pressure = np.where(peak.in_contact, 1.0, 0.0)
    pressure[np.flatnonzero(peak.in_contact)[0]] = 1e6
    shown = first_field(peak._replace(pressure=pressure), UNITS)
    assert shown.cut
    assert shown.top == 1.0


def test_outlines_are_drawn_in_the_colour_of_their_region(tmp_path: Path) -> None:
    bare = peak_at(tmp_path, 2)
    peak = bare._replace(outlines=outlined())
    assert list(region_colours(peak.outlines).values()) == list(REGIONS[:2])
    camera = through_view(peak, (150, 160))
    picture = render(camera, peak, first_field(peak, UNITS), through=True)
    for line, colour in zip(peak.outlines, REGIONS, strict=False):
        wanted = np.array([int(colour[k : k + 2], 16) for k in (1, 3, 5)]) / 255.0
        column, row, _ = np.rint(project(camera, line.points)).astype(int).T
        actual = picture[row, column]
        assert np.abs(actual - wanted).max() < 1e-6


def test_thick_lines_stay_in_the_picture() -> None:
    ink = np.zeros((5, 7), dtype=bool)
    ink[0, 0] = ink[4, 6] = True
    thick = thickened(ink, 1)
    assert thick.sum() == 6
    assert thick[0, 1]
    assert thick[3, 6]
    assert not thick[1, 1]


def test_a_single_point_in_contact_is_seen_from_outside_it(tmp_path: Path) -> None:
    peak = peak_at(tmp_path, 2)
    alone = np.zeros(len(peak.in_contact), dtype=bool)
    alone[np.flatnonzero(peak.in_contact)[0]] = True
    camera = through_view(peak._replace(in_contact=alone), (150, 160))
    column, row, depth = project(camera, peak.slave_points[alone])[0]
    assert depth > 0.1 * np.ptp(peak.seen, axis=0).max()
    assert column == pytest.approx(80.0, abs=1.0)
    assert row == pytest.approx(75.0, abs=1.0)
