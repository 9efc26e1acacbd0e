"""numba, llvmlite and Python's own are for others what they are without this package."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from numba import config

pytestmark = pytest.mark.skipif(config.DISABLE_JIT, reason="nothing is compiled")

ROOT = Path(__file__).resolve().parents[3]
USER = '''
import gc
import os
import sys

import numpy as np
import numba
from numba import njit
from numba.core import event


@njit(inline="always")
def twice(x):
    return x + x


@njit
def moved(table, pair):
    own = np.zeros(3)
    for k in range(table.shape[0]):
        own += twice(table[k, :3]) * pair[0]
        own[1:] = table[k, :2]
    if pair[1] < 0:
        raise ValueError("below zero")
    return own.sum(), own


def compiled():
    """What a user's function becomes, and what numba tells meanwhile."""
    anew = njit(moved.py_func)
    kinds = ("numba:compile", "numba:compiler_lock", "numba:llvm_lock", "numba:run_pass")
    recorders = {kind: event.RecordingListener() for kind in kinds}
    for kind, recorder in recorders.items():
        event.register(kind, recorder)
    anew(np.ones((4, 3)), (2.0, 1))
    for kind, recorder in recorders.items():
        event.unregister(kind, recorder)
    (text,) = anew.inspect_asm().values()
    return text, {kind: len(recorder.buffer) for kind, recorder in recorders.items()}


compiled()  # numba's own beginnings, and what it has as Python, are behind us
'''
EXAMPLE = """
import contiga as cg
from tests.kernels.scenes import puck, sheet

slave = sheet()
law = cg.StressLaw([[0.0, 0.0], [0.3, 2.0]])
contact = cg.Contact(puck(), slave, law=law, area=cg.FacetArea())
state = contact.start(slave.points - np.array([0.0, 0.0, 0.8]))
state = contact.step(state, slave.points - np.array([0.0, 0.0, 0.4]), dt=0.1)
assert np.abs(state.force).max() > 0.0
"""
SNAPSHOT = '''
PACKAGES = ("numba", "llvmlite", "gc", "scipy")


def is_theirs(value):
    return (getattr(value, "__module__", None) or "").partition(".")[0] in PACKAGES


def inside(value):
    """What containers hold is a part of them: they may be changed as well as replaced."""
    if type(value) is dict:
        return [v for pair in value.items() for v in pair]
    return list(value) if type(value) in (list, set) else None


def attributes():
    found = {}
    for name, module in list(sys.modules.items()):
        if name.partition(".")[0] in PACKAGES and module is not None:
            for attribute, value in list(vars(module).items()):
                found[f"{name}.{attribute}"] = value
                if isinstance(value, type) and is_theirs(value):
                    home = f"{value.__module__}.{value.__qualname__}"
                    for own, thing in list(vars(value).items()):
                        found[f"{home}.{own}"] = thing
                    for own in ("__bases__", "__name__", "__qualname__"):
                        found[f"{home}.{own}"] = getattr(value, own)
    return {name: (value, inside(value)) for name, value in found.items()}


def told():
    """Settings that are no attributes."""
    from llvmlite.binding import ffi

    lock = getattr(getattr(ffi, "lib", None), "_lock", None)
    return {
        "gc": (gc.isenabled(), gc.get_threshold(), len(gc.callbacks), gc.get_freeze_count()),
        "llvm lock": [repr(pair) for pair in getattr(lock, "_cblist", ())],
        "listeners": {kind: len(of) for kind, of in event._registered.items() if of},
        "threads": numba.get_num_threads(),
        "hooks": [repr(hook) for hook in (sys.excepthook, sys.displayhook, sys.unraisablehook)],
        "environment": sorted(os.environ.items()),
    }
'''
COMPARED = '''
def changed(before, after):
    """Names of attributes that are others, hold others or are new."""
    for name, (value, held) in after.items():
        home, _, own = name.rpartition(".")
        if name not in before:
            # Of what was there: a module that is imported later is an attribute of its package,
            # and what Python finds out when it writes an object to a file is kept in its class.
            if home in known and own != "__slotnames__" and not is_module(value, name):
                yield name
        elif before[name][0] is not value and not same_number(before[name][0], value):
            yield name
        elif held is not None and before[name][1] is not None:
            old = {id(part) for part in before[name][1]}
            if any(id(part) not in old and is_ours(part) for part in held):
                yield name
    yield from (name for name in before if name not in after)


def is_module(value, name):
    return type(value) is type(sys) and value.__name__ == name


def same_number(a, b):
    return type(a) is type(b) and isinstance(a, (int, float, str, tuple)) and a == b


def is_ours(value):
    of = value if hasattr(value, "__module__") else type(value)
    return str(getattr(of, "__module__", "")).startswith("contiga")
'''


def said(code: str, **environment: str) -> Any:
    """What a new process prints last, as JSON."""
    path = os.pathsep.join((str(ROOT / "src"), str(ROOT)))
    run = subprocess.run(
        [sys.executable, "-c", code],
        env=os.environ | {"PYTHONPATH": path} | environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == 0, run.stderr
    return json.loads(run.stdout.splitlines()[-1])


@pytest.fixture(scope="module")
def beside() -> Any:
    """With this package at work beside a user's function: what is changed of others, and what the
    function becomes."""
    code = (
        f"{USER}\nimport json\n{SNAPSHOT}\n{COMPARED}\n"
        "first, before = told(), attributes()\nknown = set(sys.modules)\n"
        "known |= {n.rpartition('.')[0] for n in before}\n"
        f"{EXAMPLE}\n"
        "after, last = attributes(), told()\n"
        "others = sorted(set(changed(before, after)))\n"
        "settings = [k for k in first if first[k] != last[k]]\n"
        "text, events = compiled()\n"
        "print(json.dumps([others, settings, text, events]))"
    )
    return said(code)


def test_no_attribute_of_another_package_is_changed(beside: Any) -> None:
    others, settings, *_ = beside
    assert others == []
    assert settings == []


def test_a_users_function_is_compiled_as_without_this_package(beside: Any) -> None:
    end = "\ntext, events = compiled()\nimport json; print(json.dumps([text, events]))"
    alone, plain = said(USER + end)
    _, _, after, events = beside
    assert _nameless(after) == _nameless(alone)
    assert events == plain


def _nameless(text: str) -> str:
    """Machine code without the numbers that numba counts its functions by, and addresses."""
    return re.sub(r'"?\.bytes\.-?\d+"?|B\d+v\d+B|\d{6,}|0x[0-9a-f]+|\.const\.[\w.$<>]+', "", text)
