"""Which tests are long, by the processor time they take: `python -m tests.durations [TEST …]`.

`durations.json` lists the tests that take `LONG` yardsticks and more. They are marked `long`, and
`make test` leaves them to `make check`. The command measures anew what it is told to, everything
by default, and writes the list.

A yardstick is the processor time of a fixed piece of Python in the run at hand, so that the list
holds for machines of any speed, and for busy ones. Time in which kernels are compiled does not
count: it is spent once. What a fixture of a whole module, or of more, takes counts for each test
that uses it, whichever was the first.

A test that is not listed fails where its own process takes `GROWN` yardsticks. That is ten times
`LONG`: the first tests of a process load packages and kernels for all others.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections import defaultdict
from collections.abc import Generator
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import pytest
from numba import config
from numba.core import event

ROOT = Path(__file__).resolve().parents[1]
TABLE = Path(__file__).with_name("durations.json")
LONG = 60
"""Yardsticks: some half a second."""
GROWN = 10 * LONG
MEASURED = "CONTIGA_TEST_DURATIONS"
"""Environment variable: the file to which a run appends what each test took."""


@cache
def listed() -> dict[str, float]:
    """Long tests and the yardsticks that each takes."""
    table = json.loads(TABLE.read_text(encoding="utf-8"))
    return {f"{file}::{test}": n for file, tests in table.items() for test, n in tests.items()}


def yardstick() -> float:
    """Processor time of a fixed piece of work, s: the least of several."""

    def once() -> float:
        begun, total = time.process_time(), 0
        for k in range(200_000):
            total += k * k % 7
        return time.process_time() - begun

    return min(once() for _ in range(5))


class Spent(NamedTuple):
    """Processor time since the start of this process, s."""

    own: float
    """All threads, without what was spent compiling."""
    children: float
    """Of processes that this one has started and seen end."""

    def since(self, begun: Spent) -> Spent:
        """The difference."""
        return Spent(self.own - begun.own, self.children - begun.children)

    @property
    def total(self) -> float:
        """Of both."""
        return self.own + self.children


class Compiling(event.Listener):  # type: ignore[misc]
    """Adds up the processor time of threads while they compile."""

    def __init__(self) -> None:
        self.seconds = 0.0
        self._begun: list[float] = []

    def on_start(self, event: Any) -> None:
        """Compiling a function begins; numba lets one thread compile at a time."""
        self._begun.append(time.thread_time())

    def on_end(self, event: Any) -> None:
        """It ends. What it had compiled in turn is a part of it."""
        begun = self._begun.pop()
        if not self._begun:
            self.seconds += time.thread_time() - begun


class Durations:
    """A pytest plugin that marks long tests, measures all, and fails those that have grown long."""

    def __init__(self) -> None:
        self._yardstick = yardstick()
        self._compiling = Compiling()
        event.register("numba:compile", self._compiling)
        self._of_fixtures: dict[Any, Spent] = {}
        self._in_fixtures = 0.0
        """Seconds in fixtures of more than the test that runs."""

    def spent(self) -> Spent:
        """Until now."""
        times = os.times()
        own = time.process_time() - self._compiling.seconds
        return Spent(own, times.children_user + times.children_system)

    @pytest.hookimpl(tryfirst=True)  # before -m selects
    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        """Mark what is listed."""
        for item in items:
            if item.nodeid in listed():
                item.add_marker(pytest.mark.long)

    @pytest.hookimpl(wrapper=True)
    def pytest_fixture_setup(self, fixturedef: Any) -> Generator[None, Any, Any]:
        """Measure fixtures that several tests share."""
        if fixturedef.scope == "function":
            return (yield)
        begun, inner = self.spent(), self._in_fixtures
        try:
            return (yield)
        finally:
            spent = self.spent().since(begun)
            self._of_fixtures[fixturedef] = spent
            self._in_fixtures = inner + spent.total

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Generator[None, Any, Any]:
        """Measure a test from its fixtures to their end."""
        self._in_fixtures = 0.0
        begun = self.spent()
        result = yield
        if MEASURED in os.environ:
            spent = self.spent().since(begun).total - self._in_fixtures + self._shared(item)
            with open(os.environ[MEASURED], "a", encoding="utf-8") as file:
                file.write(json.dumps([item.nodeid, spent / self._yardstick]) + "\n")
        return result

    def _shared(self, item: pytest.Item) -> float:
        """Seconds that the fixtures took which a test shares with others."""
        found = getattr(item, "_fixtureinfo", None)
        used = [] if found is None else [f for fs in found.name2fixturedefs.values() for f in fs]
        return sum(self._of_fixtures[one].total for one in used if one in self._of_fixtures)

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_call(self, item: pytest.Item) -> Generator[None, Any, Any]:
        """Fail a test that is not listed and is long."""
        begun = self.spent()
        result = yield
        if item.get_closest_marker("long") or item.get_closest_marker("full") or _is_slowed():
            return result
        # A process that ends may have worked for other tests, and compiled: it is not judged.
        seconds = self.spent().since(begun).own
        if seconds > GROWN * self._yardstick and seconds > GROWN * yardstick():
            taken = round(seconds / self._yardstick)
            pytest.fail(
                f"takes {taken} yardsticks of processor time; allowed in `make test`: {GROWN}. "
                f"Make it cheaper, or list it by python -m tests.durations {item.nodeid}"
            )
        return result


def _is_slowed() -> bool:
    """Whether kernels are not compiled, or somebody watches every line."""
    return bool(config.DISABLE_JIT or sys.gettrace())


def main(tests: list[str]) -> int:
    """Run tests, and write which of them are long."""
    with TemporaryDirectory() as folder:
        measured = Path(folder) / "durations"
        run = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-n", "2"]
        environment = os.environ | {MEASURED: str(measured), "NUMBA_NUM_THREADS": "2"}
        done = subprocess.run([*run, "--dist", "loadfile", *tests], cwd=ROOT, env=environment)
        lines = measured.read_text(encoding="utf-8").splitlines()
    taken = dict(map(json.loads, lines))
    known = {test: n for test, n in listed().items() if tests and test not in taken}
    TABLE.write_text(text(known | taken), encoding="utf-8")
    return done.returncode


def text(taken: dict[str, float]) -> str:
    """The list as it is kept: a file, its long tests and the yardsticks that each takes."""
    table: dict[str, dict[str, int]] = defaultdict(dict)
    for nodeid, n in sorted(taken.items()):
        if n >= LONG:
            file, test = nodeid.split("::", 1)
            table[file][test] = round(n)
    return json.dumps(table, indent=1, ensure_ascii=False) + "\n"


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
