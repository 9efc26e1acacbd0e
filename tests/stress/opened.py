"""Points that go straight or along polylines through shells, and whether the rule holds there."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from tests.stress import open_rule
from tests.stress.fields import norm
from tests.stress.open_rule import Becomes, Held
from tests.stress.open_scenes import Scene, scene
from tests.stress.tally import Clock, Tally

import contiga as cg
from contiga.records import ContactStatus as Is

SAME = 1e-9
"""Depths closer than this are the same; shells are about as large as one."""
FLAGS = (Is.LOST, Is.FOUND, Is.REACQUIRED)
PIECES = 512
"""Pieces that a path of whatever number of steps is cut into, four a step at least."""
CLOSER = (4, 16)
"""How much finer those paths are cut of which contiga says something else."""
PART = 1.0 / 16.0
"""Of its depth that a point may go in a step without that borders and other walls are passed by."""
PARTS = 128
"""Steps that a longer one is cut into, shorter near the shell, to see whether it is right then."""
LEGS = 4
STEPS = (1, 2, 5, 20, 100)
LENGTHS = (1e-9, 1e-6, 1e-3, 0.03, 0.3, 1.0, 1e3)
"""Of the legs of a path, sizes."""
MANY_STEPS = 1000
LONG = (0.3, 1.0)
"""Lengths of legs that are taken in many steps."""


class Frame(NamedTuple):
    """How a scene stands in the world: made `scale` times as large, turned, and moved."""

    scale: float
    turn: np.ndarray
    """(3, 3)"""
    moves: float
    """How far the body moves in a step, its size being one."""


def random_frame(rng: np.random.Generator) -> Frame:
    """The identity in a third of all cases."""
    if rng.random() < 1.0 / 3.0:
        return Frame(1.0, np.eye(3), 0.0)
    turn = cg.motion.pose.rotation(rng.normal(size=3), rng.uniform(0.0, np.pi))[:3, :3]
    return Frame(float(rng.choice([1e-3, 1.0, 1e3])), turn, float(rng.choice([0.0, 0.3])))


def corners(item: Scene, n: int, length: float, rng: np.random.Generator) -> np.ndarray:
    """(LEGS + 1, n, 3) corners of paths whose legs are about `length`.

    A third of the points begin anywhere, a third close before a face, and a third slide: they are
    pressed in beside a face and go along it.
    """
    low, high = item.low - 0.3, item.high + 0.3
    p = rng.uniform(low, high, (n, 3))
    feet = item.shell.feet(p)
    nearest = feet.distance.argmin(axis=1)
    rows = np.arange(n)
    normal = feet.normal[rows, nearest]
    off = np.where(feet.behind[rows, nearest], -1.0, 1.0) * feet.distance[rows, nearest]
    kind = np.where(np.isfinite(off), rng.integers(0, 3, n), 0)
    close = kind > 0
    shift = rng.uniform(0.0, min(length, 0.2), close.sum()) - off[close]
    p[close] += shift[:, None] * normal[close]
    legs = length * rng.normal(scale=0.6, size=(LEGS, n, 3))
    slides = kind == 2
    way = legs[:, slides]
    across = normal[slides]
    way -= np.einsum("lnk,nk->ln", way, across)[..., None] * across
    way *= rng.uniform(1.0, 3.0)
    deep = min(length, 0.3) * rng.uniform(0.0, 1.0, (LEGS, slides.sum(), 1))
    way[0] = 0.02 * way[0] - (min(length, 0.2) + deep[0]) * across
    way[1:] += 0.1 * rng.normal(size=deep[1:].shape) * deep[1:] * across
    legs[:, slides] = way
    ends = np.concatenate([p[None], p + np.cumsum(legs, axis=0)])
    if length > 3.0:  # there and back
        ends[2::2] = rng.uniform(low, high, ends[2::2].shape)
    return ends


def places(ends: np.ndarray, steps: int) -> np.ndarray:
    """(k + 1, n, 3) places along polylines, `steps` in all; some corners are cut by few steps."""
    t = np.linspace(0.0, len(ends) - 1.0, steps + 1)
    leg = np.minimum(t.astype(int), len(ends) - 2)
    share = (t - leg)[:, None, None]
    return (1.0 - share) * ends[leg] + share * ends[leg + 1]


class Walker:
    """A scene in the world, and the steps of its points there."""

    def __init__(self, item: Scene, frame: Frame, n: int, rng: np.random.Generator) -> None:
        self.frame, self.rng = frame, rng
        master = item.master if frame.scale == 1.0 else item.master.scaled(frame.scale)
        slave = cg.Slave(np.zeros((n, 3)), area=np.ones(n))
        self.contact = cg.Contact(master, slave, law=cg.PenaltyLaw(1.0))
        self.pose = np.eye(4)
        self.pose[:3, :3] = frame.turn

    def _world(self, p: np.ndarray) -> np.ndarray:
        if self.frame.moves:
            self.pose[:3, 3] = self.frame.scale * self.rng.normal(scale=self.frame.moves, size=3)
        return self.frame.scale * p @ self.pose[:3, :3].T + self.pose[:3, 3]

    def start(self, p: np.ndarray) -> cg.State:
        """At places (n, 3) of the scene."""
        return self.contact.start(self._world(p), self.pose.copy())

    def step(self, state: cg.State, p: np.ndarray) -> cg.State:
        """To places of the scene."""
        return self.contact.step(state, self._world(p), self.pose.copy())

    def in_parts(self, state: cg.State, a: np.ndarray, b: np.ndarray) -> cg.State:
        """As `step` from places a, that the state is of, to b, in `PARTS` steps."""
        for share in open_rule.shares_of(a, b, PARTS)[1:]:
            place = self.frame.scale * (b - (1.0 - share)[:, None] * (b - a))
            p_W = place @ self.pose[:3, :3].T + self.pose[:3, 3]
            state = self.contact.step(state, p_W, self.pose.copy())
        return state

    def places(self, state: cg.State) -> np.ndarray:
        """Where the points are in the scene, rounding of the frame and all."""
        return np.array(state.points_B) / self.frame.scale

    def held(self, state: cg.State, became: np.ndarray) -> Held:
        """What contiga says, as of the rule."""
        normal = np.array(state.normal_B)
        guard = np.where(state.guard_B.any(axis=1)[:, None], state.guard_B, normal)
        depth = state.penetration / self.frame.scale
        return Held(np.array(state.in_contact), depth, guard, normal, became)


def judged(
    item: Scene, way: tuple[np.ndarray, np.ndarray], held: Held, said: Held, pieces: int
) -> tuple[Held, np.ndarray]:
    """What the rule says after a step from `held`, and of which rows it is in doubt.

    Where it is not what is `said` the path is followed more closely, and closer still.
    """
    a, b = way
    truth = open_rule.step(item.shell, a, b, held, pieces)
    doubtful = np.zeros(len(a), bool)
    differs = np.flatnonzero(_differ(truth, said) | (truth.became == Becomes.ENDED))
    for finer in CLOSER:
        if len(differs) == 0:
            break
        was = Held(*(column[differs] for column in truth))
        own = Held(*(column[differs] for column in held))
        fine = open_rule.step(item.shell, a[differs], b[differs], own, finer * pieces)
        ended = fine.became == Becomes.ENDED
        unsure = _differ(fine, was) & ~(was.became == Becomes.ENDED) | ended
        doubtful[differs] = unsure
        for column, value in zip(truth, fine, strict=True):
            column[differs] = value
        wrong = _differ(fine, Held(*(column[differs] for column in said)))
        differs = differs[(wrong & ~unsure) | ended]
    doubtful |= item.shell.nearest(b) < SAME
    return truth, doubtful & _differ(truth, said)


def _differ(one: Held, other: Held) -> np.ndarray:
    apart = np.abs(one.depth - other.depth)
    return np.asarray((one.on != other.on) | (apart > SAME * (1.0 + one.depth)))


def follow(
    item: Scene, way: np.ndarray, frame: Frame, rng: np.random.Generator, tally: Tally
) -> None:
    """Take points along their ways (k, n, 3), one step a row, and judge every step."""
    steps, n = len(way) - 1, way.shape[1]
    walker = Walker(item, frame, n, rng)
    pieces = max(4, PIECES // steps)
    state = walker.start(way[0])
    before, held = walker.places(state), open_rule.free(n)
    for target in way[1:]:
        last, state = state, walker.step(state, target)
        now = walker.places(state)
        said = walker.held(state, np.array(state.status).astype(int))
        truth, doubtful = judged(item, (before, now), held, said, pieces)
        wrong = _differ(truth, said) & ~doubtful
        deepest = np.maximum(np.maximum(truth.depth, said.depth), held.depth)
        long = wrong & (norm(now - before) > PART * deepest)
        if long.any():
            shorter = walker.in_parts(last, before, now)
            long &= ~_differ(truth, walker.held(shorter, said.became))
        _count(tally, state, (before, now), (held, truth, said), doubtful, long)
        other = _differ(truth, said)
        columns = zip(said, truth, strict=True)
        held = Held(*(np.where(other if x.ndim == 1 else other[:, None], x, y) for x, y in columns))
        before = now


def _count(
    tally: Tally,
    state: cg.State,
    way: tuple[np.ndarray, np.ndarray],
    of: tuple[Held, Held, Held],
    doubtful: np.ndarray,
    long: np.ndarray,
) -> None:
    """Add what one step shows; `long` are rows that are right in shorter steps, which is said."""
    held, truth, said = of
    flagged = np.isin(state.status, FLAGS)
    proved = np.array(state.certified) == 1
    # Which wall a foot slides on to whose minimum has vanished is not followed here.
    vanished = (truth.became == Becomes.REACQUIRED) & ~said.on
    doubtful = doubtful | vanished
    wrong = _differ(truth, said) & ~doubtful & ~long
    values = {
        "before": way[0], "point": way[1], "held": held.on, "was": held.depth,
        "guard": held.guard, "expected": truth.depth, "expected normal": truth.normal,
        "became": truth.became, "penetration": said.depth, "normal": said.normal,
        "status": said.became, "certified": proved,
    }  # fmt: skip
    tally.count += len(wrong)
    tally.doubtful += int(doubtful.sum())
    tally.flagged += int(flagged.sum())
    kinds = {
        "not in contact, but should be": wrong & truth.on & ~said.on & ~flagged,
        "in contact, but should not be": wrong & ~truth.on & said.on & ~flagged,
        "another depth": wrong & truth.on & said.on & ~flagged,
        "proved and wrong": wrong & flagged & proved & said.on,
    }
    for kind, rows in kinds.items():
        tally.fault(kind, np.flatnonzero(rows), **values)
    same = ~wrong & ~doubtful & ~flagged & ~long
    turned = same & truth.on & (open_rule.along(truth, said.normal) < 1.0 - 1e-6)
    ended = same & held.on & ~truth.on & (truth.became != said.became)
    notes = {
        "in contact": truth.on,
        "right in shorter steps": long,
        "minimum vanished, and let go": vanished,
        "wrong and flagged": wrong & flagged,
        "flagged without need": flagged & ~wrong & (truth.became != Becomes.REACQUIRED),
        "reacquired in silence": same & (truth.became == Becomes.REACQUIRED),
        "ended another way": ended,
        "another normal": turned & (truth.depth > SAME),
        "not proved": said.on & ~proved,
    }
    for name, rows in notes.items():
        tally.note(name, int(rows.sum()))
    for kind in ("ended another way", "another normal"):
        kept = Tally("")
        kept.fault(kind, np.flatnonzero(notes[kind]), **values)
        tally.faults += kept.faults[: max(0, 3 - sum(f["kind"] == kind for f in tally.faults))]


def walked(
    name: str,
    points: int,
    seed: int,
    steps: Sequence[int] = STEPS,
    lengths: Sequence[float] = LENGTHS,
    many: int = 0,
) -> Tally:
    """One scene with paths of these lengths in these numbers of steps, some `points` rows of each;
    `many` points take a great number of steps."""
    item = scene(name)
    runs = [(count, length, max(4, points // count)) for count in steps for length in lengths]
    runs += [(MANY_STEPS, length, many) for length in LONG if many]
    with Clock(Tally(f"open, {name}")) as tally:
        for k, (count, length, n) in enumerate(runs):
            rng = np.random.default_rng([seed, k])
            frame = random_frame(rng)
            follow(item, places(corners(item, n, length, rng), count), frame, rng, tally)
    return tally
