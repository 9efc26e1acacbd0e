"""An output folder read back."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from contiga.errors import FileError
from contiga.report.run_folder import Units, read_fields, read_run, sort_columns

from .conftest import write_folder


def test_units_of_labels_follow_from_the_base_units(run_folder: Path) -> None:
    units = read_run(run_folder).units
    assert (units.force, units.stress, units.area) == ("N", "MPa", "mm²")


def test_columns_are_sorted_by_what_they_are_of() -> None:
    labels = [
        *("time", "left.force", "left.wall_time", "up.right.force", "up.right.area"),
        *("left.x", "left.qw", "a.head.wz", "cog.ax", "cog.filtered_a", "energy.kinetic"),
        *("belt.force", "belt.energy_stored", "step.reason", "step.single"),
    ]
    history = {label: np.full(1, k) for k, label in enumerate(labels)}
    owners = sort_columns(history, ["left", "up.right"], ["cog"], ["belt"], ["bag"])
    assert {k: list(v) for k, v in owners.contacts.items()} == {
        "left": ["force"],
        "up.right": ["force", "area"],
    }
    assert {k: list(v) for k, v in owners.bodies.items()} == {
        "left": ["x", "qw"],
        "a.head": ["wz"],
    }
    assert {k: list(v) for k, v in owners.sensors.items()} == {"cog": ["ax", "filtered_a"]}
    assert {k: list(v) for k, v in owners.springs.items()} == {"belt": ["force", "energy_stored"]}
    assert list(owners.energy) == ["kinetic"]
    assert list(owners.steps) == ["reason", "single"]
    assert owners.bodies["left"]["qw"][0] == labels.index("left.qw")


def test_columns_without_a_name_belong_to_the_only_contact() -> None:
    history = {"time": np.zeros(1), "force": np.zeros(1), "head.x": np.zeros(1)}
    owners = sort_columns(history, ["press"], [], [], [])
    assert {k: list(v) for k, v in owners.contacts.items()} == {"press": ["force"]}
    assert list(owners.bodies) == ["head"]
    assert list(sort_columns({"force": np.zeros(1)}, [], [], [], []).contacts) == ["contact"]


def test_a_contact_may_be_called_energy() -> None:
    owners = sort_columns({"energy.force": np.zeros(1)}, ["energy", "other"], [], [], [])
    assert (list(owners.contacts), owners.energy) == (["energy"], {})


def test_accelerations_are_in_g_where_units_are_known(run_folder: Path) -> None:
    units = read_run(run_folder).units
    values, unit = units.accelerations(np.array([0.00980665, 0.0196133]))
    np.testing.assert_allclose(values, [1.0, 2.0], rtol=1e-12)
    assert unit == "g"
    bare = Units(*[""] * 7)
    assert bare.accelerations(np.ones(2))[1] == ""
    np.testing.assert_array_equal(bare.accelerations(np.ones(2))[0], [1.0, 1.0])


def test_totals_add_up_over_contacts(run_folder: Path) -> None:
    run = read_run(run_folder)
    two = run._replace(contacts={"a": run.contacts["press"], "b": run.contacts["press"]})
    np.testing.assert_array_equal(two.total("force"), 2 * run.contacts["press"]["force"])
    assert two.total("no such column").tolist() == [0.0] * 5
    assert run.greatest("force") == (90.0, 2.0)


def test_run_without_fields_has_none(tmp_path: Path) -> None:
    assert read_fields(read_run(write_folder(tmp_path / "out", fields=False))) is None


@pytest.mark.parametrize("name", ["history.csv", "summary.json"])
def test_folder_of_something_else_is_refused(run_folder: Path, name: str) -> None:
    (run_folder / name).unlink()
    with pytest.raises(FileError, match=name):
        read_run(run_folder)


def test_missing_folder_is_refused(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="no such output folder"):
        read_run(tmp_path / "nowhere")


def test_summary_that_is_no_json_is_refused(run_folder: Path) -> None:
    (run_folder / "summary.json").write_text("{", encoding="utf-8")
    with pytest.raises(FileError, match="not a readable summary"):
        read_run(run_folder)
