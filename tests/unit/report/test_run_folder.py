"""An output folder read back."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from contiga.errors import FileError
from contiga.report.run_folder import by_contact, read_fields, read_run

from .conftest import write_folder


def test_units_of_labels_follow_from_the_base_units(run_folder: Path) -> None:
    units = read_run(run_folder).units
    assert (units.force, units.stress, units.area) == ("N", "MPa", "mm²")


def test_columns_are_sorted_by_contact() -> None:
    one, two = np.zeros(2), np.ones(2)
    history = {"time": one, "left.force": one, "up.right.force": two, "up.right.area": two}
    contacts = by_contact(history, ["left", "up.right"])
    assert list(contacts) == ["left", "up.right"]
    assert list(contacts["up.right"]) == ["force", "area"]


def test_columns_without_a_name_belong_to_the_only_contact() -> None:
    assert list(by_contact({"time": np.zeros(1), "force": np.zeros(1)}, ["press"])) == ["press"]
    assert list(by_contact({"force": np.zeros(1)}, [])) == ["contact"]


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
