"""Whole runs beside the sum of their kernels, by room.

`python -m benchmarks runs`: every example and made scenes, each on one thread and three times: for
what is done once, for the rooms, for the kernels by a profile. Seconds are of processor time, so
that what else the machine does hardly counts. The numbers are written to out/runs.json, too.
"""

from __future__ import annotations

import cProfile
import json
import tempfile
from collections.abc import Callable
from contextlib import nullcontext, suppress
from pathlib import Path
from time import thread_time
from typing import Any, NamedTuple

import contiga as cg
from benchmarks import machine
from benchmarks.rooms import ROOMS, RoomClock, kernel_seconds
from benchmarks.run_scenes import COUNTS, RunScene, scenes
from benchmarks.timing import on_threads
from contiga.simulation.run import RunOptions, carry_out

OUT = Path("out/runs.json")
MOST = 600
"""Steps of an example."""


class Cost(NamedTuple):
    """Of a whole run: of a step in microseconds, of what is done once in seconds."""

    name: str
    nodes: int
    steps: int
    touching: float
    """Nodes in contact, mean over the steps."""
    rooms: dict[str, float]
    kernels: float
    start: float
    """Reading, building, the first step, and what bodies have worked out once."""
    compiled: float
    """By the clock."""

    @property
    def whole(self) -> float:
        """Of a step."""
        return sum(self.rooms.values())

    @property
    def ratio(self) -> float:
        """Of a step over its kernels."""
        return self.whole / self.kernels


class _EnoughError(Exception):
    """As many steps are done as were asked for."""


def run(
    counts: tuple[int, ...] = COUNTS,
    most: int | None = MOST,
    names: Callable[[str], bool] = lambda _: True,
    out: Path = OUT,
) -> list[str]:
    """The lines of the table: `most` steps of each example, all if None, of scenes by `names`."""
    with on_threads(1):
        costs = [cost_of(scene) for scene in scenes(counts, most) if names(scene.name)]
    data = {"machine": machine.described(), "rooms": ROOMS, "runs": [_as_json(c) for c in costs]}
    out.parent.mkdir(parents=True, exist_ok=True)
    out.write_text(json.dumps(data, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    return [_HEAD, *map(_line, costs)]


def cost_of(scene: RunScene) -> Cost:
    """What a run of a scene takes: with what is done once, then by room, then by profile."""
    begun = thread_time()
    simulation = scene.make()
    first = _Steps(scene.most)
    first.carry_out(simulation)
    spent = thread_time() - begun
    timed, profiled = _Steps(scene.most), _Steps(scene.most, cProfile.Profile(thread_time))
    timed.carry_out(simulation)
    profiled.carry_out(simulation)
    assert profiled.profile is not None
    step = 1e6 / timed.count
    rooms = {name: step * timed.spent[name] for name in ROOMS}
    return Cost(
        scene.name,
        sum(len(part.slave) for part in simulation.slaves.values()),
        timed.count,
        timed.touching / timed.count,
        rooms,
        step * kernel_seconds(profiled.profile),
        max(spent - sum(timed.spent[name] for name in ROOMS), 0.0),
        first.clock.compiled,
    )


class _Steps:
    """Counts the steps of a run, from that after the start to the last."""

    def __init__(self, most: int | None, profile: cProfile.Profile | None = None) -> None:
        self.clock, self.profile, self._most = RoomClock(), profile, most
        self.count = self.touching = 0
        self.spent: dict[str, float] = {}
        self._begun = False

    def carry_out(self, simulation: cg.Simulation) -> None:
        """Run into a folder that is then removed."""
        options = RunOptions(clock=self.clock, on_step=self._stepped)
        listening = nullcontext() if self.profile is not None else self.clock.listening()
        with tempfile.TemporaryDirectory() as folder, listening, suppress(_EnoughError):
            carry_out(simulation, Path(folder) / "run", options)

    def _stepped(self, state: cg.SystemState) -> None:
        if not self._begun:
            self._begun = True
            self.clock.reset()
            if self.profile is not None:
                self.profile.enable()
            return
        self.count += 1
        self.touching += state.n_contact
        self.spent = self.clock.read()
        if self.count == self._most:
            raise _EnoughError


_HEAD = (
    f"{'run':22s} {'nodes':>7s} {'steps':>6s} {'touch':>7s}"
    + "".join(f" {name:>8s}" for name in ROOMS)
    + f" {'together':>9s} {'kernels':>8s} {'ratio':>6s} {'start':>7s} {'compile':>8s}"
)


def _line(cost: Cost) -> str:
    return (
        f"{cost.name:22s} {cost.nodes:7d} {cost.steps:6d} {cost.touching:7.0f}"
        + "".join(f" {value:8.0f}" for value in cost.rooms.values())
        + f" {cost.whole:9.0f} {cost.kernels:8.0f} {cost.ratio:6.1f}"
        + f" {cost.start:5.1f} s {cost.compiled:6.1f} s"
    )


def _as_json(cost: Cost) -> dict[str, Any]:
    return cost._asdict() | {"whole": cost.whole, "ratio": cost.ratio}
