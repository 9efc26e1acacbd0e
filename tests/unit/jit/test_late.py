"""Lazy kernels are compiled when they are first called, by whoever calls them first."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest
from numba import njit, types
from numba.core.errors import TypingError

from contiga.jit import inner, kernel, lazy
from contiga.jit import late as lazy_module
from contiga.jit.late import compile_all

WAIT = 120.0
"""Seconds after which threads wait for each other."""
TINY = {
    "inmost": "@lazy(types.float64)\ndef inmost(x, rows):\n    return {1} * x * rows[0]['one']\n",
    "rare": "from tiny.inmost import inmost\n\n@lazy(types.float64)\ndef rare(x, rows):\n"
    "    if x > 5.0:\n        raise ValueError('above five')\n"
    "    return x if x < 3.0 else inmost(x, rows)\n",
    "between": "from tiny.rare import rare\n\n@inner()\ndef between(x, rows):\n"
    "    return rare(x, rows) if x > 1.0 else 0.0\n",
    "outer": "from tiny.between import between\n\n@kernel()\ndef outer(x, rows):\n"
    "    return between(x, rows){0}\n",
}
RUN = """
import sys
from pathlib import Path

import numba
import numpy as np

folder = Path(sys.argv[1])
sys.path.insert(0, str(folder))
from contiga.jit import lazy as _
from contiga.jit import late as lazy_module
from contiga.jit.late import compile_all
from contiga.jit.stamps import PACKAGES

PACKAGES.append(folder / "tiny")
from tiny.outer import outer
from tiny.rare import rare
from tiny.inmost import inmost

for x in sys.argv[2:]:
    if x == "all":
        compile_all()
    elif x == "type":
        numba.typeof(np.ones(1, [("another", float)]))
    else:
        try:
            print(outer(float(x), np.ones(1, [("one", float)])), end=" ")
        except ValueError as error:
            print(error, end=" ")
