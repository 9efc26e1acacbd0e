"""Two runs beside each other, against differences that are known."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

import contiga as cg
from contiga.errors import FileError, InputError
from contiga.io.out.history import write_history
from contiga.report.comparison_page import page_of, write_comparison

CASE = """
title = "{title}"
[time]
end = 4.0
step = {step}
[[body]]
name = "head"
motion = {{ kind = "free", velocity = [0, 0, {speed}] }}
[[contact]]
master = "head"
slave = "pad"
law = {{ kind = "penalty", stiffness = 5.0 }}
"""


def write_run(
    folder: Path,
    times: np.ndarray,
    *,
    factor: float = 1.0,
    speed: float = -5.0,
    units: tuple[str, str, str] = ("mm", "g", "ms"),
    **more: np.ndarray,
) -> Path:
    """The folder of a run whose force is `factor` times a parabola over 0 to 4, 4 at t = 2."""
    folder.mkdir()
    force = factor * times * (4.0 - times)
    area = np.where(np.arange(len(times)) % 2 == 0, 2.0 * times, np.nan)
    history = {"time": times, "force": force, "area": area, "wall_time": np.full(len(times), 0.01)}
    write_history(folder / "history.csv", history | more, {"time": "ms", "force": "N"})
    summary = {
        "title": folder.name,
        "units": dict(zip(("length", "mass", "time"), units, strict=True)),
        "timings": {"search": 1.0, "total": 2.0 * factor},
        "steps": len(times),
        "statuses": {"head-pad": {}},
        "energy": {"relative": 1e-4 * factor, "most": 10.0},
        "sensors": {"cg": {"criteria": {"HIC15": {"value": 100 * factor, "start": 0, "end": 1}}}},
    }
    (folder / "summary.json").write_text(json.dumps(summary), encoding="utf-8")
    text = CASE.format(title="Fall", speed=speed, step=times[1] - times[0])
    (folder / "case.toml").write_text(text, encoding="utf-8")
    return folder


COARSE, FINE = np.linspace(0.0, 4.0, 5), np.linspace(0.0, 4.0, 9)


def test_a_run_beside_itself_is_the_same(tmp_path: Path) -> None:
    a = write_run(tmp_path / "a", FINE)
    result = cg.compare(a, a)
    assert result.same
    assert result.settings == {}
    assert "largest difference 0" in repr(result)


def test_differences_are_those_of_the_curves(tmp_path: Path) -> None:
    a = write_run(tmp_path / "a", FINE)
    b = write_run(tmp_path / "b", FINE, factor=1.5, speed=-6.0)
    result = cg.compare(a, b)
    force = result.differences["head-pad.force"]
    assert force.peaks == (4.0, 6.0)
    assert force.peak_times == (2.0, 2.0)
    assert (force.largest, force.at) == (2.0, 2.0)
    assert force.relative == 2.0 / 6.0
    # The trapezoidal rule over steps of 0.5; both ends are zero.
    square = (0.5 * FINE * (4.0 - FINE)) ** 2
    assert force.rms == pytest.approx(np.sqrt(0.5 * square[1:-1].sum() / 4.0), rel=1e-14)
    assert result.settings == {"body.head.motion.velocity": ([0, 0, -5.0], [0, 0, -6.0])}
    assert result.criteria == {"cg: HIC15": (100.0, 150.0)}
    assert result.energies["relative"] == (1e-4, pytest.approx(1.5e-4))
    assert result.timings["total"] == (2.0, 3.0)
    assert result.differences["head-pad.area"].largest == 0.0, "gaps between written steps are none"


def test_other_steps_and_ends_are_interpolated(tmp_path: Path) -> None:
    a, b = write_run(tmp_path / "a", COARSE), write_run(tmp_path / "b", FINE[:8])
    result = cg.compare(a, b)
    assert result.span == (0.0, 3.5)
    # A chord of a parabola of curvature 2 over a step of 1 is 1/4 off in its middle.
    force = result.differences["head-pad.force"]
    assert (force.largest, force.at) == (0.25, 0.5)
    assert not result.same


def test_what_one_run_alone_has_is_named(tmp_path: Path) -> None:
    a = write_run(tmp_path / "a", FINE)
    b = write_run(tmp_path / "b", FINE, **{"head.vz": FINE})
    assert cg.compare(a, b).only == ((), ("head.vz",))
    assert not cg.compare(a, b).same
    assert "only in b: head.vz" in page_of(cg.compare(a, b))


def test_the_page_says_all_of_it_and_reads_offline(tmp_path: Path) -> None:
    a = write_run(tmp_path / "a", FINE)
    b = write_run(tmp_path / "b", COARSE, factor=1.5, speed=-6.0)
    page = write_comparison(cg.compare(a, b), tmp_path / "both.html").read_text(encoding="utf-8")
    for text in ("body.head.motion.velocity", "head-pad: force [N]", "HIC15", "+50 %", "Search"):
        assert text in page
    assert page.count('id="both-') >= 2
    assert not re.search(r'<(script|link|img)[^>]*(src|href)="https?:', page)


def test_folders_of_one_name_are_told_apart(tmp_path: Path) -> None:
    for name in ("one", "two"):
        (tmp_path / name).mkdir()
    a, b = (write_run(tmp_path / name / "out", FINE) for name in ("one", "two"))
    assert str(a) in page_of(cg.compare(a, b))


@pytest.mark.parametrize("which", [0, 1])
def test_what_is_no_run_is_told(tmp_path: Path, which: int) -> None:
    folders = [write_run(tmp_path / "a", FINE), tmp_path / "nowhere"]
    with pytest.raises(FileError, match="no such output folder"):
        cg.compare(folders[which], folders[1 - which])
    (tmp_path / "nowhere").mkdir()
    with pytest.raises(FileError, match="not the output folder of a run"):
        cg.compare(folders[which], folders[1 - which])


def test_runs_that_can_not_be_compared_are_told(tmp_path: Path) -> None:
    a = write_run(tmp_path / "a", FINE)
    with pytest.raises(InputError, match=r"one run has units and another has none.*found 'none'"):
        cg.compare(a, write_run(tmp_path / "b", FINE, units=("", "", "")))
    with pytest.raises(InputError, match="no time in common"):
        cg.compare(a, write_run(tmp_path / "c", FINE + 10.0))
    with pytest.raises(InputError, match="too many runs"):
        cg.compare(a, *[a] * 20)


def test_runs_in_other_units_are_converted_to_those_of_the_first(tmp_path: Path) -> None:
    """A run in m, kg and s with the numbers of one in mm, g and ms: N and ms become 1 and 1000."""
    a = write_run(tmp_path / "a", FINE, **{"cg.a": FINE})
    b = write_run(tmp_path / "b", FINE / 1000.0, units=("m", "kg", "s"), **{"cg.a": 1e3 * FINE})
    result = cg.compare(a, b)
    assert result.span == (0.0, 4.0)
    assert result.runs[1].units == result.runs[0].units
    acceleration = result.differences["cg.a"]
    assert acceleration.largest == pytest.approx(0.0, abs=1e-12)
    assert result.energies["most"] == (10.0, pytest.approx(10_000.0)), "J are 1000 mJ"
    page = page_of(result)
    assert "converted from m, kg, s to mm, g, ms" in page
    assert "cg: acceleration [g]" in page


def test_many_runs_are_held_against_the_first(tmp_path: Path) -> None:
    factors = (1.0, 1.5, 0.5)
    runs = [write_run(tmp_path / f"r{k}", FINE, factor=f) for k, f in enumerate(factors)]
    result = cg.compare(*runs)
    force = result.differences["head-pad.force"]
    assert force.peaks == (4.0, 6.0, 2.0)
    assert (force.largest, force.at) == (2.0, 2.0)
    assert result.criteria == {"cg: HIC15": (100.0, 150.0, 50.0)}
    page = page_of(result)
    for text in ("3 runs", "Peak of r2", "Largest difference from r0", "head-pad.force [N]"):
        assert text in page
    assert ">Change</th>" not in page


def test_what_is_rounding_in_every_run_is_left_out(tmp_path: Path) -> None:
    noise = {"head.x": 1e-14 * FINE, "head.z": 50.0 * FINE, "head.wx": 1e-18 * FINE}
    noise["head-pad.moment_x"] = 1e-13 * FINE
    a = write_run(tmp_path / "a", FINE, **noise)
    b = write_run(tmp_path / "b", FINE, **{name: -3.0 * of for name, of in noise.items()})
    result = cg.compare(a, b)
    assert {"head.x", "head.wx", "head-pad.moment_x"} <= result.noise
    assert "head.z" not in result.noise
    page = page_of(result)
    assert "head: along z" in page
    assert "head: along x" not in page
    assert "head.wx" not in page
    assert "3 are rounding in every run" in page
    c = write_run(tmp_path / "c", FINE, **{**noise, "head.x": FINE})
    assert "head.x" not in cg.compare(a, c).noise, "it is a signal in one of them"


def test_cases_of_a_study_are_called_by_their_values(tmp_path: Path) -> None:
    runs = [write_run(tmp_path / f"000{k}", FINE) for k in (1, 2)]
    for run, value in zip(runs, (40.0, 60.0), strict=True):
        row = {"values": {"slave.pad.thickness": value}}
        (run / "row.json").write_text(json.dumps(row), encoding="utf-8")
    result = cg.compare(*runs)
    assert result.names == ("0001 · thickness 40", "0002 · thickness 60")
    assert result.short_names == ("0001", "0002")


@pytest.mark.parametrize(("count", "sideways"), [(5, False), (6, True)])
def test_many_runs_are_printed_sideways(tmp_path: Path, count: int, sideways: bool) -> None:
    runs = [write_run(tmp_path / f"r{k}", FINE) for k in range(count)]
    assert ('<div class="many">' in page_of(cg.compare(*runs))) == sideways
