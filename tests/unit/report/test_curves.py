"""Channels over each other: which are drawn unasked, and the lines of several runs."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from contiga.errors import InputError, OutputError
from contiga.report.curve_picture import draw_curves
from contiga.report.curves import Curve, channels_of, curve_figure, curves_of
from contiga.report.html import page
from contiga.report.run_folder import read_run
from contiga.report.runs import read_runs

from .test_comparison import FINE, write_run

FORCE = "head-pad.force"
DEPTH = Curve("head-pad.max_penetration", (FORCE,))


def foam(folder: Path, **options: object) -> Path:
    """A run of a contact with a layer of 20 mm, and of a body that moves."""
    more = {"max_penetration": 2.0 * FINE, "max_pressure": 3.0 * FINE, "force_x": FINE}
    more |= {f"cg.{axis}": rate * FINE + 1.0 for axis, rate in zip("xyz", (2, 1, 2), strict=True)}
    path = write_run(folder, FINE, **more, **options)  # type: ignore[arg-type]
    summary = json.loads((path / "summary.json").read_text(encoding="utf-8"))
    summary["layers"] = {"head-pad": 20.0}
    (path / "summary.json").write_text(json.dumps(summary), encoding="utf-8")
    return path


def test_force_over_depth_and_stress_over_strain_are_drawn_unasked(tmp_path: Path) -> None:
    run = read_run(foam(tmp_path / "a"))
    assert curves_of(run) == [DEPTH, Curve("head-pad.strain", ("head-pad.max_pressure",))]
    ((strain, stress),) = channels_of(run, curves_of(run)[1])
    np.testing.assert_allclose(strain.values, 2.0 * FINE / 20.0)
    assert (strain.unit, stress.unit) == ("", "MPa")
    assert 'id="curve-1"' in page(run, still=None, view=None, peak_time=None)


def test_without_a_layer_there_is_no_strain(tmp_path: Path) -> None:
    run = read_run(write_run(tmp_path / "a", FINE, max_penetration=FINE, max_pressure=FINE))
    assert curves_of(run) == [DEPTH]


def test_force_is_over_the_way_of_the_body_where_the_slave_deforms(tmp_path: Path) -> None:
    path = foam(tmp_path / "a")
    summary = json.loads((path / "summary.json").read_text(encoding="utf-8"))
    summary |= {"layers": {}, "depths": {"head-pad": "cg.travel"}}
    (path / "summary.json").write_text(json.dumps(summary), encoding="utf-8")
    assert curves_of(read_run(path)) == [Curve("cg.travel", (FORCE,))]


def test_a_case_asks_for_more(tmp_path: Path) -> None:
    path = foam(tmp_path / "a")
    more = '[[plot]]\nx = "cg.travel"\ny = ["force", "force_x"]\n[[plot]]\ny = "cg.x"\n'
    with (path / "case.toml").open("a", encoding="utf-8") as file:
        file.write(more)
    run = read_run(path)
    travel, over_time = curves_of(run)[2:]
    assert travel == Curve("cg.travel", (FORCE, "head-pad.force_x"))
    assert over_time == Curve("time", ("cg.x",))
    np.testing.assert_allclose(channels_of(run, travel)[0].x.values, 3.0 * FINE)


def test_runs_have_a_line_each_in_the_units_of_the_first(tmp_path: Path) -> None:
    foam(tmp_path / "a")
    write_run(tmp_path / "b", FINE / 1e3, units=("m", "kg", "s"), max_penetration=FINE / 1e3)
    runs = read_runs([tmp_path / "a", tmp_path / "b"])
    figure = curve_figure(runs, DEPTH, [], None)
    assert [trace["name"] for trace in figure.data] == ["a", "b"]
    assert figure.data[0]["line"]["color"] != figure.data[1]["line"]["color"]
    assert max(figure.data[1]["x"]) == pytest.approx(4.0), "mm"


@pytest.mark.parametrize("suffix", [".png", ".svg"])
def test_a_picture_is_written(tmp_path: Path, suffix: str) -> None:
    foam(tmp_path / "a")
    path = tmp_path / f"x{suffix}"
    draw_curves([tmp_path / "a"], path, x="cg.travel", y=["force"])
    assert path.read_bytes().startswith(b"\x89PNG" if suffix == ".png" else b"<?xml")


def test_what_cannot_be_drawn_is_refused_and_nothing_is_written(tmp_path: Path) -> None:
    foam(tmp_path / "a")
    with pytest.raises(InputError, match=r"y: .*no such channel; found 'forse'.*Did you mean"):
        draw_curves([tmp_path / "a"], tmp_path / "x.png", y=["forse"])
    with pytest.raises(InputError, match="no format of pictures"):
        draw_curves([tmp_path / "a"], tmp_path / "x.foo", y=["force"])
    with pytest.raises(OutputError):
        draw_curves([tmp_path / "a"], tmp_path / "none" / "x.png", y=["force"])
    assert [path.name for path in tmp_path.iterdir()] == ["a"]


def test_several_channels_are_labelled_by_their_quantity_and_told_apart_by_dashes(
    tmp_path: Path,
) -> None:
    runs = read_runs([foam(tmp_path / "a"), foam(tmp_path / "b")])
    several = Curve("time", (FORCE, "head-pad.force_x"))
    figure = curve_figure(runs, several, [], None)
    assert figure.layout["yaxis"]["title"]["text"] == "force [N]"
    named = [trace["name"] for trace in figure.data if trace["showlegend"]]
    assert named == list(several.y), "the legend names each channel once, for all runs"
    dashes = [trace["line"]["dash"] for trace in figure.data]
    assert dashes == ["solid", "dash"] * 2
    assert "b head-pad.force_x" in figure.data[3]["hovertemplate"]
