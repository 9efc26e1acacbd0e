"""What a law is made of: numbers, code, constants, slots, and what its code names."""

from __future__ import annotations

import functools
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


def law(text: str = LAW, **slots: float) -> Any:
    module = types.ModuleType("my_law")
    exec(compile(text, "my_law.py", "exec"), vars(module))
    return module.Law(**slots)


def digest(value: object) -> str:
    things = Things()
    things.thing(value)
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
    things.thing([np.sin, np.array([1.0]).sum, cg.PenaltyLaw(2.0), law(), len, functools.reduce])
    assert things.unknown == set()
    things.thing(threading.Lock())
    assert things.unknown == {"_thread.lock"}


def test_recursion_ends() -> None:
    def down(n: int) -> int:
        return 0 if n == 0 else down(n - 1)

    box: list[object] = []
    box.append(box)
    assert digest(down) == digest(down)
    assert digest(box) == digest(box)
