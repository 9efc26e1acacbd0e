"""Whole runs from a case file, and what physics asks of every one of them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from tests.sample import FULL

import contiga as cg
from contiga.arrays.ordered import length
from contiga.case import build as building
from contiga.case.part_cache import PartCache
from contiga.records import ContactStatus as Is
from contiga.simulation.model import ContactPart
from contiga_validation.thesis.scenes import scene


class Followed(NamedTuple):
    """A run with the states of all its steps."""

    simulation: cg.Simulation
    contact: ContactPart
    snapshots: list[cg.SystemState]
    history: dict[str, np.ndarray]

    @property
    def states(self) -> list[cg.State]:
        return [snapshot.contacts[self.contact.name] for snapshot in self.snapshots]

    @property
    def body(self) -> cg.Body:
        return self.simulation.bodies[self.contact.master].body

    def points(self, k: int) -> np.ndarray:
        return self.snapshots[k].slaves[self.contact.slave].points

    @property
    def peak(self) -> int:
        return int(self.history["max_penetration"].argmax())


def follow(path: Path, folder: Path, again: bool) -> Followed:
    """Run a case through the public door, and `again` step by step; both must agree."""
    case, parts = cg.load_case(path), PartCache()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(building, "PartCache", lambda: parts)
        result = cg.run(case, out=folder / "out", keep=1)
        simulation = building.build(case)
    (contact,) = simulation.contacts
    snapshots = list(result.states)
    if again:
        snapshots = [simulation.start()]
        while snapshots[-1].time < simulation.stepping.end:
            snapshots.append(simulation.step(snapshots[-1]))
    followed = Followed(simulation, contact, snapshots, result.history)
    assert [kept.time for kept in result.states] == [one.time for one in snapshots]
    counts = [state.n_contact for state in followed.states]
    np.testing.assert_array_equal(counts, result.history["n_contact"])
    force = [length(state.total_force) for state in followed.states]
    np.testing.assert_array_equal(force, result.history["force"])
    return followed


def check_physics(run: Followed, *, slides_off: bool = False, corners: bool = False) -> None:
    """What holds in every run: action and reaction, no jumps, nothing lost.

    A distance to something at rest changes by at most the way gone, so penetration may not grow,
    begin or end by more than a point has moved against the body in the step. With `corners`,
    points may leave round sharp edges: the foot then goes from the face they came in by to the
    one they go out by, and only those whose foot stays on its face are held to that.
    """
    size = run.body.size
    for last, state in zip([None, *run.states], run.states, strict=False):
        np.testing.assert_array_equal(state.wrench[:3], -state.total_force)
        assert not (state.status == Is.LOST).any()
        assert not (state.status == Is.NOT_FINITE).any()
        assert slides_off or not (state.status == Is.SLID_OFF).any()
        on = state.in_contact
        np.testing.assert_allclose(np.linalg.norm(state.normal[on], axis=1), 1.0, atol=1e-12)
        assert ((state.force * state.normal).sum(axis=1) >= 0.0).all()
        assert not state.force[~on].any()
        if last is None:
            continue
        way = np.linalg.norm(state.points_B - last.points_B, axis=1)
        kept = state.status != Is.SLID_OFF
        if corners:
            kept = (state.status == Is.NEW) | (state.patch == last.patch)
            kept &= state.status != Is.REACQUIRED
        # One that left by one wall and came in by another has come in anew.
        before = np.where(state.status == Is.NEW, 0.0, last.penetration)
        change = np.abs(state.penetration - before)[kept]
        assert (change <= way[kept] + 1e-10 * size).all()


@pytest.fixture
def run_case(tmp_path: Path) -> Callable[[str], Followed]:
    def run(text: str) -> Followed:
        path = tmp_path / "case.toml"
        path.write_text(text)
        return follow(path, tmp_path, again=FULL)

    return run


@pytest.fixture
def run_scene(tmp_path: Path) -> Callable[[str], Followed]:
    """Runs one of the case files of the thesis' scenes, and once more step by step."""
    return lambda name: follow(scene(name), tmp_path, again=True)


@pytest.fixture
def physics() -> Callable[..., None]:
    return check_physics
