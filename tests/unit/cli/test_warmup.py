"""``contiga warmup`` and processes beside a run, with some that only pretend to compile."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numba
import pytest
import typer

from contiga.cli import commands, compiling
from contiga.cli.options import HELPED, WITH_CASE
from contiga.jit import prebuilt
from contiga.jit.cache import COMPILE_LISTENERS
from contiga.jit.prebuilt import Choice
from contiga.warmup import compile_pool, pack, record
from contiga.warmup.listing import Listing, listing

from .conftest import Command, one_message

STUB = """
import json, os, sys
sys.stdin.readline()
for line in sys.stdin:
    row = int(line)
    if row == {lost!r}:
        os._exit(7)
    told = dict(is_compiled={made!r} and row > 0, file={kept!r} + f"/{{row}}.nbi")
    if row == {failing!r}:
        told = dict(error="ValueError: of the stub")
    print(json.dumps(told), flush=True)
"""
HERE = Choice(None, "kernels are compiled on this machine; none are installed")
PARTS: list[list[int]] = [[], [], [0, 1], [2], [0], [], []]
"""Of the kernels that are listed, what they are built of."""


@pytest.fixture
def stub(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """Has processes run a stub of the worker, which has all kernels but one to compile; the folder
    gets a file for each of them when it is started: it may be ended before it does anything."""
    kernels = [["contiga.rooms_nb", f"k{k}", [], parts] for k, parts in enumerate(PARTS)]
    listed = Listing({"types": [], "kernels": kernels})
    monkeypatch.setattr("contiga.warmup.listing.listing", lambda: listed)
    monkeypatch.setattr(compile_pool, "listing", lambda: listed)
    monkeypatch.setattr(prebuilt, "choice", lambda: HERE)
    monkeypatch.delenv("NUMBA_DISABLE_JIT", raising=False)
    log, kept = tmp_path / "log", tmp_path / "kept" / "contiga"
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(kept.parent))
    for folder in (log, kept):
        folder.mkdir(parents=True)
    for k in range(len(PARTS)):
        (kept / f"{k}.nbi").touch()

    start = compile_pool._start_process

    def started(environment: Mapping[str, str]) -> Any:
        process = start(environment)
        (log / str(process.pid)).touch()
        return process

    monkeypatch.setattr(compile_pool, "_start_process", started)

    def put(made: bool = True, failing: int = -1, lost: int = -1) -> Path:
        text = STUB.format(kept=str(kept), made=made, failing=failing, lost=lost)
        monkeypatch.setattr(compile_pool, "_BOOT", text)
        return log

    return put


def test_it_says_what_was_compiled_and_where_it_is(command: Command, stub: Any) -> None:
    log = stub()
    code, out, err = command("warmup", "--jobs", "3")
    assert code == 0
    first, out = out.split("\n", 1)
    assert first == HERE.text
    assert out.startswith(f"{len(PARTS) - 1} kernels compiled, 1 were there already; ")
    assert out.endswith(f"s; kept in {log.parent / 'kept' / 'contiga'}\n")
    assert f"{len(PARTS)}/{len(PARTS)}" in err
    assert len(list(log.iterdir())) == 3


def test_a_second_time_there_is_nothing_to_compile(command: Command, stub: Any) -> None:
    stub(made=False)
    code, out, _ = command("warmup", "--jobs", "1")
    assert code == 0
    assert f"\nnothing to compile: {len(PARTS)} kernels were there already; " in out


def test_what_was_warmed_up_is_not_gone_through_again(command: Command, stub: Any) -> None:
    log = stub()
    command("warmup", "--jobs", "2")
    processes = len(list(log.iterdir()))
    code, out, _ = command("warmup")
    assert code == 0
    assert f"\nnothing to compile: {len(PARTS)} kernels were there already; " in out
    assert out.endswith(f"s; kept in {log.parent / 'kept' / 'contiga'}\n")
    assert len(list(log.iterdir())) == processes
    (log.parent / "kept" / "contiga" / "3.nbi").unlink()
    command("warmup", "--jobs", "2")
    assert len(list(log.iterdir())) > processes


@pytest.mark.parametrize("text", ["", "[]", "{}", "[1]", "\x00", '["nowhere"]'])
def test_a_record_that_cannot_be_read_is_none(
    text: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(record, "_record_path", lambda: tmp_path / "record")
    (tmp_path / "record").write_text(text, encoding="utf-8")
    assert not record.has_all()
    monkeypatch.setattr(record, "_record_path", lambda: tmp_path / "nowhere" / "record")
    record.write([str(tmp_path)])
    assert not record.has_all()


def test_a_record_is_of_these_sources_this_python_and_this_processor(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(record, "kernel_folder", lambda: tmp_path)
    (tmp_path / "a.nbi").touch()
    record.write([str(tmp_path / "a.nbi")])
    assert record.has_all()
    with monkeypatch.context() as patch:
        patch.setattr(sys.implementation, "cache_tag", "another")
        assert not record.has_all()
    other = tmp_path / "contiga"
    (other / "sub").mkdir(parents=True)
    monkeypatch.setattr(record, "PACKAGE", other)
    assert not record.has_all()
    record.write([str(tmp_path / "a.nbi")])
    assert record.has_all()
    (other / "sub" / "new.py").touch()
    assert not record.has_all()


def test_kernels_are_removed_and_none_is_compiled(command: Command, stub: Any) -> None:
    log = stub()
    folder = log.parent / "kept" / "contiga"
    (folder / "warmup-1.json").touch()
    code, out, _ = command("warmup", "--clear")
    assert (code, out) == (0, f"{len(PARTS)} kernels removed from {folder}\n")
    assert not list(folder.iterdir())
    assert not list(log.iterdir())
    assert command("warmup", "--clear", "--quiet")[:2] == (0, "")


def test_where_kernels_are_installed_there_is_nothing_to_compile(
    command: Command, stub: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    log = stub()
    installed = Choice(object(), "kernels are those of the test")  # type: ignore[arg-type]
    monkeypatch.setattr(prebuilt, "choice", lambda: installed)
    said = "nothing to compile: kernels are those of the test\n"
    assert command("warmup") == (0, said, "")
    assert not list(log.iterdir())
    assert command("warmup", "--quiet") == (0, "", "")
    assert "kernels removed from" in command("warmup", "--clear")[1]


def test_kernels_are_compiled_for_each_level_and_packed(
    command: Command, stub: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    log = stub(made=True)
    environments: list[Mapping[str, str]] = []
    monkeypatch.setattr(pack, "levels", lambda: pack.X86)
    start = compile_pool._start_process

    def started(environment: Mapping[str, str]) -> Any:
        environments.append(environment)
        return start(environment)

    def written(kept: Mapping[pack.Level, Mapping[int, str]], _: object, folder: Path) -> Path:
        assert tuple(kept) == pack.X86
        assert all(sorted(files) == list(range(len(PARTS))) for files in kept.values())
        assert Path(environments[0]["NUMBA_CACHE_DIR"]).parent.is_dir()
        return folder / "contiga_kernels.whl"

    monkeypatch.setattr(compile_pool, "_start_process", started)
    monkeypatch.setattr(pack, "write_wheel", written)
    code, out, _ = command("warmup", "--pack", tmp_path / "dist", "--jobs", "2")
    wheel = tmp_path / "dist" / "contiga_kernels.whl"
    said = f"{len(PARTS)} kernels for x86-64-v3 and x86-64-v4 in {wheel}\n"
    assert (code, out) == (0, said)
    assert len(list(log.iterdir())) == 2 * len(pack.X86)
    names = [environment["NUMBA_CPU_NAME"] for environment in environments]
    assert names == ["x86-64-v3", "x86-64-v3", "x86-64-v4", "x86-64-v4"]
    assert not Path(environments[0]["NUMBA_CACHE_DIR"]).parent.exists()


@pytest.mark.parametrize("how", [{"failing": 2}, {"lost": 2}])
def test_no_wheel_is_written_of_kernels_that_cannot_be_compiled(
    command: Command, stub: Any, how: dict[str, int], tmp_path: Path
) -> None:
    stub(**how)
    code, out, err = command("warmup", "--pack", tmp_path / "dist", "--jobs", "2", "--quiet")
    assert (code, out) == (1, "")
    assert "kernels could not be compiled (contiga.rooms_nb.k2" in one_message(err)
    assert not list((tmp_path / "dist").iterdir())


def test_a_folder_that_cannot_be_made_is_named_before_anything_is_compiled(
    command: Command, stub: Any, tmp_path: Path
) -> None:
    log = stub()
    (tmp_path / "file").touch()
    folder = tmp_path / "file" / "dist"
    code, _, err = command("warmup", "--pack", folder, "--jobs", "1", "--quiet")
    assert code == 1
    assert f"no wheel can be written to {folder} (" in one_message(err)
    assert not list(log.iterdir())


def test_without_a_folder_that_can_be_written_to_it_says_so(
    command: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(prebuilt, "choice", lambda: HERE)
    monkeypatch.setattr("contiga.jit.folder.kernel_folder", lambda: None)
    code, out, err = command("warmup")
    assert (code, out) == (1, "")
    assert "NUMBA_CACHE_DIR" in one_message(err)


@pytest.mark.parametrize(
    ("how", "said"),
    [
        ({"failing": 2}, "contiga.rooms_nb.k2: ValueError: of the stub"),
        ({"lost": 2}, "contiga.rooms_nb.k2: its process ended with code 7"),
    ],
)
def test_one_message_says_what_failed_and_the_others_go_on(
    command: Command, stub: Any, how: dict[str, int], said: str
) -> None:
    log = stub(**how)
    code, out, err = command("warmup", "--jobs", "2", "--quiet")
    assert (code, out) == (1, "")
    assert said in one_message(err)
    assert not list((log.parent / "kept").rglob("*.json"))
    assert err.count(": ") == 3 + ("failing" in how)


def test_a_process_that_is_lost_leaves_the_rest_to_the_others(stub: Any) -> None:
    stub(lost=0)
    told: list[compile_pool.Progress] = []
    with compile_pool.CompilePool(2, lambda _, said: told.append(said)) as team:
        team.wait()
    assert sorted(said.row for said in told if said.done) == list(range(len(PARTS)))
    assert [said.row for said in told if said.error] == [0]


def test_without_a_compiler_there_is_nothing_to_do(
    command: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("NUMBA_DISABLE_JIT", "1")
    assert command("warmup") == (0, "nothing to compile: NUMBA_DISABLE_JIT is set\n", "")


class Event:
    """numba's own part: who listens, and what is heard."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        from numba.core import event

        self.listeners: list[Any] = []
        monkeypatch.setattr(event, "register", lambda _, who: self.listeners.append(who))
        monkeypatch.setattr(event, "unregister", lambda _, who: self.listeners.remove(who))

    def compiled(self, times: int) -> None:
        for listener in self.listeners:
            for _ in range(times):
                listener.on_start(None)
                listener.on_end(None)


