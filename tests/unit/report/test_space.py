"""The 3D view: what is in it, and what its script is handed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from tests.figures import checked

from contiga.io.out.vtkhdf import read_fields
from contiga.report.coloured import REGIONS
from contiga.report.frames import Frame, frames_of
from contiga.report.peak import Peak, at_frame
from contiga.report.run_folder import Units
from contiga.report.space import View, view_of

from .conftest import DEPTHS, RADIUS, outlined, write_fields

UNITS = Units("mm", "g", "ms", "mm²", "N", "N·mm", "MPa")


def viewed(folder: Path, peak: Peak) -> View:
    """The view of the fields in `folder`, in which each step has the regions of the peak."""
    frames = frames_of(read_fields(folder / "fields.vtkhdf"), None, 2, peak, UNITS)
    own = tuple(_like(frame, peak) for frame in frames.frames)
    tops = {name: float(v.max(initial=0.0)) for name, v in own[2].values.items()}
    return view_of(peak, frames._replace(frames=own, tops=tops), UNITS)


def _like(frame: Frame, peak: Peak) -> Frame:
    values = dict(frame.values)
    if peak.pressure is not None:
        values["pressure"] = 3.0 * values["penetration"]
    if peak.cluster is not None:
        values["cluster"] = (peak.slave_points[frame.rows, 0] > 0.0).astype(np.float32)
    return frame._replace(values=values, outlines=peak.outlines)


def test_view_holds_body_slave_and_contact(tmp_path: Path) -> None:
    write_fields(tmp_path / "fields.vtkhdf")
    peak = at_frame(read_fields(tmp_path / "fields.vtkhdf"), 2)
    body, slave, contact = checked(viewed(tmp_path, peak).figure).data
    assert (body.type, slave.type, contact.type) == ("mesh3d", "mesh3d", "scatter3d")
    assert len(contact.x) == peak.in_contact.sum()
    np.testing.assert_allclose(contact.marker.color, peak.penetration[peak.in_contact], rtol=1e-6)
    assert slave.cmax == peak.penetration.max()


def test_cloud_is_drawn_as_dots(tmp_path: Path) -> None:
    write_fields(tmp_path / "fields.vtkhdf", cloud=True)
    peak = at_frame(read_fields(tmp_path / "fields.vtkhdf"), 2)
    _, slave, contact = checked(viewed(tmp_path, peak).figure).data
    assert slave.type == "scatter3d"
    assert len(slave.x) + len(contact.x) == len(peak.slave_points)


def with_regions(tmp_path: Path) -> Peak:
    """The peak with a pressure, two clusters by the sign of x, and a line around each."""
    write_fields(tmp_path / "fields.vtkhdf")
    peak = at_frame(read_fields(tmp_path / "fields.vtkhdf"), 2)
    cluster = np.where(peak.in_contact, (peak.slave_points[:, 0] > 0.0).astype(int), -1)
    return peak._replace(pressure=3.0 * peak.penetration, cluster=cluster, outlines=outlined())


def test_view_starts_with_pressure_and_offers_the_other_fields(tmp_path: Path) -> None:
    peak = with_regions(tmp_path)
    view = viewed(tmp_path, peak)
    slave, contact = checked(view.figure).data[1:3]
    np.testing.assert_allclose(slave.intensity, peak.pressure, rtol=1e-6)
    assert contact.marker.colorbar.title.text == view.note == "Pressure [MPa]"
    assert view.data["field"] == "pressure"
    looks = view.data["looks"]
    assert list(looks) == ["penetration", "pressure", "cluster"]
    assert looks["penetration"]["mesh"]["cmax"] == looks["penetration"]["marker"]["marker.cmax"]
    assert looks["pressure"]["mesh"]["intensitymode"] == "vertex"
    assert looks["cluster"]["mesh"]["intensitymode"] == "cell"
    # What is set beside the values; these are those of the step that is shown.
    assert not any("intensity" in look["mesh"] for look in looks.values())
    assert not any("marker.color" in look["marker"] for look in looks.values())


def test_what_is_inside_is_offered_of_facets_alone(tmp_path: Path) -> None:
    for cloud, offered in ((False, ["Penetration", "Von Mises stress"]), (True, ["Penetration"])):
        write_fields(tmp_path / "fields.vtkhdf", cloud=cloud, deforms=True)
        peak = at_frame(read_fields(tmp_path / "fields.vtkhdf"), 2)
        frames = frames_of(read_fields(tmp_path / "fields.vtkhdf"), None, 2, peak, UNITS)
        assert list(view_of(peak, frames, UNITS).data["names"].values()) == offered


def test_without_a_contact_the_stress_is_shown_first(tmp_path: Path) -> None:
    write_fields(tmp_path / "fields.vtkhdf", deforms=True)
    series = read_fields(tmp_path / "fields.vtkhdf")
    peak = at_frame(series, 0)
    view = view_of(peak, frames_of(series, None, 0, peak, UNITS), UNITS)
    assert (view.data["field"], view.note) == ("von_mises", "Von Mises stress [MPa]")


def test_regions_have_closed_lines_of_their_own_colour(tmp_path: Path) -> None:
    peak = with_regions(tmp_path)
    lines = checked(viewed(tmp_path, peak).figure).data[3:]
    assert [line.name for line in lines] == ["cluster 0", "cluster 1"]
    assert [line.line.color for line in lines] == list(REGIONS[:2])
    for line, given in zip(lines, peak.outlines, strict=True):
        assert line.mode == "lines"
        assert line.x[0] == line.x[-2]
        assert np.isnan(line.x[-1])
        np.testing.assert_allclose(line.x[:-2], given.points[:, 0], rtol=1e-6)


def test_all_steps_fit_into_the_axes(tmp_path: Path) -> None:
    write_fields(tmp_path / "fields.vtkhdf")
    peak = at_frame(read_fields(tmp_path / "fields.vtkhdf"), 2)
    scene = checked(viewed(tmp_path, peak).figure).layout.scene
    low, high = scene.zaxis.range
    assert low < -max(DEPTHS)
    assert high > 2.0 * RADIUS - min(DEPTHS)
    assert scene.xaxis.range == pytest.approx((-12.48, 12.48))
    assert scene.aspectmode == "data"


def test_steps_and_the_peak_among_them_are_told(tmp_path: Path) -> None:
    write_fields(tmp_path / "fields.vtkhdf")
    peak = at_frame(read_fields(tmp_path / "fields.vtkhdf"), 2)
    view = viewed(tmp_path, peak)
    assert (view.steps, view.recorded, view.data["first"]) == (5, 5, 2)
    assert view.data["times"] == [0.0, 1.0, 2.0, 3.0, 4.0]
    assert view.data["labels"][2] == "t = 2 ms"
