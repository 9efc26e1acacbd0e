"""A whole study in this process: its table, what is missing run again, what is wrong told first."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

import contiga as cg
from contiga.errors import CaseError, OutputError
from contiga.studies.row import FAILED
from contiga.studies.spec import StudySpec
from contiga.studies.study import Study, run_study

from .conftest import STUDY, study_from


def run(study: StudySpec, folder: Path, **options: object) -> Study:
    """In this process, one case after the other."""
    return run_study(study, folder / "out", workers=0, **options)  # type: ignore[arg-type]


def test_a_study_is_a_table_and_a_page(folder: Path) -> None:
    shown: list[tuple[int, int, str]] = []
    result = run(study_from(STUDY, folder), folder, progress=lambda *told: shown.append(told))
    assert shown == [(k, 4, "") for k in range(5)]
    columns = result.table.columns
    assert columns["speed"] == [-1.0, -1.0, -2.0, -2.0]
    assert columns["max(force)"][2] > columns["max(force)"][0] > 0.0
    assert not result.failed
    assert result.page.is_file()
    assert {path.name for path in (folder / "out").iterdir()} == {
        *("cases", "study.json", "study.html", "table.h5", "table.csv")
    }


def test_what_is_missing_is_run_and_the_table_is_the_same(folder: Path) -> None:
    study = study_from(STUDY, folder)
    run(study, folder)
    tables = [(folder / "out" / name).read_bytes() for name in ("table.h5", "table.csv")]
    shutil.rmtree(folder / "out" / "cases" / "0002")
    (folder / "out" / "cases" / "0003" / "row.json").unlink()
    shown: list[int] = []
    run(study, folder, resume=True, progress=lambda done, total, said: shown.append(done))
    assert shown == [2, 3, 4]
    assert [(folder / "out" / name).read_bytes() for name in ("table.h5", "table.csv")] == tables


def test_a_case_that_fails_does_not_stop_the_rest(folder: Path) -> None:
    # a step that is too long for one stiffness, which a run finds out
    text = STUDY.replace(
        '"time.step"\nvalues = [0.5, 0.25]', '"contact[0].law.curve[1][1]"\nvalues = [9, 1e9, 8]'
    )
    result = run(
        study_from(text.replace("values = [-1.0, -2.0]", "values = [-1.0]"), folder), folder
    )
    assert [row.status for row in result.rows] == ["done", FAILED, "done"]
    assert "step" in result.rows[1].message
    assert result.failed == (result.rows[1],)


def test_a_study_that_was_changed_is_not_gone_on_with(folder: Path) -> None:
    study = study_from(STUDY, folder)
    run(study, folder)
    other = study_from(STUDY.replace("-2.0", "-3.0"), folder)
    with pytest.raises(
        OutputError, match=r"the study in the folder differs: variable\[0\].values.*-3"
    ):
        run(other, folder, resume=True)
    case = (folder / "case.toml").read_text(encoding="utf-8")
    (folder / "case.toml").write_text(case.replace("1000.0", "900.0"), encoding="utf-8")
    with pytest.raises(OutputError, match=r"folder differs: base: body\[0\].mass.total; found 900"):
        run(study, folder, resume=True)


def test_how_a_study_is_shown_may_change(folder: Path) -> None:
    run(study_from(STUDY, folder), folder)
    text = STUDY.replace("Speeds and", "Of")
    text = 'retries = 1\nmap = { body = "ball", at = ["speed", "speed", "step"] }\n' + text
    result = run(study_from(text, folder), folder, resume=True)
    assert "Of steps" in result.page.read_text(encoding="utf-8")


def test_a_folder_of_another_is_refused(folder: Path) -> None:
    study = study_from(STUDY, folder)
    with pytest.raises(OutputError, match="no study to resume"):
        run(study, folder, resume=True)
    assert not (folder / "out").exists()
    (folder / "out").mkdir()
    (folder / "out" / "thesis.doc").write_text("mine", encoding="utf-8")
    with pytest.raises(OutputError, match="not of a study"):
        run(study, folder)
    (folder / "out" / "thesis.doc").unlink()
    run(study, folder)
    with pytest.raises(OutputError, match="holds a study already"):
        run(study, folder)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("body.ball.", "body.bal.", "Did you mean 'ball'"),
        ("time.step", "time.stepp", r"time.stepp: unknown key.*Did you mean 'step'"),
        ("[-1.0, -2.0]", '[-1.0, "fast"]', "must be a number"),
        ("[0.5, 0.25]", "[0.5, -0.25]", "time.step: is too small"),
        ("max(force)", "max(forse)", "Did you mean 'force'"),
        ("cg.HIC15", "cg.HIC36", "no such criterion"),
        ("at(ball.vz, 2)", "at(ball.vz, 3)", "after the end"),
        ("base", 'map = { body = "bal", at = ["speed", "step", "step"] }\nbase', "map.body"),
    ],
)
def test_what_is_wrong_is_told_before_anything_runs(
    old: str, new: str, said: str, folder: Path
) -> None:
    with pytest.raises(CaseError, match=said):
        run(study_from(STUDY.replace(old, new, 1), folder), folder)
    assert not (folder / "out").exists()


def test_a_study_in_python_takes_lists_and_ranges(folder: Path) -> None:
    result = cg.study(
        folder / "case.toml",
        {
            "body.ball.motion.velocity[2]": [-1.0, -2.0],
            "contact[0].law.curve[1][1]": {"name": "K", "low": 50.0, "high": 200.0, "count": 3},
        },
        {"F": "max(force)"},
        set={"time.step": 0.25},
        rule=[{"require": "K > 60"}],
        workers=0,
    )
    frame = result.to_pandas()
    assert list(frame.columns) == [*("body.ball.motion.velocity[2]", "K", "F", "status", "message")]
    assert frame["K"].tolist() == [125.0, 200.0, 125.0, 200.0]
    assert result.folder_of(4).is_dir()
    alone = cg.load_case(
        folder / "case.toml",
        set={
            "time.step": 0.25,
            "body.ball.motion.velocity[2]": -2.0,
            "contact[0].law.curve[1][1]": 200.0,
        },
    )
    assert frame["F"][4] == cg.run(alone).history["force"].max()
    assert "cases 4" in repr(result)


def test_a_case_in_python_has_its_keys_filled_in(folder: Path) -> None:
    case = cg.load_case(folder / "case.toml", set={"time.step": 0.25})
    result = cg.study(case, {"contact[0].law.curve.points[1][1]": [90.0]}, ["steps"], workers=0)
    assert result.rows[0].collected["steps"] == 8.0