def command_context(monkeypatch: pytest.MonkeyPatch, threads: int) -> typer.Context:
    """Of a command on a terminal, with so many threads."""
    monkeypatch.setattr("contiga.arrays.threads.thread_count", lambda: threads)
    monkeypatch.setattr(sys, "argv", ["contiga"])
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    return typer.Context(typer.main.get_command(commands.app))


@pytest.mark.parametrize("first", [True, False])
def test_others_help_a_run_that_has_much_to_compile(
    first: bool, stub: Any, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    started: list[compile_pool.CompilePool] = []
    monkeypatch.setattr(compiling, "_is_first", lambda: first)
    own = compile_pool.CompilePool.__init__
    monkeypatch.setattr(
        compile_pool.CompilePool,
        "__init__",
        lambda self, *given: (started.append(self), own(self, *given))[1],
    )
    stub()
    context, heard = command_context(monkeypatch, 3), Event(monkeypatch)
    compiling.watch_compiling(context, helped=True)
    assert len(started) == first  # at once
    heard.compiled(compiling.MIN_KERNELS - 1)
    assert len(started) == first
    heard.compiled(compiling.MIN_KERNELS)
    (team,) = started
    assert len(team._processes) == 2
    context.close()
    assert all(process.poll() is not None for process in team._processes)
    assert not heard.listeners
    assert capsys.readouterr().err.count("compiling kernels on 3 cores") == 1
    assert not COMPILE_LISTENERS


def test_while_kernels_are_compiled_it_is_said_how_many_are_left(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(compiling, "PAUSE", 0.0)
    messages = compiling.Messages(2, tell=True)
    kernel = listing().kernels[3]
    version = kernel.module, kernel.name, listing().arguments(3)
    messages.before(*version)
    messages.after(*version)
    messages.after("contiga.elsewhere", "unlisted", ())
    messages.hear(0, compile_pool.Progress(5))
    messages.hear(0, compile_pool.Progress(5, done=True))
    most = len(listing().kernels)
    assert capsys.readouterr().err.splitlines() == [
        f"compiling kernels on 2 cores, once for all projects of this user: at most {most} left",
        f"compiling kernels: at most {most - 1} left",
        f"compiling kernels: at most {most - 1} left",
        f"compiling kernels: at most {most - 2} left",
    ]


def test_between_two_messages_there_is_time_and_others_hear_none(
    capsys: pytest.CaptureFixture[str],
) -> None:
    for tell in (True, False):
        messages = compiling.Messages(1, tell)
        for row in range(20):
            messages.hear(0, compile_pool.Progress(row, done=True))
        assert len(capsys.readouterr().err.splitlines()) == tell


def test_it_is_said_why_installed_kernels_are_not_used(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    refused = Choice(None, "contiga_kernels is not used: its files are damaged", refused=True)
    monkeypatch.setattr(prebuilt, "choice", lambda: refused)
    compiling.Messages(1, tell=True)
    first, *_ = capsys.readouterr().err.splitlines()
    assert first == refused.text


@pytest.mark.parametrize(("helped", "threads"), [(True, 1), (False, 4)])
def test_nobody_helps_where_that_is_no_use(
    helped: bool, threads: int, stub: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    log = stub()
    context, heard = command_context(monkeypatch, threads), Event(monkeypatch)
    compiling.watch_compiling(context, helped=helped)
    heard.compiled(2 * compiling.MIN_KERNELS)
    context.close()
    assert not list(log.iterdir())


@pytest.mark.parametrize("name", WITH_CASE)
def test_commands_with_a_case_are_helped(
    command: Command, case: Path, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[bool] = []
    monkeypatch.setattr(
        "contiga.cli.options.watch_compiling", lambda _, helped: asked.append(helped)
    )
    monkeypatch.setattr("contiga.case.schema.load_case", lambda *_, **__: 1 // 0)
    command(name, case, *(("-o", case.with_suffix(".png")) if name == "preview" else ()))
    assert asked == [True]


@pytest.mark.parametrize("name", HELPED)
def test_commands_that_run_their_own_cases_are_helped(
    command: Command, name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[bool] = []
    for home in ("commands", "verify"):
        monkeypatch.setattr(
            f"contiga.cli.{home}.watch_compiling", lambda _, helped=False: asked.append(helped)
        )
    command(name, "--only", "nothing-of-that-name", "-o", tmp_path / "out")
    assert asked == [True]


def test_nobody_is_called_for_a_case_that_is_not_there(
    command: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[bool] = []
    monkeypatch.setattr(
        "contiga.cli.options.watch_compiling", lambda _, helped: asked.append(helped)
    )
    command("run", tmp_path / "none.toml")
    assert asked == [False]
