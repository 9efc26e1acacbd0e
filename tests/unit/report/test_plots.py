"""The interactive figures hold the numbers of the run."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from contiga.io.vtkhdf import read_fields
from contiga.report.folder import read_run
from contiga.report.peak import at_frame
from contiga.report.plots import history_figures, view_figure, with_unit

from .conftest import write_fields


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
    body, slave, contact = view_figure(peak, "mm").data
    assert (body.type, slave.type, contact.type) == ("mesh3d", "mesh3d", "scatter3d")
    assert len(contact.x) == peak.in_contact.sum()
    np.testing.assert_allclose(contact.marker.color, peak.penetration[peak.in_contact], rtol=1e-6)
    assert slave.cmax == peak.penetration.max()


def test_cloud_is_drawn_as_dots(tmp_path: Path) -> None:
    write_fields(tmp_path / "fields.vtkhdf", cloud=True)
    peak = at_frame(read_fields(tmp_path / "fields.vtkhdf"), 2)
    _, slave, contact = view_figure(peak, "").data
    assert slave.type == "scatter3d"
    assert len(slave.x) + len(contact.x) == len(peak.slave_points)
