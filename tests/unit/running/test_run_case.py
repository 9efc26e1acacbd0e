"""`contiga.run`: one call from a case to its output folder."""

from __future__ import annotations

import signal
import sys
import weakref
from contextlib import nullcontext
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import contiga as cg
from contiga.errors import CheckpointError, FileError, InputError, OutputError
from contiga.running import interrupts, run_case

CASE = """\
title = "Sheet on a ball"
[units]
length = "mm"
mass = "kg"
time = "ms"
[time]
end = 4
step = 1
[[body]]
name = "ball"
geometry = { shape = "sphere", radius = 10 }
[[slave]]
name = "sheet"
points = { grid = { shape = "plane", width = 4, length = 4, nu = 9, nv = 9, centre = [0, 0, 11] } }
motion = { kind = "translate", table = [[0, 0, 0, 0], [4, 0, 0, -2]] }
[[contact]]
master = "ball"
slave = "sheet"
law = { kind = "force", curve = 3 }
[output]
report = false
"""


def case_file(folder: Path, text: str = CASE) -> Path:
    path = folder / "case.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_a_run_gives_the_force_of_its_law(tmp_path: Path) -> None:
    result = cg.run(cg.load_case(case_file(tmp_path)))
    # The middle of the sheet, at z = 11 − t/2, is the deepest point of the ball of radius 10.
    depth = np.maximum(10.0 - (11.0 - 0.5 * result.history["time"]), 0.0)
    np.testing.assert_allclose(result.history["max_penetration"], depth, atol=1e-12)
    assert (result.history["force"] <= 3.0 * depth + 1e-12).all()
    np.testing.assert_allclose(result.history["force_x"], 0.0, atol=1e-12)
    assert result.history["force_z"][-1] != 0.0
    assert result.out is None
    assert sorted(path.name for path in tmp_path.iterdir()) == ["case.toml"]


def test_a_case_may_be_given_by_its_path(tmp_path: Path) -> None:
    path = case_file(tmp_path)
    for given in (path, str(path)):
        assert len(cg.run(given).history["time"]) == 5


def test_the_copy_in_the_output_folder_gives_the_same_run(tmp_path: Path) -> None:
    first = cg.run(case_file(tmp_path), out=tmp_path / "a")
    again = cg.run(tmp_path / "a" / "case.toml")
    for name in ("n_contact", "force", "max_penetration", "area"):
        np.testing.assert_array_equal(first.history[name], again.history[name])


def test_a_report_is_written_where_the_case_wants_one(tmp_path: Path) -> None:
    cg.run(case_file(tmp_path), out=tmp_path / "without")
    assert not (tmp_path / "without" / "report.html").exists()
    wanted = CASE.replace("report = false", "report = true")
    cg.run(case_file(tmp_path, wanted), out=tmp_path / "with")
    assert "Sheet on a ball" in (tmp_path / "with" / "report.html").read_text(encoding="utf-8")


