"""Runs that are killed go on with the same bits, wherever that was."""

from __future__ import annotations

import os
import shutil
import signal
import traceback
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


KILLED, FAILED = 9, 1
SECONDS = 120
"""A process that hangs is ended by then."""


def killed(run: Callable[[], object], moment: int) -> bool:
    """Whether a process of its own that is killed at its so many-th change of a file's name, from
    0 on, just before it, dies of that. One that fails by itself, or hangs, is an error."""
    child = os.fork()
    if child:
        code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        assert code in (0, KILLED), f"the run failed by itself, exit code {code}"
        return code == KILLED
    signal.signal(signal.SIGALRM, signal.SIG_DFL)
    signal.alarm(SECONDS)
    own, left, code = Path.replace, [moment], FAILED

    def replace(self: Path, target: Path) -> Path:
        if left[0] == 0:
            os._exit(KILLED)
        left[0] -= 1
        return own(self, target)

    Path.replace = replace  # type: ignore[method-assign,assignment]
    try:
        run()
        code = 0
    except BaseException:
        traceback.print_exc()
    finally:
        os._exit(code)


def test_a_run_that_fails_by_itself_was_not_killed() -> None:
    def fail() -> None:
        raise RuntimeError

    with pytest.raises(AssertionError, match="failed by itself, exit code 1"):
        killed(fail, 99)


def test_a_run_killed_between_any_two_of_its_files_goes_on(
    make: Make, tmp_path: Path, always: None
) -> None:
    times = make().stepping.planned()[3:6]
    few = make(stepping=GivenTimes(times), output=OutputOptions(every=2))
    whole = few.run(tmp_path / "whole")
    parts = tmp_path / "parts"
    # Frames of fields and outlines, two a checkpoint, and what is written at the end.
    changes = 2 + 2 * 4 - 1 + 5
    for moment in range(changes):
        assert killed(lambda: few.run(parts), moment)
        there = (parts / "checkpoint.h5").is_file() or (parts / "checkpoint.before.h5").is_file()
        resumed = few.run(parts, resume=there)
        same_history(whole.history, resumed.history)
        same_output(tmp_path)
        names = [sorted(path.name for path in (tmp_path / k).iterdir()) for k in ("whole", "parts")]
        assert names[0] == names[1]
        shutil.rmtree(parts)
    assert not killed(lambda: few.run(parts), changes)


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
