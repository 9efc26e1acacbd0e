"""Which moment is drawn, and where its points are."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from contiga.io.out.vtkhdf import FieldsWriter, read_fields
from contiga.io.out.vtkhdf_layout import Part
from contiga.report.peak import at_frame, peak_frame, stacked

from .conftest import DEPTHS, ball, penetration_of, sheet, write_fields

TIMES = np.arange(5.0)


@pytest.fixture
def series(tmp_path: Path):
    write_fields(tmp_path / "fields.vtkhdf")
    return read_fields(tmp_path / "fields.vtkhdf")


def test_peak_is_the_recorded_time_of_the_greatest_force(series) -> None:
    assert peak_frame(series, TIMES, np.array([0.0, 5.0, 1.0, 2.0, 0.0])) == 1


def test_peak_looks_at_recorded_times_only(series) -> None:
    times = np.linspace(0.0, 4.0, 41)
    force = np.where(np.isclose(times, 2.4), 9.0, 0.0) + np.where(times == 3.0, 4.0, 0.0)
    assert peak_frame(series, times, force) == 3


def test_without_force_the_peak_is_the_deepest(series) -> None:
    assert peak_frame(series, TIMES, np.zeros(5)) == int(np.argmax(DEPTHS))


def test_contact_and_depth_are_those_of_the_frame(series) -> None:
    slave, _ = sheet()
    peak = at_frame(series, 2)
    depth, _ = penetration_of(slave, DEPTHS[2])
    np.testing.assert_array_equal(peak.slave_points, slave)
    np.testing.assert_array_equal(peak.in_contact, depth > 0.0)
    np.testing.assert_array_equal(peak.penetration, depth)
    assert peak.in_contact.sum() > 20


def test_mean_normal_of_a_ball_from_above_points_down(series) -> None:
    np.testing.assert_allclose(at_frame(series, 2).direction, [0.0, 0.0, -1.0], atol=1e-12)
    np.testing.assert_array_equal(at_frame(series, 0).direction, 0.0)


def test_parts_of_a_kind_are_stacked_with_their_own_triangles(series) -> None:
    body, faces = ball()
    slave, facets = sheet()
    points, triangles, rows = stacked(series, 1, "slave")
    np.testing.assert_array_equal(points, slave)
    np.testing.assert_array_equal(triangles, facets)
    np.testing.assert_array_equal(rows, len(body) + np.arange(len(slave)))
    np.testing.assert_array_equal(stacked(series, 1, "body")[1], faces)


def test_triangles_of_a_second_part_are_numbered_after_the_first(tmp_path: Path) -> None:
    body, faces = ball(4)
    parts = [Part(name, "body", len(body), faces) for name in ("one", "two")]
    with FieldsWriter(tmp_path / "two.vtkhdf", parts) as writer:
        writer.append(0.0, np.vstack([body, body + 50.0]), {})
    points, triangles, _ = stacked(read_fields(tmp_path / "two.vtkhdf"), 0, "body")
    np.testing.assert_array_equal(points[triangles], np.vstack([body[faces], body[faces] + 50.0]))
