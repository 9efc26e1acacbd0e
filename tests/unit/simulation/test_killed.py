"""Runs that are killed go on with the same bits, wherever that was."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from contiga import Simulation
from contiga.dynamics.stepping import GivenTimes
from contiga.simulation.model import OutputOptions

from .sameness import same_history, same_output

Make = Callable[..., Simulation]
pytestmark = [
    pytest.mark.skipif(not hasattr(os, "fork"), reason="the system does not fork"),
    pytest.mark.filterwarnings("ignore:.*multi-threaded.*fork:DeprecationWarning"),
]


def killed(run: Callable[[], object], moment: int) -> bool:
    """Whether a process of its own that is killed at its so many-th change of a file's name, from
    0 on, just before it, dies of that."""
    child = os.fork()
    if child:
        return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) != 0
    own, left = Path.replace, [moment]

    def replace(self: Path, target: Path) -> Path:
        if left[0] == 0:
            os._exit(9)
        left[0] -= 1
        return own(self, target)

    Path.replace = replace  # type: ignore[method-assign,assignment]
    try:
        run()
    finally:
        os._exit(0)


def test_a_run_killed_between_any_two_of_its_files_goes_on(
    make: Make, tmp_path: Path, always: None
) -> None:
    times = make().stepping.planned()[3:6]
    few = make(stepping=GivenTimes(times), output=OutputOptions(every=2))
    whole = few.run(tmp_path / "whole")
    parts, moment = tmp_path / "parts", 0
    while killed(lambda: few.run(parts), moment):
        there = (parts / "checkpoint.h5").is_file() or (parts / "checkpoint.before.h5").is_file()
        resumed = few.run(parts, resume=there)
        same_history(whole.history, resumed.history)
        same_output(tmp_path)
        names = [sorted(path.name for path in (tmp_path / k).iterdir()) for k in ("whole", "parts")]
        assert names[0] == names[1]
        shutil.rmtree(parts)
        moment += 1
    # Frames of fields and outlines, two a checkpoint, and what is written at the end.
    assert moment == 2 + 2 * 4 - 1 + 5


def test_a_run_killed_at_its_end_goes_on_for_longer(make: Make, tmp_path: Path) -> None:
    """Outlines have their final name then, and fields have not."""
    few = make()
    few.run(tmp_path / "parts")
    (tmp_path / "parts" / "fields.vtkhdf").replace(tmp_path / "parts" / "fields.vtkhdf.part")
    times = few.stepping.planned()
    longer = make(stepping=GivenTimes(np.append(times, [13.0, 14.0])))
    longer.run(tmp_path / "parts", resume=True)
    names = {path.name for path in (tmp_path / "parts").iterdir()}
    assert {"fields.vtkhdf", "outlines.vtkhdf"} <= names
    assert not {"fields.vtkhdf.part", "outlines.vtkhdf.part"} & names
