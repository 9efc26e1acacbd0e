"""Motion of free bodies and what sensors say: figures of what there is, tables of extremes."""

from __future__ import annotations

from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from tests.figures import checked

from contiga.report.motion import (
    body_figures,
    criteria_table,
    extremes_table,
    sensor_figures,
)
from contiga.report.run_folder import Run, read_run

G = 9.80665e-3  # mm/ms²


@pytest.fixture
def run(run_folder: Path) -> Run:
    return falling(read_run(run_folder))


def falling(run: Run) -> Run:
    """The run with a ball that comes down at 2 mm/ms, and a sensor at its centre."""
    zero, fall = np.zeros(5), np.array([0.0, -2.0, -3.0, -2.0, 1.0])
    ball = {
        "x": zero + 7.0,
        "y": zero,
        "z": 10.0 + fall,
        "vx": zero,
        "vy": zero,
        "vz": np.array([-2.0, -2.0, 0.0, 2.0, 3.0]),
        "ax": zero,
        "ay": zero,
        "az": G * np.array([0.0, 40.0, 90.0, 50.0, 0.0]),
        "qw": zero + 1.0,
        "qx": zero,
        "qy": zero,
        "qz": zero,
        "wx": zero,
        "wy": zero + 1e-14,
        "wz": zero,
    }
    a = G * np.array([0.0, 41.0, 95.0, 50.0, 0.0])
    sensor = {
        "ax": zero,
        "ay": zero,
        "az": a,
        "a": a,
        "x": zero,
        "y": zero,
        "z": fall,
        "vx": zero,
        "vy": zero,
        "vz": ball["vz"],
        "v": np.abs(ball["vz"]),
        "fx": zero,
        "fy": zero,
        "fz": 5.0 * a,
        "f": 5.0 * a,
        "filtered_a": 0.9 * a,
    }
    criteria = {
        "HIC15": {"value": 512.0, "start": 0.5, "end": 3.5},
        "3ms": {"value": 61.5, "unit": "g", "start": 0.75, "end": 3.75},
    }
    told = {"cog": {"body": "ball", "filter": "CFC1000", "criteria": criteria}}
    summary = run.summary | {"sensors": told}
    return run._replace(bodies={"ball": ball}, sensors={"cog": sensor}, summary=summary)


