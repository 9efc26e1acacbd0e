"""Springs in the report: a table, figures, and lines between the places their ends have come to."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from matplotlib import image
from tests.figures import checked

from contiga.io.out.history import read_history, write_history
from contiga.report import write_report
from contiga.report.frames import frames_of
from contiga.report.peak import at_frame
from contiga.report.places import ties_of
from contiga.report.run_folder import read_fields, read_run
from contiga.report.space import view_of
from contiga.report.springs import spring_figures, spring_table

from .conftest import DEPTHS

SPRINGS = {
    "belt": {"between": ["ball", "ground"], "at": [[14, 0, 11], [14, 0, 20]], "filter": "CFC60"},
    "slack": {"between": ["ball", "ground"], "at": [[-10, 0, 11], [-14, 0, 11]], "filter": None},
}


@pytest.fixture
def hung(run_folder: Path) -> Path:
    return hang(run_folder)


def hang(run_folder: Path) -> Path:
    """The ball on two springs, one of them slack."""
    history = dict(read_history(run_folder / "history.csv"))
    zero, pull = np.zeros(5), np.array([0.0, 2.0, -4.0, 3.0, 0.0])
    for name, force in (("belt", pull), ("slack", zero)):
        history |= {f"{name}.force": force, f"{name}.elongation": force / 2.0}
        history |= {f"{name}.rate": zero, f"{name}.energy_stored": force**2 / 4.0}
        history |= {f"{name}.energy_hysteresis": zero, f"{name}.energy_damping": np.abs(force)}
    history["belt.filtered_force"] = 0.9 * pull
    write_history(run_folder / "history.csv", history)
    path = run_folder / "summary.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | {"springs": SPRINGS}))
    return run_folder


def test_ends_go_with_the_bodies_they_are_on(hung: Path) -> None:
    run = read_run(hung)
    series = read_fields(run)
    assert series is not None
    for step, depth in enumerate(DEPTHS):
        first, second = at_frame(series, step, None, ties_of(run.summary)).ties
        np.testing.assert_allclose(first, [[14, 0, 10 - depth], [14, 0, 20]], atol=1e-5)
        np.testing.assert_allclose(second, [[-10, 0, 10 - depth], [-14, 0, 11]], atol=1e-5)


def test_lines_of_joints_go_with_their_second_bodies(hung: Path) -> None:
    path = hung / "summary.json"
    told = json.loads(path.read_text())
    line = [[0.0, -5.0, 10.0], [0.0, 5.0, 10.0]]
    pin = {"kind": "revolute", "between": ["ground", "ball"], "lines": [line]}
    path.write_text(json.dumps(told | {"joints": {"pin": pin}}))
    run = read_run(hung)
    series = read_fields(run)
    assert series is not None
    for step, depth in enumerate(DEPTHS):
        peak = at_frame(series, step, None, ties_of(run.summary))
        assert peak.tie_kinds == ("spring", "spring", "joint")
        np.testing.assert_allclose(
            peak.ties[2], line - np.array([0, 0, depth - DEPTHS[0]]), atol=1e-5
        )


def test_table_and_figures_say_what_there_is(hung: Path) -> None:
    run = read_run(hung)
    table = spring_table(run)
    for cell in ("belt · CFC60", "ball – ground", "-3.6 N", "2 ms", "1.5 mm", "2 mm", "4 mJ"):
        assert cell.replace("mJ", "μJ") in table or cell in table, cell
    force, elongation = map(checked, spring_figures(run, None))
    assert [line.name for line in force.data] == [line.name for line in elongation.data] == ["belt"]
    np.testing.assert_allclose(force.data[0].y, 0.9 * run.springs["belt"]["force"])


def test_the_scene_has_a_line_for_each_spring_at_every_step(hung: Path) -> None:
    run = read_run(hung)
    series, ties = read_fields(run), ties_of(run.summary)
    assert series is not None
    peak = at_frame(series, 2, None, ties)
    frames = frames_of(series, None, 2, peak, run.units, ties)
    view = view_of(peak, frames, run.units, ties)
    line = checked(view.figure).data[-1]
    assert (line.name, list(line.text)[::3]) == ("springs and joints", ["belt", "slack"])
    np.testing.assert_allclose(np.array(line.z)[:2], [10.0 - DEPTHS[2], 20.0], atol=1e-5)
    assert view.data["ties"]
    assert all(len(frame.ties) == 2 for frame in frames.frames)


def test_the_picture_and_the_page_show_them(hung: Path) -> None:
    page = write_report(hung).read_text(encoding="utf-8")
    assert "<h2>Springs</h2>" in page
    picture = image.imread(hung / "peak.png")[..., :3]
    ochre = np.abs(picture - np.array([0xB0, 0x7D, 0x1E]) / 255.0).max(axis=-1) < 0.02
    assert ochre.sum() > 200
