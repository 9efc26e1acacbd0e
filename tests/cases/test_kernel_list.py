"""The list of kernels is that of the sources, and of what runs need."""

from __future__ import annotations

import inspect
import re
from importlib import import_module
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from tests.kernels import exercises
from tests.kernels.recording import Recording, Types, recorded
from tests.kernels.straight_calls import StraightCalls, looked_at

from contiga import jit
from contiga.jit.dispatcher import KernelDispatcher
from contiga.warmup.listing import listing

LISTED = listing().kernels


STRAIGHT = re.compile(r"\bstraight\((?:\w+\.)?(\w+)\)")
SOURCES = Path(__file__).resolve().parents[2] / "src" / "contiga"


class Gone(NamedTuple):
    """What was seen while a scene was gone through."""

    recording: Recording
    straight_calls: StraightCalls


@pytest.fixture(scope="module")
def gone_through() -> dict[str, Gone]:
    """All scenes, in the order in which runs come to what they need."""
    seen = {}
    for name in exercises.ALL:
        with recorded() as recording, looked_at() as straight_calls:
            getattr(exercises, name)()
        seen[name] = Gone(recording, straight_calls)
    return seen


@pytest.mark.parametrize("name", exercises.ALL)
def test_what_a_scene_needs_is_listed(name: str, gone_through: dict[str, Gone]) -> None:
    parts = gone_through[name].recording.parts
    new = [v for v in parts if listing().find(*v) is None]
    assert not new, "python -m tests.kernels writes the list anew"


@pytest.mark.parametrize("name", exercises.ALL)
def test_kernels_called_straight_are_handed_what_they_are_compiled_for(
    name: str, gone_through: dict[str, Gone]
) -> None:
    assert gone_through[name].straight_calls.wrong == []


def test_all_kernels_that_are_called_straight_are_looked_at(gone_through: dict[str, Gone]) -> None:
    named = {
        kernel
        for path in SOURCES.rglob("*.py")
        if "jit" not in path.parts
        for kernel in STRAIGHT.findall(path.read_text(encoding="utf-8"))
    }
    assert named
    assert named <= set().union(*(one.straight_calls.kernels for one in gone_through.values()))


def test_a_call_with_other_types_is_seen() -> None:
    @jit.kernel()
    def first(numbers):  # type: ignore[no-untyped-def]
        return numbers[0]

    first(np.arange(3.0))
    with looked_at() as calls:
        assert jit.straight(first)(np.arange(1.0, 3.0)) == 1.0
        assert calls.wrong == []
        assert jit.straight(first)(np.arange(1, 3)) == 1
    (line,) = calls.wrong
    assert line.startswith("first was handed (Array(int64")


def test_all_scenes_are_gone_through() -> None:
    own = [
        name
        for name, found in vars(exercises).items()
        if inspect.isfunction(found) and found.__module__ == exercises.__name__
    ]
    assert sorted(exercises.ALL) == sorted(name for name in own if not name.startswith("_"))


def test_what_is_listed_is_there() -> None:
    for one in LISTED:
        assert isinstance(getattr(import_module(one.module), one.name), KernelDispatcher)


def test_a_kernel_stands_behind_what_it_is_built_of() -> None:
    assert all(part < row for row, kernel in enumerate(LISTED) for part in kernel.parts)
    assert any(kernel.parts for kernel in LISTED)


def test_types_are_read_as_they_were_written() -> None:
    written = Types()
    for row, kernel in enumerate(LISTED):
        arguments = listing().arguments(row)
        assert tuple(map(written.row, arguments)) == kernel.arguments
        assert listing().find(kernel.module, kernel.name, arguments) == row
    names = {
        f"{type(of).__name__}" for row in range(len(LISTED)) for of in listing().arguments(row)
    }
    assert {"Array", "NestedArray", "Record", "Reference", "NamedTuple", "UniTuple"} <= names