def test_progress_is_shown_on_the_error_stream(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    cg.run(case_file(tmp_path), quiet=False)
    shown = capsys.readouterr()
    assert shown.out == ""
    assert "4/4" in shown.err
    cg.run(case_file(tmp_path))
    assert capsys.readouterr().err == ""


def test_a_checkpoint_of_another_case_is_refused(tmp_path: Path) -> None:
    out = tmp_path / "out"
    cg.run(case_file(tmp_path), out=out)
    other = case_file(tmp_path, CASE.replace("curve = 3", "curve = 4"))
    with pytest.raises(CheckpointError) as caught:
        cg.run(other, out=out, resume=True)
    assert caught.value.exit_code == 2


@pytest.mark.parametrize(
    ("old", "new", "kind"),
    [
        ('{ shape = "sphere", radius = 10 }', '{ file = "empty.step" }', FileError),
        ('{ shape = "sphere", radius = 10 }', '{ file = "text.igs" }', FileError),
        ("{ grid =", '{ file = "nan.csv", transform = [] } #', InputError),
    ],
)
def test_what_cannot_be_built_leaves_no_folder(
    tmp_path: Path, old: str, new: str, kind: type[InputError]
) -> None:
    (tmp_path / "empty.step").write_text("")
    (tmp_path / "text.igs").write_text("no CAD at all\n")
    (tmp_path / "nan.csv").write_text("0,0,nan\n")
    path = case_file(tmp_path, CASE.replace(old, new))
    with pytest.raises(kind) as caught:
        cg.run(path, out=tmp_path / "out")
    assert str(caught.value).startswith(f"{path}: ")
    assert caught.value.exit_code == 2
    assert not (tmp_path / "out").exists()


def test_an_output_folder_that_cannot_be_made_is_refused(tmp_path: Path) -> None:
    (tmp_path / "taken").write_text("a file")
    with pytest.raises(OutputError) as caught:
        cg.run(case_file(tmp_path), out=tmp_path / "taken")
    assert caught.value.exit_code == 2
    assert (tmp_path / "taken").read_text() == "a file"


def test_an_interrupt_where_python_drops_it_is_noted(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(signal, "getsignal", lambda _: signal.default_int_handler)
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with interrupts.stoppable() as stopped:
            handler = signal.signal(signal.SIGINT, signal.default_int_handler)
            assert callable(handler)
            assert not stopped()
            in_callback = SimpleNamespace(f_code=SimpleNamespace(co_filename=weakref.__file__))
            handler(signal.SIGINT, in_callback)  # type: ignore[arg-type]
            assert stopped()
            with pytest.raises(KeyboardInterrupt):
                handler(signal.SIGINT, sys._getframe())
    finally:
        signal.signal(signal.SIGINT, before)


def test_a_noted_interrupt_stops_at_the_next_step(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(run_case, "stoppable", lambda: nullcontext(lambda: True))
    with pytest.raises(KeyboardInterrupt):
        cg.run(case_file(tmp_path), out=tmp_path / "out")
    assert (tmp_path / "out" / "checkpoint.h5").is_file()
    monkeypatch.undo()
    result = cg.run(case_file(tmp_path), out=tmp_path / "out", resume=True)
    assert len(result.history["time"]) == 5


def test_a_folder_that_was_moved_is_resumed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    here, there = tmp_path / "here", tmp_path / "there"
    here.mkdir()
    points = "\n".join(f"{0.1 * k}, 0.0, 11.0" for k in range(5))
    (here / "sheet.csv").write_text(points, encoding="utf-8")
    grid = (
        '{ grid = { shape = "plane", width = 4, length = 4, nu = 9, nv = 9, centre = [0, 0, 11] } }'
    )
    text = CASE.replace(grid, '{ file = "sheet.csv" }')
    text = text.replace("[output]", 'area = { kind = "constant", value = 1 }\n[output]')
    assert text != CASE
    with monkeypatch.context() as patched:
        patched.setattr(run_case, "stoppable", lambda: nullcontext(lambda: True))
        with pytest.raises(KeyboardInterrupt):
            cg.run(case_file(here, text), out=here / "out")
    here.rename(there)
    result = cg.run(there / "case.toml", out=there / "out", resume=True)
    whole = cg.run(there / "case.toml")
    np.testing.assert_array_equal(result.history["force"], whole.history["force"])


def test_what_is_no_case_is_told() -> None:
    for wrong in (None, {}, 5):
        with pytest.raises(InputError, match="expected a case"):
            cg.run(wrong)  # type: ignore[arg-type]


def test_states_are_kept_on_request(tmp_path: Path) -> None:
    (tmp_path / "case.toml").write_text(CASE, encoding="utf-8")
    result = cg.run(tmp_path / "case.toml", keep=1)
    assert [state.time for state in result.states] == result.history["time"].tolist()
    actual = [state.slaves["sheet"].points[:, 2].max() for state in result.states]
    np.testing.assert_allclose(actual, [11.0, 10.5, 10.0, 9.5, 9.0], rtol=1e-14)
    assert cg.run(tmp_path / "case.toml").states == ()
