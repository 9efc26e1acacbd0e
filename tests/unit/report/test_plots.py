"""The interactive figures hold the numbers of the run."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from tests.figures import checked

from contiga.io.units import with_unit
from contiga.report.plots import energy_figure, history_figures
from contiga.report.run_folder import Run, read_run


def test_history_figures_draw_the_columns(run_folder: Path) -> None:
    run = read_run(run_folder)
    columns = run.contacts["press"]
    force, *others = map(checked, history_figures(run, 2.0))
    assert [t.name for t in force.data] == ["along z", "magnitude"], "no line for a zero force"
    np.testing.assert_array_equal(force.data[0].y, columns["force_z"])
    np.testing.assert_array_equal(force.data[1].y, columns["force"])
    for figure, name in zip(others, ("max_penetration", "area", "n_contact"), strict=True):
        (trace,) = figure.data
        np.testing.assert_array_equal(trace.y, columns[name])
        np.testing.assert_array_equal(trace.x, run.times)
        assert figure.layout.shapes[0].x0 == 2.0


def test_every_axis_names_its_unit(run_folder: Path) -> None:
    figures = [checked(figure) for figure in history_figures(read_run(run_folder), None)]
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
    two = run._replace(contacts={"a": columns, "b": columns})
    for figure in map(checked, history_figures(two, None)):
        assert [t.name for t in figure.data] == ["a", "b"]
        assert figure.layout.showlegend


def test_energies_are_stacked_under_the_work(run_folder: Path) -> None:
    run = read_run(run_folder)
    n = len(run.times)
    given = {
        "work": np.linspace(0.0, 5.0, n),
        "energy_stored": np.linspace(0.0, 3.0, n),
        "energy_hysteresis": np.zeros(n),
        "energy_friction": np.linspace(0.0, 1.5, n),
    }
    columns = run.contacts["press"] | given
    two = run._replace(contacts={"a": columns, "b": columns})
    *_, energy = map(checked, history_figures(two, 2.0))
    assert [t.name for t in energy.data] == ["stored", "friction", "work"], "no layer of nothing"
    assert [t.stackgroup for t in energy.data] == ["energy", "energy", None]
    np.testing.assert_array_equal(energy.data[1].y, 2.0 * given["energy_friction"])
    np.testing.assert_array_equal(energy.data[2].y, 2.0 * given["work"])
    assert energy.layout.yaxis.title.text == with_unit("Energy of contact", run.units.energy)


def test_areas_between_written_steps_are_passed_over(run_folder: Path) -> None:
    run = read_run(run_folder)
    area = np.array([0.0, np.nan, 45.0, np.nan, 0.0])
    columns = run.contacts["press"] | {"area": area}
    figures = history_figures(run._replace(contacts={"press": columns}), 2.0)
    _, _, figure, _ = map(checked, figures)
    assert figure.data[0].x.tolist() == [0.0, 2.0, 4.0]
    assert figure.data[0].y.tolist() == [0.0, 45.0, 0.0]


def moving(run: Run) -> Run:
    """The run with energies of a system, and work of its contact beside them."""
    energy = {
        "kinetic": np.array([5.0, 4.0, 0.5, 2.0, 2.5]),
        "strain": np.zeros(5),
        "contact": np.array([0.0, 0.8, 3.5, 1.0, 0.0]),
        "friction": np.array([0.0, 0.1, 0.5, 0.9, 1.0]),
        "damping": np.zeros(5),
        "hysteresis": np.array([0.0, 0.1, 0.5, 1.2, 1.6]),
        "external": np.array([0.0, 0.1, 0.1, 0.2, 0.2]),
        "error": np.array([0.0, 0.1, 0.1, 0.1, 0.1]),
    }
    columns = run.contacts["press"] | {"work": np.linspace(0.0, 5.0, 5)}
    return run._replace(energy=energy, contacts={"press": columns})


def test_energies_of_the_system_are_stacked_under_what_was_given(run_folder: Path) -> None:
    run = moving(read_run(run_folder))
    figure = checked(energy_figure(run, 2.0))
    names = ["kinetic", "contact", "friction", "hysteresis", "initial and external", "error"]
    assert [t.name for t in figure.data] == names, "no layer of nothing"
    assert [t.stackgroup for t in figure.data] == ["energy"] * 4 + [None] * 2
    for trace in figure.data[:4]:
        np.testing.assert_array_equal(trace.y, run.energy[trace.name])
    np.testing.assert_allclose(figure.data[4].y, 5.0 + run.energy["external"], rtol=1e-12)
    np.testing.assert_array_equal(figure.data[5].y, run.energy["error"])


def test_energies_are_told_once(run_folder: Path) -> None:
    run = read_run(run_folder)
    both = moving(run)
    assert len(history_figures(both, 2.0)) == 4
    assert len(history_figures(both._replace(energy={}), 2.0)) == 5
    assert energy_figure(run, 2.0) is None
    still = {name: 0.0 * values for name, values in both.energy.items()}
    assert energy_figure(run._replace(energy=still), 2.0) is None


def test_layers_of_a_long_run_have_their_rows_in_common(run_folder: Path) -> None:
    run = moving(read_run(run_folder))
    rng = np.random.default_rng(3)
    energy = {name: rng.uniform(0.0, 1.0, 30_000) for name in run.energy}
    long = run._replace(times=np.arange(30_000.0), energy=energy)
    *layers, given, _ = checked(energy_figure(long, None)).data
    for trace in layers:
        np.testing.assert_array_equal(trace.x, given.x)
    assert 2000 < len(given.x) <= 4000
