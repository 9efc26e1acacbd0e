"""One case: the bits of `contiga.run`, a row whatever becomes of it, a folder without leftovers."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest

import contiga as cg
from contiga.studies import one_case
from contiga.studies.one_case import row_of, run_one
from contiga.studies.row import DONE, FAILED, LOST, Row, read_row

from .conftest import base_in, case_at


def _told(path: Path) -> list[str]:
    """A history without the seconds that its steps took."""
    rows = [line.split(",") for line in path.read_text(encoding="utf-8").splitlines()]
    k = next(k for k, name in enumerate(rows[0]) if name.startswith("wall_time"))
    return [",".join(row[:k] + row[k + 1 :]) for row in rows]


def test_a_case_has_the_bits_of_a_run_alone(folder: Path) -> None:
    base = base_in(folder, "max(force)", "end(ball.vz)", "cg.HIC15")
    for number, speed in ((1, -1.0), (2, -2.0)):  # the second finds its body read already
        row = run_one(base, case_at(number, speed))
        alone = cg.load_case(folder / "case.toml", set={"body.ball.motion.velocity[2]": speed})
        result = cg.run(alone, folder / f"alone_{number}")
        assert row.status == DONE
        assert row.collected["max(force)"] == result.history["force"].max() > 0.0
        assert row.collected["end(ball.vz)"] == result.history["ball.vz"][-1]
        criteria = result.summary["sensors"]["cg"]["criteria"]
        assert row.collected["cg.HIC15"] == criteria["HIC15"]["value"]
        mine = base.folder_of(case_at(number, speed))
        assert _told(mine / "history.csv") == _told(folder / f"alone_{number}" / "history.csv")
        assert (mine / "case.toml").read_bytes() == (
            folder / f"alone_{number}" / "case.toml"
        ).read_bytes()


def test_a_case_that_fails_is_a_row_with_its_message(folder: Path) -> None:
    row = run_one(base_in(folder), case_at(1, -1.0, **{"contact[0].law.curve": [[0, 0]]}))
    assert row.status == FAILED
    assert "contact[0].law" in row.message
    assert math.isnan(row.collected["max(force)"])
    again = read_row(folder / "out" / "cases" / "0001")
    assert again is not None
    assert again._replace(collected={}) == row._replace(collected={})


def test_what_is_no_error_of_ours_is_a_row_too(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(*_: object, **__: object) -> None:
        raise ZeroDivisionError("what?")

    monkeypatch.setattr(one_case, "run", broken)
    row = run_one(base_in(folder), case_at(1, -1.0))
    assert (row.status, row.message) == (FAILED, "unexpected ZeroDivisionError: what?")


def test_a_criterion_that_there_is_none_of_is_told(folder: Path) -> None:
    few = case_at(1, -1.0, **{"sensor[0].filter": "CFC1000"})  # steps too long for it
    row = run_one(base_in(folder, "cg.HIC15", "max(force)"), few)
    assert (row.status, row.message) == (DONE, "has no cg.HIC15")
    assert row.collected["max(force)"] > 0.0


def test_a_row_that_is_there_is_taken_and_one_of_other_values_is_not(folder: Path) -> None:
    base, case = base_in(folder), case_at(1, -1.0)
    first = run_one(base, case)
    assert run_one(base, case) == first
    assert row_of(base, case_at(1, -1.5)) is None
    assert row_of(base_in(folder, "steps"), case) is None
    other = run_one(base, case_at(1, -2.0))
    assert other.collected["max(force)"] > first.collected["max(force)"]


def test_a_case_whose_worker_was_lost_is_run_again(folder: Path) -> None:
    base, case = base_in(folder), case_at(1, -1.0)
    home = base.folder_of(case)
    home.mkdir(parents=True)
    Row(1, LOST, "gone", case.values, {"max(force)": math.nan}, 0.0).write(home)
    assert row_of(base, case) is None
    assert run_one(base, case).status == DONE


def test_what_a_killed_process_left_is_gone(folder: Path) -> None:
    base, case = base_in(folder), case_at(1, -1.0)
    home = base.folder_of(case)
    home.mkdir(parents=True)
    (home / ".history.1234.csv").write_text("half", encoding="utf-8")
    (home / "row.json").write_text('{"number": 1, "sta', encoding="utf-8")
    assert row_of(base, case) is None
    assert run_one(base, case).status == DONE
    assert not list(home.glob(".*"))
    assert json.loads((home / "row.json").read_text(encoding="utf-8"))["status"] == DONE
