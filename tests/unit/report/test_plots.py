"""The interactive figures hold the numbers of the run."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from contiga.io.vtkhdf import read_fields
from contiga.report.folder import read_run
from contiga.report.peak import at_frame
from contiga.report.plots import history_figure, view_figure, with_unit

from .conftest import write_fields


def test_history_figure_draws_the_columns(run_folder: Path) -> None:
    run = read_run(run_folder)
    figure = history_figure(run, 2.0)
    for name, column in (("magnitude", "force"), ("along z", "force_z")):
        (trace,) = (t for t in figure.data if t.name == name and t.xaxis == "x")
        np.testing.assert_array_equal(trace.y, run.contacts["press"][column])
    assert not [t for t in figure.data if t.name == "along x"], "no line for a force of zero"


def test_every_axis_names_its_unit(run_folder: Path) -> None:
    layout = history_figure(read_run(run_folder), None).layout
    assert layout.yaxis.title.text == "Force [N]"
    assert layout.yaxis2.title.text == "Deepest penetration [mm]"
    assert layout.yaxis3.title.text == "Contact area [mm²]"
    assert layout.yaxis4.title.text == "Nodes in contact"
    assert layout.xaxis3.title.text == "Time [ms]"
    assert with_unit("Force", "") == "Force"


def test_two_contacts_get_a_line_each_in_every_panel(run_folder: Path) -> None:
    run = read_run(run_folder)
    columns = run.contacts["press"]
    figure = history_figure(run._replace(contacts={"a": columns, "b": columns}), None)
    assert [t.name for t in figure.data] == ["a", "b"] * 4
    assert [t.showlegend for t in figure.data] == [True, True] + [False] * 6


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
