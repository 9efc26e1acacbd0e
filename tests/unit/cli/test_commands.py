"""The command line: what it prints where, and its exit codes."""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path

import pytest
import typer
from tests import occ_rig

import contiga
import contiga.running.run_case
from contiga.cli import commands
from contiga.cli.compiling import watch_compiling
from contiga.errors import RunError
from contiga.jit.prebuilt import choice

from .conftest import CASE, NO_REPORT, Command, one_message


def test_version(command: Command) -> None:
    said = f"contiga {contiga.__version__}\n{choice().text}\n"
    assert command("--version") == (0, said, "")


@pytest.mark.parametrize("arguments", [["nonsense"], ["run"], ["run", "a.toml", "--fast"]])
def test_wrong_usage_leaves_with_two(command: Command, arguments: list[str]) -> None:
    code, out, err = command(*arguments)
    assert code == 2
    assert out == ""
    assert "Usage" in err


def test_run_writes_the_whole_folder(command: Command, case: Path, tmp_path: Path) -> None:
    out = tmp_path / "results"
    code, text, _ = command("run", case, "-o", out)
    assert code == 0
    names = {path.name for path in out.iterdir()}
    assert {"history.csv", "fields.vtkhdf", "summary.json", "case.toml", "report.html"} <= names
    assert not [name for name in names if name.startswith(".")]
    assert "peak force 10 N at t = 1 ms" in text, "what its curve says"
    assert f"report: {out / 'report.html'}" in text


def test_run_without_out_writes_beside_the_case(command: Command, case: Path) -> None:
    case.write_text(CASE + NO_REPORT, encoding="utf-8")
    assert command("run", case, "--quiet") == (0, "", "")
    assert (case.parent / "press_out" / "history.csv").is_file()


def test_finished_run_resumes_to_the_same_history(command: Command, case: Path) -> None:
    case.write_text(CASE + NO_REPORT, encoding="utf-8")
    command("run", case, "--quiet")
    history = case.parent / "press_out" / "history.csv"
    before = history.read_text(encoding="utf-8").splitlines()
    assert command("run", case, "--quiet", "--resume")[0] == 0
    after = history.read_text(encoding="utf-8").splitlines()
    clock = before[0].split(",").index("wall_time [s]")
    for one, two in zip(before, after, strict=True):
        first, second = one.split(","), two.split(",")
        assert first[:clock] + first[clock + 1 :] == second[:clock] + second[clock + 1 :]


def test_check_says_what_a_run_would_do_and_writes_nothing(command: Command, case: Path) -> None:
    code, out, err = command("check", case)
    assert code == 0
    assert err == ""
    for text in ("Ball and sheet", "sphere(radius = 10.0)", "4 steps", "ready to run"):
        assert text in out
    assert list(case.parent.iterdir()) == [case]


def test_a_run_takes_the_steps_that_check_tells(command: Command, case: Path) -> None:
    case.write_text(CASE + NO_REPORT, encoding="utf-8")
    assert " in 4 steps of " in command("check", case)[1]
    assert command("run", case)[1].startswith("4 steps in ")
    summary = json.loads((case.parent / "press_out" / "summary.json").read_text())
    assert summary["steps"] == 4


@pytest.mark.parametrize("name", ["run", "check"])
def test_wrong_case_is_one_message_and_leaves_nothing(
    command: Command, case: Path, name: str
) -> None:
    case.write_text(CASE.replace("radius = 10.0", "radiuss = 10.0"), encoding="utf-8")
    code, out, err = command(name, case)
    assert code == 2
    assert out == ""
    assert "radiuss" in one_message(err)
    assert "radius" in err.replace("radiuss", "")
    assert list(case.parent.iterdir()) == [case]


@pytest.mark.parametrize("name", ["run", "check", "info", "report"])
def test_missing_file_is_one_message(command: Command, tmp_path: Path, name: str) -> None:
    code, out, err = command(name, tmp_path / "nowhere.toml")
    assert code == 2
    assert out == ""
    assert "nowhere.toml" in one_message(err)


def test_output_folder_of_something_else_is_refused(command: Command, case: Path) -> None:
    foreign = case.parent / "thesis"
    foreign.mkdir()
    (foreign / "chapter1.txt").write_text("my work", encoding="utf-8")
    code, _, err = command("run", case, "-o", foreign, "--quiet")
    assert code == 2
    assert "thesis" in one_message(err)
    assert [path.name for path in foreign.iterdir()] == ["chapter1.txt"]


