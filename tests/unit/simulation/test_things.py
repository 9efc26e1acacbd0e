"""What a law is made of: numbers, code, constants, slots, and what its code names."""

from __future__ import annotations

import functools
import logging
import threading
import types
from collections.abc import Callable
from typing import Any

import numba
import numpy as np
import pytest

import contiga as cg
from contiga.simulation.things import Things

LAW = """
import functools, math
import numpy as np
import contiga as cg
SCALE = 2.0
TABLE = np.array([1.0, 2.0])
def helper(x):
    return deeper(x) + 1.0
def deeper(x):
    return math.sqrt(2.0) * x
class Base:
    def own(self):
        return 5.0
class Law(Base, cg.PenaltyLaw):
    constant = 3.0
    __slots__ = ("slot",)
    def __init__(self, slot=1.0):
        super().__init__(4.0)
        self.slot = slot
    @property
    def ratio(self): return 6.0
    @staticmethod
    def fixed(): return 7.0
    @classmethod
    def of_class(cls): return 8.0
    @functools.cached_property
    def once(self): return 9.0
    def respond(self, inp):
        inner = lambda x: x * 10.0
        return helper(inp) * SCALE * TABLE[0] * inner(inp) * Law.constant
"""


def law(text: str = LAW, **slots: Any) -> Any:
    module = types.ModuleType("my_law")
    exec(compile(text, "my_law.py", "exec"), vars(module))
    return module.Law(**slots)


def digest(value: object) -> str:
    things = Things()
    things.add_value(value)
    return things.hexdigest()


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("constant = 3.0", "constant = 3.5"),
        ("return 5.0", "return 5.5"),
        ("return 6.0", "return 6.5"),
        ("return 7.0", "return 7.5"),
        ("return 8.0", "return 8.5"),
        ("return 9.0", "return 9.5"),
        ("x * 10.0", "x * 10.5"),
        ("x * 10.0", "x + 10.0"),
        ("SCALE = 2.0", "SCALE = 2.5"),
        ("array([1.0, 2.0])", "array([1.0, 2.5])"),
        ("deeper(x) + 1.0", "deeper(x) + 1.5"),
        ("math.sqrt(2.0)", "math.sqrt(2.5)"),
        ("math.sqrt", "math.exp"),
        ("__init__(4.0)", "__init__(4.5)"),
        ("slot=1.0", "slot=1.5"),
    ],
)
def test_whatever_has_changed_in_a_law_tells(old: str, new: str) -> None:
    assert old in LAW
    assert digest(law()) == digest(law())
    assert digest(law()) != digest(law(LAW.replace(old, new)))


def test_slots_tell() -> None:
    assert digest(law(slot=2.0)) == digest(law(slot=2.0)) != digest(law(slot=3.0))


def test_what_was_asked_for_in_between_does_not_tell() -> None:
    used, unused = law(), law()
    assert used.once == 9.0
    assert digest(used) == digest(unused)


def test_what_code_names_is_never_called() -> None:
    calls: list[object] = []
    text = LAW.replace("SCALE = 2.0", "def SCALE(x):\n    calls.append(x)")
    module = types.ModuleType("my_law")
    vars(module)["calls"] = calls
    exec(compile(text, "my_law.py", "exec"), vars(module))
    digest(module.Law())
    assert calls == []


def test_what_changes_by_itself_in_a_module_does_not_tell() -> None:
    """A logger holds all of the process; counters and caches of other kinds than plain ones."""
    kinds = {
        "logging.getLogger('mine')": lambda x: logging.getLogger(f"other {id(x)}").setLevel(10),
        "[logging.getLogger('mine')]": lambda x: x[0].addHandler(logging.NullHandler()),
        "collections.Counter()": lambda x: x.update("a"),
        "itertools.count()": next,
        "np.random.default_rng(1)": lambda x: x.random(),
        "threading.Lock()": lambda x: x.acquire(),
    }
    for made, change in kinds.items():
        text = LAW.replace("import functools", "import collections, itertools, logging, threading")
        one = law(text.replace("SCALE = 2.0", f"import functools\nSCALE = {made}"))
        before = digest(one)
        change(one.respond.__globals__["SCALE"])
        assert digest(one) == before, made


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("[1.0]", "[2.0]"),
        ("{'a': {1: (2.0,)}}", "{'a': {1: (3.0,)}}"),
        ("Fraction(1, 2)", "Fraction(1, 3)"),
        ("range(2)", "range(3)"),
        ("cg.PenaltyLaw(1.0)", "cg.PenaltyLaw(2.0)"),
        ("functools.partial(deeper, 1.0)", "functools.partial(deeper, 2.0)"),
        ("CubicSpline([0, 1], [0, 1])", "CubicSpline([0, 1], [0, 2])"),
    ],
)
def test_data_and_code_in_a_module_tell(old: str, new: str) -> None:
    head = "from fractions import Fraction\nfrom scipy.interpolate import CubicSpline\n"
    text = head + LAW.replace("class Base", "SCALE = None\nclass Base")
    first, second = (law(text.replace("SCALE = None", f"SCALE = {one}")) for one in (old, new))
    assert digest(first) != digest(second)


def test_a_logger_of_a_law_tells_by_its_name() -> None:
    one = law(slot=logging.getLogger("mine"))
    before = digest(one)
    logging.getLogger(f"other {id(one)}").addHandler(logging.NullHandler())
    one.slot.setLevel(logging.DEBUG)
    assert digest(one) == before != digest(law(slot=logging.getLogger("yours")))


@pytest.mark.parametrize("first", ["helper", "step30"])
def test_what_is_many_calls_away_tells_in_whatever_order(first: str) -> None:
    steps = "".join(f"def step{k}(x):\n    return step{k + 1}(x)\n" for k in range(40))
    text = LAW.replace("def helper", f"{steps}def step40(x):\n    return 3.0\ndef helper")
    text = text.replace("return helper(inp)", f"return {first}(inp) + step0(inp)")
    assert digest(law(text)) == digest(law(text)) != digest(law(text.replace("3.0\n", "3.5\n", 1)))


def test_which_of_two_functions_comes_again_tells() -> None:
    one, other = (eval(f"lambda x: x * {k}", {}) for k in (1.0, 2.0))
    assert digest([one, other, one]) != digest([one, other, other])


def _times(factor: float) -> Callable[[float], float]:
    @numba.njit
    def kernel(x: float) -> float:
        return factor * x

    return kernel


def _plus(x: float, y: float) -> float:
    return x + y


@pytest.mark.parametrize(
    "make",
    [
        _times,
        lambda factor: functools.partial(_plus, factor),
        lambda factor: [np.float32(factor)],
        lambda factor: {"a": (factor,)},
        lambda factor: np.random.default_rng(int(2 * factor)),
    ],
)
def test_what_is_compiled_or_bound_tells_by_what_it_was_made_of(make: Callable[..., Any]) -> None:
    assert digest(make(2.0)) == digest(make(2.0)) != digest(make(2.5))


def test_what_says_nothing_of_itself_is_unknown() -> None:
    things = Things()
    things.add_value(
        [np.sin, np.array([1.0]).sum, cg.PenaltyLaw(2.0), law(), len, functools.reduce]
    )
    assert things.unknown == set()
    things.add_value(threading.Lock())
    assert things.unknown == {"_thread.lock"}


def test_recursion_ends() -> None:
    def down(n: int) -> int:
        return 0 if n == 0 else down(n - 1)

    box: list[object] = []
    box.append(box)
    assert digest(down) == digest(down)
    assert digest(box) == digest(box)
