"""Pictures are framed by what touches: far parts, vast sheets and idle nodes stay out."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from tests.figures import checked

import contiga as cg
from contiga.io.out.vtkhdf import FieldSeries, read_fields
from contiga.rendering.camera import project
from contiga.report import write_report
from contiga.report.focus import focus_of
from contiga.report.frames import frames_of
from contiga.report.peak import Peak, at_frame
from contiga.report.run_folder import Units, read_run
from contiga.report.scene import outside_view, through_view
from contiga.report.space import view_of

from .conftest import write_fields

UNITS = Units("mm", "g", "ms", "mm²", "N", "N·mm", "MPa")
BALL = cg.Body(cg.shapes.sphere(radius=20.0, centre=[0, 0, 21]), name="ball")
WALL = cg.Body(cg.shapes.plane(width=60, length=80, centre=[1200, 0, 0], axis="x"), name="wall")


def folder_of(
    path: Path, depth: float = 4.0, *, width: float = 60.0, far_node: bool = True
) -> Path:
    """A run of a ball into a sheet, a wall 1.2 m away, and a node that nothing but it may touch."""
    points = cg.clouds.sample(cg.shapes.plane(width=width, length=width), 41, 41)
    rows = (np.arange(40)[:, None] * 41 + np.arange(40)).ravel()
    facets = np.stack([rows, rows + 41, rows + 42, rows + 1], axis=-1)
    sheet = cg.Slave([*points, [0.0, 0.0, -900.0]], facets, name="sheet")
    node = cg.Slave([[1210.0, 0.0, 0.0]], area=[1.0], name="node")
    contacts = [cg.Contact(BALL, sheet, law=cg.PenaltyLaw(1.0))]
    if far_node:
        contacts.append(cg.Contact(WALL, node, law=cg.PenaltyLaw(1.0)))
    cg.Simulation(
        bodies={
            "ball": (BALL, cg.motion.Translate([[0, 0, 0, 0], [1, 0, 0, -1.0 - depth]])),
            "wall": WALL,
        },
        slaves={"sheet": sheet, "node": node},
        contacts=contacts,
        end=1.0,
        step=0.25,
        units=("mm", "g", "ms"),
    ).run(path)
    return path


def peak_of(path: Path) -> tuple[FieldSeries, Peak]:
    series = read_fields(path / "fields.vtkhdf")
    return series, at_frame(series, len(series.times) - 1)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return folder_of(tmp_path_factory.mktemp("far") / "out")


def test_the_scene_holds_all_bodies_and_what_touches_is_a_choice(folder: Path) -> None:
    series, peak = peak_of(folder)
    view = view_of(peak, frames_of(series, None, 4, peak, UNITS), UNITS)
    spans = [list(checked(view.figure).layout.scene[f"{axis}axis"].range) for axis in "xyz"]
    assert spans == view.data["spans"]["all"]
    for (low, high), least, most in zip(spans, (-30, -40, -30), (1200, 40, 40), strict=True):
        assert low <= least
        assert high >= most
    near = view.data["spans"]["near"]
    assert max(abs(end) for span in near for end in span) < 50.0
    assert near[2][0] > -10.0
    text = write_report(folder).read_text(encoding="utf-8")
    assert 'data-frame="near"' in text


def test_nothing_is_to_choose_where_all_touches(tmp_path: Path) -> None:
    write_fields(tmp_path / "fields.vtkhdf")
    series = read_fields(tmp_path / "fields.vtkhdf")
    peak = at_frame(series, 2)
    view = view_of(peak, frames_of(series, None, 2, peak, UNITS), UNITS)
    assert "spans" not in view.data


def test_the_still_pictures_are_filled_by_what_touches(folder: Path) -> None:
    _, peak = peak_of(folder)
    camera = outside_view(peak, (700, 700))
    at = project(camera, peak.framed)[:, :2]
    assert np.ptp(at, axis=0).max() > 0.75 * 700
    patch = peak.slave_points[peak.in_contact]
    near = project(through_view(peak, (700, 700)), patch)[:, :2]
    assert np.ptp(near, axis=0).max() > 0.3 * 700


def test_nodes_that_take_no_part_are_marked_and_left_out(folder: Path) -> None:
    series, peak = peak_of(folder)
    assert np.asarray(series.data(0, "contact_status"))[series.rows("sheet")][-1] == -1
    assert peak.active is not None
    assert np.flatnonzero(~peak.active).tolist() == [41 * 41]
    assert peak.seen[:, 2].min() > -10.0


def test_a_contact_that_never_touches_is_said_so(folder: Path) -> None:
    text = write_report(folder).read_text(encoding="utf-8")
    assert "No point came into contact in wall-node." in text
    run = read_run(folder)
    assert sorted(run.contacts) == ["ball-sheet", "wall-node"]
    head = text[text.index("<h2>Over time</h2>") :]
    assert '"name":"ball-sheet"' in head
    assert '"name":"wall-node"' not in head


def test_a_run_without_contact_says_so_and_draws_no_empty_figure(tmp_path: Path) -> None:
    text = write_report(folder_of(tmp_path / "out", depth=-0.5)).read_text(encoding="utf-8")
    assert "No point came into contact: force, penetration and area are zero throughout." in text
    assert "<h2>The scene, at t = 0 ms</h2>" in text
    assert 'id="history-0"' not in text
    assert "The dotted line" not in text


def test_of_a_vast_sheet_a_piece_is_framed(tmp_path: Path) -> None:
    _, peak = peak_of(folder_of(tmp_path / "out", width=2000.0, depth=6.0, far_node=False))
    assert peak.framed is not None
    assert np.abs(peak.framed).max() < 100.0


def test_focus_is_on_what_the_patch_lies_in() -> None:
    rng = np.random.default_rng(1)
    near, far = rng.uniform(-1.0, 1.0, (50, 3)), rng.uniform(9.0, 10.0, (50, 3))
    focus = focus_of([near, far, np.zeros((0, 3))], np.array([[0.9, 0.0, 0.0]]), 0.1)
    assert focus is not None
    assert focus.parts == (0,)
    assert len(focus.corners) == 0
    assert focus_of([near], np.zeros((0, 3)), 0.0) is None
