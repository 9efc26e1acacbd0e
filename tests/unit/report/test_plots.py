"""The interactive figures hold the numbers of the run."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from contiga.io.out.vtkhdf import read_fields
from contiga.report.peak import Peak, at_frame
from contiga.report.plots import history_figures, view_figure, with_unit
from contiga.report.run_folder import Units, read_run
from contiga.report.shown import REGIONS

from .conftest import outlined, write_fields

UNITS = Units("mm", "g", "ms", "mm²", "N", "N·mm", "MPa")


def test_history_figures_draw_the_columns(run_folder: Path) -> None:
    run = read_run(run_folder)
    columns = run.contacts["press"]
    force, *others = history_figures(run, 2.0)
    assert [t.name for t in force.data] == ["along z", "magnitude"], "no line for a zero force"
    np.testing.assert_array_equal(force.data[0].y, columns["force_z"])
    np.testing.assert_array_equal(force.data[1].y, columns["force"])
    for figure, name in zip(others, ("max_penetration", "area", "n_contact"), strict=True):
        (trace,) = figure.data
        np.testing.assert_array_equal(trace.y, columns[name])
        np.testing.assert_array_equal(trace.x, run.times)
        assert figure.layout.shapes[0].x0 == 2.0


def test_every_axis_names_its_unit(run_folder: Path) -> None:
    figures = history_figures(read_run(run_folder), None)
    assert [f.layout.yaxis.title.text for f in figures] == [
        "Force [N]",
        "Deepest penetration [mm]",
        "Contact area [mm²]",
        "Nodes in contact",
    ]
    assert {f.layout.xaxis.title.text for f in figures} == {"Time [ms]"}
    assert with_unit("Force", "") == "Force"


def test_two_contacts_get_a_line_each_in_every_panel(run_folder: Path) -> None:
    run = read_run(run_folder)
    columns = run.contacts["press"]
    for figure in history_figures(run._replace(contacts={"a": columns, "b": columns}), None):
        assert [t.name for t in figure.data] == ["a", "b"]
        assert figure.layout.showlegend


def test_view_holds_body_slave_and_contact(tmp_path: Path) -> None:
    write_fields(tmp_path / "fields.vtkhdf")
    peak = at_frame(read_fields(tmp_path / "fields.vtkhdf"), 2)
    body, slave, contact = view_figure(peak, UNITS).data
    assert (body.type, slave.type, contact.type) == ("mesh3d", "mesh3d", "scatter3d")
    assert len(contact.x) == peak.in_contact.sum()
    np.testing.assert_allclose(contact.marker.color, peak.penetration[peak.in_contact], rtol=1e-6)
    assert slave.cmax == peak.penetration.max()


def test_cloud_is_drawn_as_dots(tmp_path: Path) -> None:
    write_fields(tmp_path / "fields.vtkhdf", cloud=True)
    peak = at_frame(read_fields(tmp_path / "fields.vtkhdf"), 2)
    _, slave, contact = view_figure(peak, Units(*[""] * 7)).data
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
    figure = view_figure(peak, UNITS)
    slave, contact = figure.data[1:3]
    np.testing.assert_allclose(slave.intensity, peak.pressure, rtol=1e-6)
    assert contact.marker.colorbar.title.text == "Pressure [MPa]"
    meta = figure.layout.meta
    assert meta["first"] == "pressure"
    assert list(meta["looks"]) == ["penetration", "pressure", "cluster"]
    mesh, marker = meta["looks"]["penetration"]
    np.testing.assert_allclose(mesh["intensity"][0], peak.penetration, rtol=1e-4)
    np.testing.assert_allclose(
        marker["marker.color"][0], peak.penetration[peak.in_contact], rtol=1e-4
    )
    mesh, marker = meta["looks"]["cluster"]
    assert mesh["intensitymode"] == ["cell"]
    assert len(mesh["intensity"][0]) == len(peak.slave_triangles)
    assert set(mesh["intensity"][0]) == {-1.0, 0.0, 1.0}
    assert set(marker["marker.color"][0]) == {0.0, 1.0}


def test_regions_have_closed_lines_of_their_own_colour(tmp_path: Path) -> None:
    peak = with_regions(tmp_path)
    lines = view_figure(peak, UNITS).data[3:]
    assert [line.name for line in lines] == ["cluster 0", "cluster 1"]
    assert [line.line.color for line in lines] == list(REGIONS[:2])
    for line, given in zip(lines, peak.outlines, strict=True):
        assert line.mode == "lines"
        assert line.x[0] == line.x[-2]
        assert np.isnan(line.x[-1])
        np.testing.assert_allclose(line.x[:-2], given.points[:, 0], rtol=1e-6)


def test_energies_are_stacked_under_the_work(run_folder: Path) -> None:
    run = read_run(run_folder)
    n = len(run.times)
    given = {
        "work": np.linspace(0.0, 5.0, n),
        "energy_stored": np.linspace(0.0, 3.0, n),
        "energy_hysteresis": np.zeros(n),
        "energy_friction": np.linspace(0.0, 1.5, n),
    }
    columns = run.contacts["press"] | given
    *_, energy = history_figures(run._replace(contacts={"a": columns, "b": columns}), 2.0)
    assert [t.name for t in energy.data] == ["stored", "friction", "work"], "no layer of nothing"
    assert [t.stackgroup for t in energy.data] == ["energy", "energy", None]
    np.testing.assert_array_equal(energy.data[1].y, 2.0 * given["energy_friction"])
    np.testing.assert_array_equal(energy.data[2].y, 2.0 * given["work"])
    assert energy.layout.yaxis.title.text == "Energy of contact [N·mm]"
