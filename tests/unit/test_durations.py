"""Long tests are known by their processor time, and a test that has grown long fails."""

from __future__ import annotations

import json
import re
import subprocess
import sys

import pytest
from tests import durations
from tests.durations import LONG, ROOT, TABLE, listed, text

LIMIT, WORK = 20, 100
"""Yardsticks: so far apart that it matters little how busy the machine is."""
PLUGIN = """
import sys
sys.path.insert(0, {root!r})
from tests import durations
durations.GROWN = {limit}
durations.listed = lambda: {{"test_it.py::test_listed": 100.0}}
def pytest_configure(config):
    config.addinivalue_line("markers", "long: listed")
    config.addinivalue_line("markers", "full: not here")
    config.pluginmanager.register(durations.Durations())
"""
TESTS = """
import subprocess
import sys
import numba
import numpy as np
import pytest

def work(yardsticks):
    for _ in range(yardsticks):
        total = 0
        for k in range(200_000):
            total += k * k % 7

def test_quick(): work(1)

def test_grown(): work(WORK)

def test_listed(): work(WORK)

def test_in_a_process():
    code = "for k in range(20_000_000): k * k % 7"
    subprocess.run([sys.executable, "-c", code], check=True)

@pytest.fixture(scope="module")
def shared(): work(WORK)

def test_first_with_it(shared): work(1)

def test_second_with_it(shared): work(1)

@pytest.fixture(scope="module")
def compiler(): numba.njit(lambda x: x + 1)(1)

def test_compiled(compiler):
    for power in range(3):
        numba.njit(lambda x: np.sort(x).sum() + x[power:].std())(np.arange(5.0))
"""


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> tuple[str, dict[str, float]]:
    """What pytest says of the tests above, and what they took."""
    folder = tmp_path_factory.mktemp("tests")
    (folder / "conftest.py").write_text(
        PLUGIN.format(root=str(ROOT), limit=LIMIT), encoding="utf-8"
    )
    (folder / "test_it.py").write_text(TESTS.replace("WORK", str(WORK)), encoding="utf-8")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(durations.MEASURED, str(folder / "measured"))
        options = ["-q", "-rA", "-p", "no:cacheprovider", "-p", "no:hypothesispytest"]
        done = subprocess.run(
            [sys.executable, "-m", "pytest", *options, "--rootdir", str(folder), "test_it.py"],
            cwd=folder,
            capture_output=True,
            text=True,
        )
    lines = (folder / "measured").read_text(encoding="utf-8").splitlines()
    return done.stdout, {name.split("::")[1]: n for name, n in map(json.loads, lines)}


def test_a_test_that_has_grown_fails_and_no_other_does(run: tuple[str, dict[str, float]]) -> None:
    said, _ = run
    failed = re.findall(r"^FAILED test_it.py::(\w+)", said, re.M)
    assert failed == ["test_grown"], said
    assert f"allowed in `make test`: {LIMIT}" in said
    assert len(re.findall(r"^PASSED", said, re.M)) == 6


def test_what_several_tests_share_counts_for_each(run: tuple[str, dict[str, float]]) -> None:
    _, taken = run
    for name in ("test_grown", "test_in_a_process", "test_first_with_it", "test_second_with_it"):
        assert WORK / 2 < taken[name] < 4 * WORK
    assert taken["test_quick"] < LIMIT


def test_the_list_names_tests_that_are_there() -> None:
    for nodeid, n in listed().items():
        file, test = nodeid.split("::", 1)
        assert n >= LONG
        assert f"def {test.partition('[')[0]}(" in (ROOT / file).read_text(encoding="utf-8"), nodeid


def test_the_list_is_written_as_it_is_kept() -> None:
    assert text(listed()) == TABLE.read_text(encoding="utf-8")
    assert text({"b.py::t[a::b]": LONG + 0.2, "a.py::t": 2.0 * LONG, "a.py::quick": LONG - 1}) == (
        f'{{\n "a.py": {{\n  "t": {2 * LONG}\n }},\n "b.py": {{\n  "t[a::b]": {LONG}\n }}\n}}\n'
    )
