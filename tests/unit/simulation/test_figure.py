"""`Result.plot`: the panels, the lines and their units, columns by name, a picture on disk."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from contiga.display import Facts
from contiga.errors import InputError, OutputError
from contiga.simulation.figure import MAX_LINES, plot_history
from contiga.simulation.history_over_time import HistoryOverTime

TIME = np.linspace(0.0, 1.0, 5)
HISTORY = {
    "time": TIME,
    "a.force": np.array([0.0, 3.0, np.nan, 2.0, 0.0]),
    "a.max_penetration": 0.1 * TIME,
    "b.force": np.zeros(5),
    "b.max_penetration": np.zeros(5),
    "spring.force": 50.0 * TIME,
    "head.vx": 3.0 * TIME,
    "head.vy": 4.0 * TIME,
    "head.vz": np.zeros(5),
    "energy.kinetic": 2.0 - TIME,
    "energy.contact": TIME,
    "energy.friction": np.zeros(5),
    "energy.total": np.full(5, 2.0),
}
UNITS = {name: "N" for name in HISTORY if name.endswith("force")} | {
    "time": "ms",
    "a.max_penetration": "mm",
    "b.max_penetration": "mm",
    "head.vx": "mm/ms",
    "energy.total": "mJ",
}
SUMMARY = {"columns": UNITS, "title": "Two contacts"}


def panels(**options: object) -> dict[str, dict[str, np.ndarray]]:
    """The values (n, 2) of each line by axis label and name."""
    figure = plot_history("a test", HISTORY, SUMMARY, **options)  # type: ignore[arg-type]
    return {
        axes.get_ylabel(): {str(line.get_label()): line.get_xydata() for line in axes.lines}
        for axes in figure.axes
    }


def test_panels_are_those_of_contacts_energies_and_motions_that_are_not_zero() -> None:
    drawn = panels()
    assert {label: list(lines) for label, lines in drawn.items()} == {
        "contact force [N]": ["a"],
        "deepest penetration [mm]": ["a"],
        "energy [mJ]": ["kinetic", "contact", "total"],
        "speed [mm/ms]": ["head"],
    }
    np.testing.assert_array_equal(drawn["speed [mm/ms]"]["head"][:, 1], 5.0 * TIME)


def test_a_line_goes_on_over_steps_without_a_value() -> None:
    line = panels()["contact force [N]"]["a"]
    np.testing.assert_array_equal(line, [[0, 0], [0.25, 3], [0.75, 2], [1, 0]])


def test_columns_share_a_panel_by_their_unit() -> None:
    drawn = panels(columns=["spring.force", "head.vx", "a.force"])
    assert {label: list(lines) for label, lines in drawn.items()} == {
        "[N]": ["spring.force", "a.force"],
        "head.vx [mm/ms]": ["head.vx"],
    }


def test_a_run_that_no_force_moves_shows_the_work_on_its_contacts() -> None:
    history = {"time": TIME, "energy_stored": TIME, "energy_friction": 2 * TIME}
    figure = plot_history("a test", history, {})
    (axes,) = figure.axes
    assert axes.get_ylabel() == "energy"
    assert axes.get_xlabel() == "time"
    assert [line.get_label() for line in axes.lines] == ["stored", "friction"]


def test_of_many_lines_the_largest_are_drawn() -> None:
    n = MAX_LINES + 3
    history = {"time": TIME} | {
        f"c{k}.{name}": (k + 1.0) * TIME for k in range(n) for name in ("force", "max_penetration")
    }
    figure = plot_history("a test", history, {})
    kept = [f"c{k}" for k in range(3, n)]
    assert [line.get_label() for line in figure.axes[0].lines] == kept


@pytest.mark.parametrize("suffix", [".png", ".svg"])
def test_the_picture_is_written_in_the_format_of_its_suffix(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"picture{suffix}"
    plot_history("a test", HISTORY, SUMMARY, path=path)
    assert path.read_bytes().startswith(b"\x89PNG" if suffix == ".png" else b"<?xml")
    assert list(tmp_path.iterdir()) == [path]


def test_what_cannot_be_drawn_or_written_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"no such column; found 'a.forse'.*Did you mean a.force"):
        plot_history("a test", HISTORY, SUMMARY, ["a.forse"])
    with pytest.raises(InputError, match=r"no format of pictures has this suffix; found '.foo'"):
        plot_history("a test", HISTORY, SUMMARY, path=tmp_path / "picture.foo")
    with pytest.raises(OutputError):
        plot_history("a test", HISTORY, SUMMARY, path=tmp_path / "none" / "picture.png")
    assert list(tmp_path.iterdir()) == []


def test_no_window_is_opened(monkeypatch: pytest.MonkeyPatch) -> None:
    from matplotlib import pyplot

    before = pyplot.get_fignums()
    plot_history("a test", HISTORY, SUMMARY)
    assert pyplot.get_fignums() == before


def test_a_notebook_shows_the_figure_and_the_curves_of_a_result() -> None:
    figure = plot_history("a test", HISTORY, SUMMARY)
    assert figure._repr_png_().startswith(b"\x89PNG")
    assert len(figure._repr_png_()) < 200_000
    shown = HistoryOfTest(HISTORY, SUMMARY)._repr_html_()
    assert "src='data:image/png;base64," in shown
    assert len(shown) < 200_000


def test_without_matplotlib_a_notebook_shows_the_facts_of_a_result(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    shown = HistoryOfTest(HISTORY, SUMMARY)._repr_html_()
    assert "<img" not in shown
    assert "steps" in shown


class HistoryOfTest(HistoryOverTime):
    """A result of what is written above."""

    def __init__(self, history: dict[str, np.ndarray], summary: dict[str, object]) -> None:
        self.history, self.summary = history, summary

    def _facts(self) -> Facts:
        return [("steps", len(self.history["time"]))]
