"""The list of kernels is that of the sources, and of what runs need."""

from __future__ import annotations

import inspect
from importlib import import_module

import pytest
from tests.kernels import exercises
from tests.kernels.recording import Types, recorded

from contiga.jit.dispatcher import KernelDispatcher
from contiga.warmup.listing import listing

LISTED = listing().kernels


@pytest.mark.parametrize("name", exercises.ALL)
def test_what_a_scene_needs_is_listed(name: str) -> None:
    with recorded() as recording:
        getattr(exercises, name)()
    new = [v for v in recording.parts if listing().find(*v) is None]
    assert not new, "python -m tests.kernels writes the list anew"


def test_all_scenes_are_gone_through() -> None:
    own = [
        name
        for name, found in vars(exercises).items()
        if inspect.isfunction(found) and found.__module__ == exercises.__name__
    ]
    assert sorted(exercises.ALL) == sorted(name for name in own if not name.startswith("_"))


def test_what_is_listed_is_there() -> None:
    for kernel in LISTED:
        assert isinstance(getattr(import_module(kernel.module), kernel.name), KernelDispatcher)


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
