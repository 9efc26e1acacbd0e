"""``contiga plot`` and ``contiga pack``: a run is drawn as its case asks, and packed."""

from __future__ import annotations

from pathlib import Path

import pytest

from .conftest import NO_REPORT, Command, one_message

TEST = """
[[plot]]
x = "max_penetration"
y = "ball-sheet.force"
[[reference]]
file = "test.csv"
channel = "force"
corridor = 0.1
"""


def test_a_run_is_drawn_with_the_test_that_its_case_names(
    command: Command, case: Path, tmp_path: Path
) -> None:
    text = case.read_text(encoding="utf-8")
    (tmp_path / "test.csv").write_bytes("Zeit [ms];Kraft [N]\r\n0;0\r\n1;9,5\r\n".encode("cp1252"))
    case.write_text(text + TEST + NO_REPORT, encoding="utf-8")
    assert command("run", case, "-o", tmp_path / "a", "--quiet")[0] == 0
    (tmp_path / "test.csv").unlink()
    code, out, err = command("plot", tmp_path / "a", "-o", tmp_path / "x.svg")
    assert (code, err) == (0, "")
    assert out.strip() == f"picture: {tmp_path / 'x.svg'}"
    assert (tmp_path / "x.svg").read_text(encoding="utf-8").startswith("<?xml")
    code, out, err = command("plot", tmp_path / "a", "-y", "forc", "-o", tmp_path / "y.png")
    assert (code, out) == (2, "")
    assert "Did you mean 'force'?" in one_message(err)
    code, _, err = command("plot", tmp_path / "a", "-x", "force", "-o", tmp_path / "y.png")
    assert code == 2
    assert "-y" in one_message(err)
    assert not (tmp_path / "y.png").exists()
    code, out, err = command("pack", tmp_path / "a")
    assert code == 2
    assert "report.html is missing" in one_message(err)


def test_a_run_tells_how_it_is_rated_beside_its_test(
    command: Command, case: Path, tmp_path: Path
) -> None:
    pytest.importorskip("objective_rating_metrics")
    curve = "[[0, 0], [0.5, 0], [1, 10], [1.5, 0], [2, 0]]"
    text = f'[[reference]]\nname = "T17"\nchannel = "force"\npoints = {curve}\n'
    depth = text.replace("T17", "T18") + 'x = "max_penetration"\n'
    case.write_text(case.read_text(encoding="utf-8") + text + depth, encoding="utf-8")
    code, out, err = command("run", case, "-o", tmp_path / "a")
    assert code == 0, err
    rated = [line for line in out.splitlines() if "beside test" in line]
    assert rated == ["ball-sheet.force beside test T17: rated 1.000, excellent, by ISO/TS 18571"]


def test_the_cases_of_a_study_are_drawn_together(
    command: Command, case: Path, tmp_path: Path
) -> None:
    case.write_text(case.read_text(encoding="utf-8") + NO_REPORT, encoding="utf-8")
    study = tmp_path / "study.toml"
    study.write_text(
        f'base = "{case.name}"\ncollect = ["max(force)"]\n'
        '[[variable]]\nname = "end"\nkey = "time.end"\nvalues = [1.0, 1.5, 2.0]\n',
        encoding="utf-8",
    )
    folder, picture = tmp_path / "out", tmp_path / "all.svg"
    code, _, err = command("study", study, "-o", folder, "--workers", "1", "--quiet")
    assert code == 0, err
    code, _, err = command("plot", folder, "-y", "force", "-o", picture)
    assert (code, err) == (0, "")
    drawn = picture.read_text(encoding="utf-8")
    assert all(f"<!-- {name} · end" in drawn for name in ("0001", "0002", "0003"))


def test_a_zip_has_the_whole_name_of_its_folder(command: Command, tmp_path: Path) -> None:
    folder = tmp_path / "out_0.5"
    folder.mkdir()
    (folder / "report.html").write_text("a page", encoding="utf-8")
    code, out, _ = command("pack", folder)
    assert code == 0
    assert out.startswith(str(tmp_path / "out_0.5.zip"))
    assert [path.name for path in tmp_path.glob("*.zip")] == ["out_0.5.zip"]
