"""Curves of tests beside a run: shift, corridor, units, rating; in reports and comparisons."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import contiga as cg
from contiga.errors import MissingPackageError
from contiga.report import references as module
from contiga.report.comparison_page import page_of
from contiga.report.curves import Curve, curve_figure, curves_of
from contiga.report.references import onset, rated, ratings_table, references_of
from contiga.report.run_folder import Run, read_run
from contiga.report.runs import Named

from .test_comparison import FINE, write_run

PEAK = 4.0
TABLE = """
[[reference]]
channel = "force"
name = "T17"
points = [[1, 0], [2, 3], [3, 5], [4, 0]]
"""


def run_with(folder: Path, more: str = TABLE, **options: object) -> Run:
    """The run of `write_run`, whose case names a test."""
    made = write_run(folder, FINE, **options)  # type: ignore[arg-type]
    case = made / "case.toml"
    case.write_text(case.read_text(encoding="utf-8") + more, encoding="utf-8")
    return read_run(made)


def test_a_signal_begins_where_it_reaches_a_twentieth_of_its_peak() -> None:
    assert onset(np.array([0.0, 1.0, 2.0, 3.0]), np.array([0.0, 0.0, 10.0, 20.0])) == 1.1
    assert onset(np.array([0.0, 1.0]), np.array([np.nan, 5.0])) == 1.0
    assert onset(np.array([2.0, 3.0]), np.array([-7.0, 1.0])) == 2.0


@pytest.mark.parametrize(("shift", "first"), [("0.0", 1.0), ("-0.5", 0.5), ('"onset"', None)])
def test_a_test_is_drawn_where_its_shift_puts_it(
    tmp_path: Path, shift: str, first: float | None
) -> None:
    run = run_with(tmp_path / "a", f"{TABLE}shift = {shift}\n")
    (reference,) = references_of(run)
    assert (reference.channel, reference.x, reference.name) == ("head-pad.force", "time", "T17")
    moved = reference.moved(run)
    if first is None:
        first = 1.0 + onset(run.times, run.total("force")) - onset(*reference.points.T)
    np.testing.assert_allclose(moved.points[:, 0], first + np.arange(4.0))


def test_a_corridor_is_a_share_of_the_peak_or_a_band_of_its_own(tmp_path: Path) -> None:
    (share,) = references_of(run_with(tmp_path / "a", TABLE + "corridor = 0.1\n"))
    np.testing.assert_allclose(
        share.band, [[1, -0.5, 0.5], [2, 2.5, 3.5], [3, 4.5, 5.5], [4, -0.5, 0.5]]
    )
    band = TABLE + "corridor = [[0, -1, 1], [5, 0, 2]]\nshift = 2.0\n"
    run = run_with(tmp_path / "b", band)
    (own,) = references_of(run)
    np.testing.assert_array_equal(own.moved(run).band, [[2, -1, 1], [7, 0, 2]])


def test_a_test_is_converted_with_its_run(tmp_path: Path) -> None:
    run_with(tmp_path / "a")
    (reference,) = references_of(read_run(tmp_path / "a", ("m", "kg", "s")))
    np.testing.assert_allclose(reference.points[:, 0], [0.001, 0.002, 0.003, 0.004])
    np.testing.assert_allclose(reference.points[:, 1], [0, 3, 5, 0])


def test_accelerations_of_tests_are_in_g_as_those_of_runs(tmp_path: Path) -> None:
    run = run_with(tmp_path / "a", TABLE.replace('"force"', '"cg.a"'), **{"cg.a": FINE})
    (reference,) = references_of(run)
    assert reference.points[2, 1] == pytest.approx(5.0 / 0.00980665)


def test_the_figure_has_run_test_and_corridor(tmp_path: Path) -> None:
    run = run_with(tmp_path / "a", TABLE + "corridor = 0.1\n")
    curve = Curve("time", ("head-pad.force",))
    assert curve in curves_of(run)
    references = [one.moved(run) for one in references_of(run)]
    figure = curve_figure([Named(run, "")], curve, references, 2.0)
    band, own, test = figure.data
    assert band["fill"] == "toself"
    assert own["name"] == "head-pad.force"
    assert max(own["y"]) == PEAK
    assert test["name"] == "test T17"
    np.testing.assert_array_equal(test["y"], [0, 3, 5, 0])
    assert figure.layout["yaxis"]["title"]["text"] == "head-pad.force [N]"
    assert figure.layout["shapes"], "the time of the scene"


def test_a_test_over_a_depth_is_drawn_there_and_not_rated(tmp_path: Path) -> None:
    over = TABLE + 'x = "max_penetration"\n'
    run = run_with(tmp_path / "a", over, max_penetration=FINE**2)
    (reference,) = references_of(run)
    curve = Curve("head-pad.max_penetration", ("head-pad.force",))
    assert curves_of(run) == [curve]
    figure = curve_figure([Named(run, "")], curve, [reference], 2.0)
    assert figure.layout["xaxis"]["title"]["text"] == "head-pad.max_penetration<br>[mm]"
    assert figure.layout["shapes"] == []
    found = rated(run, reference)
    assert found.rating is None
    assert "over time" in ratings_table([found], "ms")


def test_the_rating_is_that_of_the_signals(tmp_path: Path) -> None:
    pytest.importorskip("objective_rating_metrics")
    same = ", ".join(f"[{t}, {t * (4 - t)}]" for t in FINE.tolist())
    table = f'[[reference]]\nchannel = "force"\nname = "same"\npoints = [{same}]\n'
    run = run_with(tmp_path / "a", table)
    found = rated(run, references_of(run)[0])
    assert found.rating == (1, 1, 1, 1, 1)
    assert "excellent" in ratings_table([found], "ms")


def test_without_the_package_a_line_says_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def missing(*args: object) -> None:
        raise MissingPackageError('pip install "contiga[rating]"')

    monkeypatch.setattr(module, "iso18571", missing)
    run = run_with(tmp_path / "a")
    table = ratings_table([rated(run, one) for one in references_of(run)], "ms")
    assert table.count("contiga[rating]") == 1
    assert "<table>" not in table


def test_a_comparison_draws_the_tests_of_its_runs(tmp_path: Path) -> None:
    run_with(tmp_path / "a")
    write_run(tmp_path / "b", FINE, factor=2.0)
    for folders in (("a", "b"), ("b", "a")):
        page = page_of(cg.compare(*(tmp_path / name for name in folders)))
        assert page.count('"test T17"') == 1


def test_a_channel_that_is_not_there_yet_has_no_test(tmp_path: Path) -> None:
    """Filtered columns come at the end of a run."""
    run = run_with(tmp_path / "a", TABLE.replace('"force"', '"cg.filtered_a"'))
    assert references_of(run) == []


def test_a_run_of_no_case_has_no_tests(tmp_path: Path) -> None:
    run = run_with(tmp_path / "a", '[[reference]]\nfile = "x.csv"\nchannel = "force"\n')
    assert references_of(run) == []
    (tmp_path / "a" / "case.toml").write_text("no TOML", encoding="utf-8")
    assert references_of(read_run(tmp_path / "a")) == []
