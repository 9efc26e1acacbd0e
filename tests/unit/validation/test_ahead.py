"""The process that compiles ahead: when it is started, and that nothing hangs on it."""

from __future__ import annotations

import subprocess

import pytest

from contiga_validation import ahead
from contiga_validation.catalogue import experiments
from contiga_validation.engine.experiment import Experiment

from .conftest import FAILING, GOOD


class _Process:
    """Records how it was started and that it was ended."""

    def __init__(self, command: list[str], **_: object) -> None:
        self.command, self.done = command, []

    def wait(self) -> None:
        self.done.append("wait")

    def kill(self) -> None:
        self.done.append("kill")


@pytest.fixture
def started(monkeypatch: pytest.MonkeyPatch) -> list[_Process]:
    values: list[_Process] = []

    def start(command: list[str], **options: object) -> _Process:
        values.append(_Process(command, **options))
        return values[-1]

    monkeypatch.setattr(subprocess, "Popen", start)
    monkeypatch.setattr(ahead, "thread_count", lambda: 2)
    return values


def test_a_process_is_started_for_many_experiments_and_never_left_behind(
    started: list[_Process],
) -> None:
    def break_off() -> None:
        with ahead.compiling_ahead([GOOD] * ahead.MIN_EXPERIMENTS) as wait:
            wait()
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        break_off()
    (process,) = started
    assert process.done == ["wait", "kill", "wait"]


def test_few_experiments_or_one_core_start_none(
    started: list[_Process], monkeypatch: pytest.MonkeyPatch
) -> None:
    with ahead.compiling_ahead([GOOD] * (ahead.MIN_EXPERIMENTS - 1)) as wait:
        wait()
    monkeypatch.setattr(ahead, "thread_count", lambda: 1)
    with ahead.compiling_ahead([GOOD] * ahead.MIN_EXPERIMENTS) as wait:
        wait()
    assert started == []


def test_what_is_run_ahead_is_in_the_catalogue_and_not_what_is_timed() -> None:
    known = {experiment.key: experiment for experiment in experiments()}
    for key in ahead.AHEAD_KEYS:
        assert key == "meshes" or known[key].chapter < ahead.FIRST_TIMED_CHAPTER


def test_an_experiment_that_fails_ahead_does_not_stop_the_next(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    ran = []

    def run() -> object:
        ran.append(True)
        return GOOD.run()

    late = Experiment("5.2-late", "Late", "5.2", run)
    monkeypatch.setattr("contiga_validation.catalogue.experiments", lambda *_: (FAILING, late))
    ahead.run_ahead((FAILING.key, "no such", late.key))
    assert ran == [True]