def raising(error: BaseException):
    def run(*_: object, **__: object) -> None:
        raise error

    return run


def test_run_that_fails_leaves_with_one(
    command: Command, case: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(contiga.running.run_case, "run", raising(RunError("no convergence")))
    code, _, err = command("run", case)
    assert code == 1
    assert one_message(err) == "contiga: error: no convergence"


def test_unexpected_failure_says_how_to_see_more(
    command: Command, case: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(contiga.running.run_case, "run", raising(ZeroDivisionError("a\nb")))
    code, _, err = command("run", case)
    assert code == 1
    assert "ZeroDivisionError: a" in one_message(err)
    assert "CONTIGA_DEBUG=1" in err
    monkeypatch.setenv("CONTIGA_DEBUG", "1")
    with pytest.raises(ZeroDivisionError):
        command("run", case)


def test_stopped_run_says_how_to_go_on(
    command: Command, case: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(contiga.running.run_case, "run", raising(KeyboardInterrupt()))
    assert command("run", case) == (130, "", "\ncontiga: stopped\n"), "nothing to go on from"
    (case.parent / "press_out").mkdir()
    (case.parent / "press_out" / "checkpoint.h5").touch()
    code, _, err = command("run", case)
    assert code == 130
    assert f"contiga run {case} -o {case.parent / 'press_out'} --resume" in err.replace("\n", " ")


def test_a_case_is_not_written_over(command: Command, tmp_path: Path) -> None:
    case = tmp_path / "case.toml"
    case.write_text(CASE + NO_REPORT, encoding="utf-8")
    assert command("run", case, "-o", tmp_path / "out", "--quiet") == (0, "", "")
    (tmp_path / "history.csv").touch()
    code, _, err = command("run", case, "-o", tmp_path)
    assert code == 2
    assert "would write its copy of the case over the case file" in one_message(err)
    assert case.read_text(encoding="utf-8") == CASE + NO_REPORT
    # The copy in the output folder says the same: running it there changes nothing.
    copy = tmp_path / "out" / "case.toml"
    text = copy.read_text(encoding="utf-8")
    assert command("run", copy, "-o", tmp_path / "out", "--quiet") == (0, "", "")
    assert copy.read_text(encoding="utf-8") == text


def test_a_title_in_brackets_is_shown_as_it_is(command: Command, case: Path) -> None:
    title = "Ball [mm] and [/sheet]"
    case.write_text(CASE.replace("Ball and sheet", title) + NO_REPORT, encoding="utf-8")
    code, out, _ = command("check", case)
    assert code == 0
    assert title in out
    code, _, err = command("run", case)
    assert code == 0
    assert title in err


def test_wrong_input_of_a_run_is_told_without_a_bar(command: Command, case: Path) -> None:
    law = 'law = { kind = "adaptive" }'
    case.write_text(CASE.replace('law = { kind = "force", curve = [[0, 0], [1, 10]] }', law))
    code, _, err = command("run", case)
    assert code == 2
    assert err.startswith("contiga: error: ")
    assert "nodal mass" in one_message(err)


def test_a_want_of_memory_is_told(
    command: Command, case: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def allocate(*_: object, **__: object) -> None:
        raise MemoryError("Unable to allocate 7.3 TiB")

    monkeypatch.setattr("contiga.case.schema.load_case", allocate)
    code, _, err = command("run", case)
    assert code == 1
    assert "not enough memory (Unable to allocate" in one_message(err)


def test_points_without_number_are_refused_by_their_keys(command: Command, case: Path) -> None:
    many = "nu = 1000000, nv = 1000000"
    case.write_text(CASE.replace("nu = 9, nv = 9", many), encoding="utf-8")
    code, _, err = command("run", case)
    assert code == 2
    assert "slave[0].points" in one_message(err)


def test_a_body_without_size_is_told(command: Command, case: Path) -> None:
    case.write_text(CASE.replace("radius = 10.0", "radius = 1e-200"), encoding="utf-8")
    code, _, err = command("check", case)
    assert code == 2
    assert "the body's size cannot be computed with" in one_message(err)


def test_a_force_that_is_not_finite_is_warned_of(command: Command, case: Path) -> None:
    strong = CASE.replace("[1, 10]", "[1, 1e308]").replace("[1, 0, 0, 9]", "[1, 0, 0, 8]")
    case.write_text(strong + NO_REPORT, encoding="utf-8")
    with pytest.warns(RuntimeWarning):
        code, out, _ = command("run", case)
    assert code == 0
    assert "warning: ball-sheet: the force is not finite in 1 steps, first at t = 1" in out


def test_compiling_is_told_once(monkeypatch: pytest.MonkeyPatch, capsys) -> None:
    from numba import njit
    from numba.core import event

    heard: list[event.Listener] = []
    with monkeypatch.context() as patched:
        patched.setattr(event, "register", lambda _, listener: heard.append(listener))
        patched.setattr(sys.stderr, "isatty", lambda: True)
        watch_compiling(typer.Context(typer.main.get_command(commands.app)))
    with event.install_listener("numba:compile", heard[0]):
        for shift in (1.0, 2.0):
            njit(lambda x, shift=shift: x + shift)(0.0)
    assert capsys.readouterr().err.count("compiling kernels") == 1


def test_check_says_of_a_body_whether_it_is_closed(command: Command, case: Path) -> None:
    case.write_text(CASE, encoding="utf-8")
    _, out, _ = command("check", case)
    assert re.search(r"surface +(closed|open, \d+ free edges)", out)


@pytest.mark.parametrize(("solids", "sound"), [("union", True), ("separate", False)])
def test_check_of_a_body_that_a_flaw_makes_open_does_not_end_with_ready(
    command: Command, case: Path, solids: str, sound: bool
) -> None:
    made = occ_rig.Rig()
    box = made.product(occ_rig.box(), "box")
    made.assembly("all", (box, occ_rig.at(0, 0, 0), "a"), (box, occ_rig.at(1, 1, 0), "b"))
    made.write(case.parent / "rig.step")
    case.write_text(
        'units = { length = "mm", mass = "g", time = "ms" }\ntime = { end = 1.0, step = 0.5 }\n'
        f'body = [{{ name = "rig", geometry = {{ file = "rig.step", solids = "{solids}" }} }}]\n'
        '[[slave]]\nname = "dot"\npoints = { coordinates = [[1.0, 1.0, 9.0]] }\narea = 1.0\n'
        'motion = { kind = "translate", table = [[0, 0, 0, 0], [1, 0, 0, -9]] }\n'
        '[[contact]]\nmaster = "rig"\nslave = "dot"\nlaw = { kind = "penalty", stiffness = 1 }\n',
        encoding="utf-8",
    )
    code, out, _ = command("check", case)
    assert code == 0
    last = out.splitlines()[-1]
    assert ("is ready to run" in last) == sound
    assert (f"{case} runs, but not as it is meant: body rig counts as open" in last) != sound
    assert ("warning: body rig: contact takes it for an open surface" in out) != sound
    assert command("check", case, "--strict")[0] == (0 if sound else 2)


@pytest.mark.parametrize("suffix", [".png", ".html"])
def test_preview_and_check_write_what_stands_where(
    command: Command, case: Path, suffix: str
) -> None:
    first, second = (case.with_name(f"{name}{suffix}") for name in ("a", "b"))
    code, out, err = command("preview", case, "-o", first)
    assert (code, out, err) == (0, f"preview: {first}\n", "")
    code, out, _ = command("check", case, "--picture", second)
    assert code == 0
    assert f"\npreview: {second}\n" in out
    assert "is ready to run" in out.splitlines()[-1]
    assert first.read_bytes()[:4] == (b"\x89PNG" if suffix == ".png" else b"<!do")


@pytest.mark.parametrize("name", ["x.pdf", "missing/x.png"])
def test_a_preview_that_cannot_be_written_is_one_message(
    command: Command, case: Path, name: str
) -> None:
    code, _, err = command("preview", case, "-o", case.parent / name)
    assert code == 2
    assert err.count("contiga: error:") == 1
    assert [*case.parent.iterdir()] == [case]


def test_report_is_written_afterwards(command: Command, case: Path) -> None:
    case.write_text(CASE + NO_REPORT, encoding="utf-8")
    command("run", case, "--quiet")
    page = case.parent / "press_out" / "report.html"
    assert not page.exists()
    assert command("report", page.parent) == (0, f"report: {page}\n", "")
    assert page.is_file()
