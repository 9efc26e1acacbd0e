"""``contiga plot`` and ``contiga pack``: a run is drawn as its case asks, and packed."""

from __future__ import annotations

from pathlib import Path

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


def test_a_zip_has_the_whole_name_of_its_folder(command: Command, tmp_path: Path) -> None:
    folder = tmp_path / "out_0.5"
    folder.mkdir()
    (folder / "report.html").write_text("a page", encoding="utf-8")
    code, out, _ = command("pack", folder)
    assert code == 0
    assert out.startswith(str(tmp_path / "out_0.5.zip"))
    assert [path.name for path in tmp_path.glob("*.zip")] == ["out_0.5.zip"]