class Cells(HTMLParser):
    """Rows of a table."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.rows: list[list[str]] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: object) -> None:
        if tag == "tr":
            self.rows.append([])
        if tag in ("td", "th"):
            self.rows[-1].append("")

    def handle_data(self, data: str) -> None:
        self.rows[-1][-1] += data


def test_bodies_have_a_figure_for_each_way_they_move(run: Run) -> None:
    figures = [checked(figure) for figure in body_figures(run, "ball", 2.0)]
    assert [figure.layout.yaxis.title.text.replace("<br>", " ") for figure in figures] == [
        "Displacement of the centre [mm]",
        "Velocity of the centre [mm/ms]",
        "Acceleration of the centre [g]",
    ], "a spin of rounding errors is none"
    way, _, acceleration = figures
    assert [trace.name for trace in way.data] == ["along z", "resultant"]
    np.testing.assert_allclose(way.data[0].y, [0.0, -2.0, -3.0, -2.0, 1.0])
    np.testing.assert_allclose(acceleration.data[1].y, [0.0, 40.0, 90.0, 50.0, 0.0])


def test_spin_is_shown_where_there_is_some(run: Run) -> None:
    ball = run.bodies["ball"] | {"wx": np.linspace(0.0, 0.02, 5)}
    *_, spin = map(checked, body_figures(run._replace(bodies={"ball": ball}), "ball", None))
    assert spin.layout.yaxis.title.text == "Spin [rad/ms]"
    assert [trace.name for trace in spin.data] == ["along x", "resultant"]


def test_without_units_accelerations_are_as_they_are(run: Run) -> None:
    bare = run._replace(units=type(run.units)(*[""] * 7))
    _, _, acceleration = map(checked, body_figures(bare, "ball", None))
    assert acceleration.layout.yaxis.title.text == "Acceleration of the centre"
    np.testing.assert_array_equal(acceleration.data[1].y, run.bodies["ball"]["az"])


def test_extremes_are_told_with_their_times_and_the_end(run: Run) -> None:
    head, *rows = Cells(extremes_table(run)).rows
    assert head == ["Body", "Quantity", "Largest", "at t =", "At the end"]
    assert rows == [
        ["ball", "Displacement of the centre", "3 mm", "2 ms", "1 mm"],
        ["ball", "Velocity of the centre", "3 mm/ms", "4 ms", "3 mm/ms"],
        ["ball", "Acceleration of the centre", "90 g", "2 ms", "0 g"],
    ]


def test_sensors_show_raw_and_filtered_acceleration_with_the_criteria(run: Run) -> None:
    figure, *others = map(checked, sensor_figures(run, "cog", 2.0))
    raw, filtered = figure.data
    assert (raw.name, filtered.name) == ("as computed", "CFC1000")
    np.testing.assert_allclose(raw.y, run.sensors["cog"]["a"] / G)
    np.testing.assert_allclose(filtered.y, 0.9 * raw.y)
    assert raw.line.width < filtered.line.width
    _, window, level = figure.layout.shapes
    assert (window.type, window.x0, window.x1) == ("rect", 0.5, 3.5)
    assert (level.type, level.x0, level.x1, level.y0, level.y1) == ("line", 0.75, 3.75, 61.5, 61.5)
    assert [note.text for note in figure.layout.annotations] == ["HIC15 = 512", "3 ms: 61.5 g"]
    # Its way and velocity are those of the body's centre, which stand there already.
    assert [other.layout.yaxis.title.text for other in others] == ["Force [N]"]


def test_a_sensor_beside_the_centre_shows_its_own_way(run: Run) -> None:
    sensor = run.sensors["cog"] | {"z": run.sensors["cog"]["z"] * 1.001}
    figures = sensor_figures(run._replace(sensors={"cog": sensor}), "cog", 2.0)
    titles = [checked(figure).layout.yaxis.title.text for figure in figures]
    assert titles == ["Acceleration, resultant [g]", "Displacement [mm]", "Force [N]"]


def test_an_unfiltered_sensor_has_one_line_and_no_marks(run: Run) -> None:
    sensor = {k: v for k, v in run.sensors["cog"].items() if k != "filtered_a"}
    plain = run._replace(sensors={"cog": sensor}, summary={})
    figure = checked(sensor_figures(plain, "cog", None)[0])
    assert [trace.name for trace in figure.data] == ["resultant"]
    assert (figure.layout.shapes, figure.layout.annotations) == ((), ())
    assert criteria_table(plain) == ""


def test_sensors_of_nothing_have_no_figure(run: Run) -> None:
    still = {name: 0.0 * values for name, values in run.sensors["cog"].items()}
    assert sensor_figures(run._replace(sensors={"cog": still}), "cog", None) == []
    force = still | {"fx": np.ones(5)}
    (figure,) = map(checked, sensor_figures(run._replace(sensors={"cog": force}), "cog", None))
    assert figure.layout.yaxis.title.text == "Force [N]"


def test_criteria_are_told_with_their_windows(run: Run) -> None:
    head, *rows = Cells(criteria_table(run)).rows
    assert head == ["Sensor", "Criterion", "Value", "Window"]
    assert rows == [
        ["cog · ball · CFC1000", "HIC15", "512", "0.5 to 3.5 ms"],
        ["cog · ball · CFC1000", "3ms", "61.5 g", "0.75 to 3.75 ms"],
    ]


def test_runs_without_free_bodies_have_no_table(run_folder: Path) -> None:
    run = read_run(run_folder)
    assert extremes_table(run) == criteria_table(run) == ""


def test_a_sensor_between_two_bodies_has_its_distance_and_its_turn(run: Run) -> None:
    seen = {"distance": np.arange(5.0), "rate": np.ones(5), "angle": 0.1 * np.arange(5.0)}
    told = run._replace(sensors={"neck": seen})
    figures = [checked(figure) for figure in sensor_figures(told, "neck", None)]
    assert [figure.layout.yaxis.title.text for figure in figures] == ["Distance [mm]", "Turn [rad]"]
    np.testing.assert_array_equal(figures[0].data[0].y, seen["distance"])
