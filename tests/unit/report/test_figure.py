"""Figures are what plotly's schema allows, as JSON that may stand in a page."""

from __future__ import annotations

import json
import subprocess
import sys
from base64 import b64decode
from pathlib import Path

import numpy as np
import pytest
from plotly.offline import get_plotlyjs
from tests.figures import checked, figures_of

from contiga.report import write_report
from contiga.report.comparison import compare
from contiga.report.comparison_page import page_of
from contiga.report.figure import Figure, as_json, embedded, plotly_script
from contiga.report.html import page
from contiga.report.run_folder import read_run

from .conftest import write_folder
from .test_comparison import write_run
from .test_motion import falling
from .test_plots import moving
from .test_springs import hang
from .test_steps import COLUMNS, REASONS


def test_what_the_schema_does_not_know_is_found() -> None:
    figure = Figure([{"type": "scatter", "x": [1.0], "colour": "red"}], {"height": 300})
    with pytest.raises(ValueError, match="colour"):
        checked(figure)
    with pytest.raises(ValueError, match="colour"):
        figures_of(embedded(figure, "a-0", {}))


def test_every_figure_of_a_report_is_as_the_schema_wants_it(run_folder: Path) -> None:
    run = falling(moving(read_run(run_folder)))
    told = run.summary | {"step_reasons": REASONS}
    steps = {name: values[:5] for name, values in COLUMNS.items()}
    ball = run.bodies["ball"] | {"wx": np.linspace(0.0, 0.02, 5)}
    sensors = run.sensors | {"neck": {"distance": np.arange(5.0), "angle": np.arange(5.0)}}
    full = run._replace(summary=told, steps=steps, bodies={"ball": ball}, sensors=sensors)
    drawn = figures_of(page(full, still=None, view=None, peak_time=2.0))
    counts = {"history": 4, "steps": 1, "energy": 1, "body": 4, "sensor": 4, "curve": 1}
    assert len(drawn) == sum(counts.values())
    for name, count in counts.items():
        assert sum(key.partition("-")[0] == name for key in drawn) == count, name


def test_every_figure_of_a_report_with_pictures_and_springs_is(run_folder: Path) -> None:
    drawn = figures_of(write_report(hang(run_folder)).read_text(encoding="utf-8"))
    histories = [f"history-{k}" for k in range(4)]
    assert list(drawn) == ["view", *histories, "curve-0", "spring-0", "spring-1"]
    assert [trace.type for trace in drawn["view"].data] == ["mesh3d"] * 2 + ["scatter3d"] * 2


def test_every_figure_of_a_comparison_is(tmp_path: Path) -> None:
    times = np.linspace(0.0, 4.0, 9)
    one, two = write_run(tmp_path / "one", times), write_run(tmp_path / "two", times, factor=2.0)
    assert list(figures_of(page_of(compare(one, two)))) == ["both-0", "both-1"]


@pytest.mark.parametrize(
    ("values", "dtype"),
    [
        (np.array([0.5, np.nan, np.inf]), "f8"),
        (np.array([0.5, -2.0], np.float32), "f4"),
        (np.array([1.0, 2.0], ">f8"), "f8"),
        (np.arange(8.0)[::2], "f8"),
        (np.array([0, 255]), "u1"),
        (np.array([-1, 128]), "i2"),
        (np.array([0, 65_535]), "u2"),
        (np.array([-1, 65_535], np.int32), "i4"),
        (np.array([[1, 2, 3], [4, 5, 6]]), "u1"),
    ],
)
def test_arrays_go_as_their_bytes(values: np.ndarray, dtype: str) -> None:
    read = json.loads(as_json({"x": values}))["x"]
    assert read["dtype"] == dtype
    actual = np.frombuffer(b64decode(read["bdata"]), np.dtype(dtype).newbyteorder("<"))
    np.testing.assert_array_equal(actual, values.ravel())
    assert read.get("shape", "2, 3") == "2, 3"
    assert ("shape" in read) == (values.ndim == 2)


@pytest.mark.parametrize(
    ("value", "text"),
    [
        ([1.0, float("nan"), -np.inf, None], "[1.0,null,null,null]"),
        (np.zeros(0), "[]"),
        ((np.float32(0.5), np.int64(3), np.bool_(True)), "[0.5,3,true]"),
        (np.array([True, False]), "[true,false]"),
        (np.array([2**40, 1]), "[1099511627776,1]"),
        ({"</script><!--": "a<b & “c”"}, '{"\\u003c/script>\\u003c!--":"a\\u003cb & “c”"}'),
    ],
)
def test_the_rest_is_plain_and_ends_no_script(value: object, text: str) -> None:
    assert as_json(value) == text


def test_the_script_is_that_of_the_package() -> None:
    assert plotly_script().startswith(get_plotlyjs())


def test_pages_are_written_without_the_modules_of_plotly(tmp_path: Path) -> None:
    folder = write_folder(tmp_path / "out")
    code = (
        "import sys; from contiga.report import write_report; write_report(sys.argv[1]); "
        "assert not {'plotly', '_plotly_utils', 'narwhals'} & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code, str(folder)], check=True)
