"""Every exercise can be done, and a process does what it is told and ends with its master."""

from __future__ import annotations

import inspect
import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest

from contiga.warmup import BESIDE, EXERCISES, LAST, exercises
from contiga.warmup.crew import Crew


@pytest.mark.slow
@pytest.mark.parametrize("name", [*EXERCISES, LAST])
def test_an_exercise_can_be_done(name: str) -> None:
    getattr(exercises, name)()


def test_all_are_handed_out() -> None:
    own = [
        name
        for name, found in vars(exercises).items()
        if inspect.isfunction(found) and found.__module__ == exercises.__name__
    ]
    assert sorted([*EXERCISES, LAST]) == sorted(name for name in own if not name.startswith("_"))
    assert {"run", *BESIDE} == set(EXERCISES)


def test_a_process_does_an_exercise_and_says_what_it_took() -> None:
    told: list[dict[str, Any]] = []
    with Crew(["flight", "no such exercise"], 1, lambda _, said: told.append(said)) as crew:
        crew.wait()
    first, second, last = (said for said in told if "done" in said)
    assert first["done"] == "flight"
    assert first["error"] is None
    assert all(Path(folder).is_dir() for folder in first["folders"])
    assert any(file for folder in first["folders"] for file in Path(folder).glob("*.kick-*.nbc"))
    assert second["error"].startswith("AttributeError: ")
    assert (last["done"], last["error"]) == (LAST, None)


def test_processes_end_with_the_one_that_started_them() -> None:
    code = (
        "import os, time; from contiga.warmup.crew import Crew; crew = Crew(['simulations'], 1); "
        "print(crew._processes[0].pid, flush=True); time.sleep(1.0); os._exit(1)"
    )
    run = subprocess.run([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    pid, end = int(run.stdout), time.monotonic() + 60.0
    while time.monotonic() < end:
        try:
            os.kill(pid, 0)
        except ProcessLookupError:
            return
        time.sleep(0.1)
    pytest.fail("it lives on")
