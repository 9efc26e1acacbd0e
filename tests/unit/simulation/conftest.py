"""A small simulation to run: a ball rolls and dips into a sheet and comes back."""

from __future__ import annotations

import sys
from collections.abc import Callable

import numpy as np
import pytest
from tests.scenes import grid_quads

import contiga as cg
from contiga import Simulation
from contiga.dynamics.prescribed import Combine, Fixed, Moved, Rotate, Translate
from contiga.dynamics.stepping import GivenTimes
from contiga.simulation.model import BodyPart, ContactPart, OutputOptions, SlavePart

STEPS = 12


def make_simulation(**changes: object) -> Simulation:
    """The simulation, with fields changed."""
    n = 15
    points = cg.clouds.sample(cg.shapes.plane(width=2.0, length=2.0), n, n)
    sheet = cg.Slave(points, grid_quads(n), thickness=np.full(n * n, 0.5), name="sheet")
    ball = cg.Body([cg.shapes.sphere(radius=0.5, centre=(0.0, 0.0, 0.55))], name="ball")
    dip = Translate([[0, 0, 0, 0], [6, 0.2, 0, -0.25], [12, 0.4, 0, 0]])
    roll = Rotate([[0, 0], [12, 6]], axis="y", centre=(0.0, 0.0, 0.55))
    law = cg.StressLaw([[0, 0], [0.1, 1.0], [1.0, 3.0]], damping=0.2)
    values: dict[str, object] = {
        "title": "A ball dips into a sheet",
        "units": ("mm", "g", "ms"),
        "stepping": GivenTimes(12.0 * np.linspace(0.0, 1.0, STEPS + 1) ** 1.1),
        "bodies": {"ball": BodyPart(ball, Combine([roll, dip]))},
        "slaves": {"sheet": SlavePart(sheet, Moved(sheet.points, Fixed()))},
        "contacts": (ContactPart("dip", "ball", "sheet", cg.Contact(ball, sheet, law=law)),),
        "output": OutputOptions(),
        "case_text": 'title = "A ball dips into a sheet"\n',
    }
    return Simulation(**(values | changes))


@pytest.fixture
def simulation() -> Simulation:
    return make_simulation()


class StopError(Exception):
    """Raised by a user in the middle of a run."""


@pytest.fixture
def stop_after() -> Callable[[int], Callable[[int, int, int], None]]:
    """A progress callback that stops the run after so many steps."""

    def make(steps: int) -> Callable[[int, int, int], None]:
        def progress(done: int, _: int, __: int) -> None:
            if done == steps:
                raise StopError

        return progress

    return make


@pytest.fixture
def make() -> Callable[..., Simulation]:
    return make_simulation


@pytest.fixture
def stop() -> type[StopError]:
    return StopError


@pytest.fixture
def blocked(monkeypatch: pytest.MonkeyPatch) -> Callable[[str], None]:
    """Makes the import of a package fail."""
    return lambda name: monkeypatch.setitem(sys.modules, name, None)


@pytest.fixture
def always(monkeypatch: pytest.MonkeyPatch) -> None:
    """Leaves a checkpoint behind every step."""
    monkeypatch.setattr("contiga.simulation.recorder.CHECKPOINT_SECONDS", -1.0)