print(*(f"{len(k.overloads)}/{sum(k.stats.cache_hits.values())}" for k in (outer, rare, inmost)))
"""


@pytest.fixture(autouse=True)
def _apart(monkeypatch: pytest.MonkeyPatch) -> None:
    """What a test makes, which may be wrong, is not known to the others."""
    monkeypatch.setattr(lazy_module, "SLOTS", {})


@pytest.fixture
def tiny(tmp_path: Path) -> Callable[..., str]:
    """Writes a package of kernels and says what a new process prints: what `outer` gives for
    numbers, and of three kernels how many versions there are in the end, and how many were kept."""
    folder = tmp_path / "tiny"
    folder.mkdir()
    (folder / "__init__.py").touch()
    head = "from numba import types\n\nfrom contiga.jit import inner, kernel, lazy\n"

    def said(*numbers: str, ending: str = "", factor: str = "2.0") -> str:
        for name, text in TINY.items():
            text = head + text.replace("{0}", ending).replace("{1}", factor)
            (folder / f"{name}.py").write_text(text)
        # Python's own cache would miss a file changed within a second.
        run = [sys.executable, "-B", "-c", RUN, str(tmp_path), *numbers]
        return subprocess.run(run, capture_output=True, text=True, check=True).stdout.strip()

    return said


def doubled(returns: Any = types.float64, by: float = 2.0) -> tuple[Any, Any]:
    """A lazy kernel, and one that calls it for numbers above one."""

    @lazy(returns)
    def rare(x):
        return by * x

    @kernel()
    def outer(x):
        return rare(x) if x > 1.0 else x

    return rare, outer


def test_it_is_compiled_when_it_is_first_called() -> None:
    rare, outer = doubled()
    assert outer(0.5) == 0.5
    assert not rare.overloads
    assert outer(3.0) == 6.0
    assert len(rare.overloads) == 1


def test_kernels_of_one_name_are_told_apart() -> None:
    (_, first), (_, second) = doubled(by=2.0), doubled(by=5.0)
    assert first(3.0) == 6.0
    assert second(3.0) == 15.0


def test_all_callers_find_an_address_that_one_has_asked_for(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked: list[str] = []

    def address_of(name: str) -> int:
        asked.append(name)
        return own(name)

    own = lazy_module.address_of
    monkeypatch.setattr(lazy_module, "address_of", address_of)
    rare, outer = doubled()

    @kernel()
    def another(x, y):
        return rare(x) + rare(y)

    assert outer(3.0) == 6.0
    assert outer(4.0) == 8.0
    assert another(1.0, 2.0) == 6.0
    assert len(asked) == 1


def test_integers_are_one_version_and_arguments_may_be_named() -> None:
    @lazy(types.int64)
    def sum_of(a, b, c=3):
        return a + 10 * b + 100 * c

    @kernel()
    def outer(x):
        return sum_of(x, 2), sum_of(1, c=x, b=x), sum_of(1, 2, 3)

    assert outer(5) == (325, 551, 321)
    assert len(sum_of.overloads) == 2  # with the constant of the default, and without


@pytest.mark.parametrize("nogil", [True, False])
def test_threads_that_come_to_it_at_once_have_one_version(
    nogil: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    both = threading.Barrier(2)

    def address_of(name: str) -> int:
        both.wait(WAIT)
        return own(name)

    own = lazy_module.address_of
    monkeypatch.setattr(lazy_module, "address_of", address_of)
    rare, _ = doubled()

    @njit(nogil=nogil)
    def outer(x):
        return rare(x) + 1.0

    outer.compile((types.float64,))
    with ThreadPoolExecutor(2) as pool:
        jobs = [pool.submit(outer, x) for x in (3.0, 4.0)]
        assert [job.result(WAIT) for job in jobs] == [7.0, 9.0]
    assert sum(rare.stats.cache_misses.values()) + sum(rare.stats.cache_hits.values()) == 1


def test_one_that_cannot_be_compiled_is_an_exception_of_its_caller() -> None:
    @lazy(types.float64)
    def wrong(x):
        return x.nothing

    @inner()
    def between(x):
        return wrong(x) if x > 1.0 else x

    @kernel()
    def outer(x):
        return between(x) + 1.0

    assert outer(0.5) == 1.5
    with ThreadPoolExecutor(1) as pool:
        for _ in range(2):
            with pytest.raises(TypingError, match="nothing"):
                outer(2.0)
            with pytest.raises(TypingError, match="nothing"):
                pool.submit(outer, 2.0).result(WAIT)
    assert outer(0.5) == 1.5


def test_an_answer_that_is_not_as_declared_is_refused() -> None:
    _, outer = doubled(types.int64)
    assert outer(0.5) == 0.5
    with pytest.raises(TypeError, match="rare answers float64, not int64"):
        outer(2.0)


def test_what_ends_a_program_ends_it(monkeypatch: pytest.MonkeyPatch) -> None:
    def address_of(name: str) -> int:
        raise KeyboardInterrupt

    _, outer = doubled()
    with monkeypatch.context() as patched:
        patched.setattr(lazy_module, "address_of", address_of)
        with pytest.raises(KeyboardInterrupt):
            outer(2.0)
    assert outer(2.0) == 4.0


def test_what_is_waiting_is_compiled_and_what_that_may_call() -> None:
    inmost, _ = doubled()

    @lazy(types.float64)
    def rare(x):
        return inmost(x) + 1.0

    @kernel()
    def outer(x):
        return rare(x) if x > 1.0 else x

    assert outer(0.5) == 0.5
    compile_all()
    assert len(rare.overloads) == len(inmost.overloads) == 1


def test_another_process_reads_what_is_kept_and_no_more(
    tiny: Callable[..., str], tmp_path: Path
) -> None:
    kept = lambda name: list(tmp_path.rglob(f"{name}.{name}-*.nbc"))  # noqa: E731
    assert tiny("0") == "0.0 1/0 0/0 0/0"
    assert not kept("rare")
    assert tiny("0", "2") == "0.0 2.0 1/1 1/0 0/0"
    assert not kept("inmost")
    assert tiny("2", "4", "6") == "2.0 8.0 above five 1/1 1/1 1/0"
    assert tiny("4") == "8.0 1/1 1/1 1/1"
    kept("rare")[0].unlink()
    assert tiny("4") == "8.0 1/1 1/0 1/1"


def test_to_a_process_that_has_met_other_records_it_is_the_same(tiny: Callable[..., str]) -> None:
    tiny("4")
    assert tiny("type", "4") == "8.0 1/1 1/1 1/1"


def test_a_new_caller_of_kept_kernels_finds_them(tiny: Callable[..., str]) -> None:
    tiny("4")
    assert tiny("4", ending=" + 1.0") == "9.0 1/0 1/1 1/1"


def test_a_changed_source_is_seen(tiny: Callable[..., str]) -> None:
    assert tiny("2", "4") == "2.0 8.0 1/0 1/0 1/0"
    assert tiny("2", "4", factor="5.0") == "2.0 20.0 1/0 1/0 1/0"


def test_what_a_kept_caller_may_call_is_compiled_ahead(tiny: Callable[..., str]) -> None:
    tiny("0")
    assert tiny("0", "all") == "0.0 1/1 1/0 1/0"
    assert tiny("4") == "8.0 1/1 1/1 1/1"


def test_without_a_compiler_they_are_plain_functions() -> None:
    code = (
        "from numba import types; from contiga.jit import lazy\n"
        "def own(x):\n    return x\n"
        "print(lazy(types.float64)(own) is own)"
    )
    env = os.environ | {"NUMBA_DISABLE_JIT": "1"}
    run = [sys.executable, "-c", code]
    assert subprocess.run(run, capture_output=True, text=True, env=env).stdout == "True\n"
