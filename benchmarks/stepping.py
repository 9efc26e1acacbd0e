"""Whole steps of a contact: search, forces and the new state of a million nodes."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from time import process_time

import numpy as np

import contiga as cg
from benchmarks.scene import HEADFORM, NIST, around
from benchmarks.sizes import Sizes
from benchmarks.table import Row, not_measured
from benchmarks.timing import in_turns, on_threads

PART = Row("whole step on the NIST part: share of 20 copies of the state", "×", 0.8, None)
SPHERE = Row("whole step on a sphere: share of 20 copies of the state", "×", 0.35, None)
FREE = Row("free nodes far away, each", "ns", 5.0, None)
OPEN = Row("open body, all nodes in contact, over the closed one", "×", 1.15, None)
DEEP = Row("nodes deep in the NIST part, nearest wall over tracked", "×", 1.5, None)
DEEP_FORM = Row("nodes deep in the headform, nearest wall over tracked", "×", 3.0, None)
DEEP_COPIES = Row("the same step on the NIST part: share of 20 copies of the state", "×", 3.0, None)
SMALL = Row("small steps: 4 nodes of 5,000 in contact", "µs", 60.0, None)
TOUCHING = 0.1


@cache
def ball() -> cg.Body:
    """A closed sphere of radius 1, its tables made once."""
    return cg.Body([cg.shapes.sphere(radius=1.0)])


class Stepper:
    """A contact whose nodes come in from outside, and go on in steps of `way` along x.

    From the second step on states are written into that of the step before the last, as a solver
    would have it that keeps two of them.
    """

    def __init__(
        self, body: cg.Body, outside: np.ndarray, points: np.ndarray, way: float, law: object
    ) -> None:
        slave = cg.Slave(points, thickness=np.full(len(points), 0.1 * body.size))
        self.contact = cg.Contact(body, slave, law=law, area=cg.NodalArea(1.0))
        self.points, self.way = points, np.array([way, 0.0, 0.0])
        self.spare: cg.State | None = None
        self.state = self.contact.step(self.contact.start(outside), points, dt=1.0)

    def ready(self, k: int) -> None:
        """Make the points of step k, which a solver would have."""
        self.now = self.points + k * self.way

    def __call__(self, _: int) -> None:
        new = self.contact.step(self.state, self.now, dt=1.0, out=self.spare)
        self.state, self.spare = new, self.state

    def arrays(self) -> list[np.ndarray]:
        """All that the state says a point, whether it keeps all rows or those in contact."""
        n = len(self.points)
        return [array for array in self.state.arrays.values() if array.shape[:1] == (n,)]

    @property
    def touching(self) -> float:
        """Share of the nodes in contact."""
        return self.state.n_contact / len(self.points)


def _whole(row: Row, body: cg.Body, size: Sizes) -> Row:
    places = around(body, size.points, TOUCHING)
    stepper = Stepper(body, *places, 1e-4 * body.size, stress_law())
    arrays = stepper.arrays()

    def copied(_: int) -> None:
        for _ in range(size.copies):
            kept = [array.copy() for array in arrays]
        del kept

    seconds = in_turns({"step": stepper, "copies": copied}, size.rounds)
    held = sum(array.nbytes for array in arrays) / size.points
    note = (
        f"{1e9 * seconds['step'] / size.points:.0f} ns a node, {100 * stepper.touching:.0f} % in "
        f"contact; {held:.0f} bytes a node"
    )
    detail = {"seconds": seconds, "bytes": held, "touching": stepper.touching}
    return row._replace(value=seconds["step"] / seconds["copies"], note=note, detail=detail)


def stress_law() -> cg.StressLaw:
    """A foam: stiff again where it is crushed."""
    return cg.StressLaw([[0.0, 0.0], [0.05, 0.3], [0.5, 0.7]])


def rows(size: Sizes) -> Iterator[Row]:
    """Whole steps on a trimmed part and on a sphere."""
    if NIST.is_file():
        yield _whole(PART, cg.read_cad(NIST), size)
    else:
        yield not_measured(PART, f"{NIST.name} is not there")
    yield _whole(SPHERE, ball(), size)


def free(size: Sizes) -> Iterator[Row]:
    """Nodes of which none comes near the body."""
    far = np.random.default_rng(5).uniform(50.0, 100.0, (size.points, 3))
    stepper = Stepper(ball(), far, far, 1e-3, stress_law())
    with on_threads(1):
        seconds = in_turns({"step": stepper}, size.rounds, process_time)
    value = 1e9 * seconds["step"] / size.points
    note = "one thread"
    yield FREE._replace(value=value, note=note, detail={"points": size.points})


def open_body(size: Sizes) -> Iterator[Row]:
    """The same nodes in the same places of a sphere, and of one that lacks its lowest part."""
    whole = ball().patches[0]
    u, (v0, v1) = whole.domain
    cut = cg.Body([whole.restricted(u, (v0 + 0.25 * (v1 - v0), v1))])
    n = size.points // 5
    rng = np.random.default_rng(6)
    z, a = rng.uniform(-0.3, 0.9, n), rng.uniform(0.0, 2.0 * np.pi, n)
    r = np.sqrt(1.0 - z * z)
    depth = 1.0 - 1e-3 - 1e-2 * rng.random(n)
    on = np.stack([r * np.cos(a), r * np.sin(a), z], axis=1)
    steppers = {
        name: Stepper(body, 1.01 * on, depth[:, None] * on, 1e-5, cg.PenaltyLaw(1.0))
        for name, body in (("closed", ball()), ("open", cut))
    }
    assert steppers["closed"].contact.master.closed
    assert not steppers["open"].contact.master.closed
    seconds = in_turns(steppers, size.rounds)
    each = {name: 1e9 * t / n for name, t in seconds.items()}
    assert all(stepper.touching == 1.0 for stepper in steppers.values())
    note = f"{each['open']:.0f} ns and {each['closed']:.0f} ns a node, all in contact"
    yield OPEN._replace(value=each["open"] / each["closed"], note=note, detail={"ns": each})


class Plunge:
    """A sheet of nodes that goes down into a body, 20 steps of `way` sizes, and then along."""

    def __init__(self, body: cg.Body, nodes: int, down: int, way: float, foot: str) -> None:
        low, high = body.bounds()
        along = (down + 1) % 3
        margin, side = 0.05 * (high - low), int(np.sqrt(nodes))
        lines = [np.linspace(a, b, side) for a, b in zip(low + margin, high - margin, strict=True)]
        lines[down] = np.array([high[down] + 0.5 * way * body.size])
        grid = np.meshgrid(*lines, indexing="ij")
        self.points = np.stack([axis.ravel() for axis in grid], axis=1)
        self.deeper, self.onward = np.zeros(3), np.zeros(3)
        self.deeper[down], self.onward[along] = -way * body.size, way / 3.0 * body.size
        slave = cg.Slave(self.points)
        law = cg.ForceLaw([[0.0, 0.0], [body.size, 1.0]])
        area = cg.NodalArea(1.0)
        self.contact = cg.Contact(body, slave, law=law, area=area, foot=foot)
        self.state = self.contact.start(self.points)
        self.spare: cg.State | None = None

    def ready(self, k: int) -> None:
        """Make the points of step k."""
        self.points = self.points + (self.deeper if k <= 20 else self.onward)

    def __call__(self, _: int) -> None:
        new = self.contact.step(self.state, self.points, dt=1.0, out=self.spare)
        self.state, self.spare = new, self.state


def _plunged(row: Row, body: cg.Body, nodes: int, down: int, way: float) -> Row:
    """Sums of the steps of both feet, step by step in turns; compiled before."""
    for foot in ("nearest", "tracked"):
        warm = Plunge(body, 10_000, down, way, foot)
        for k in range(1, 31):
            warm.ready(k)
            warm(k)
    plunges = {foot: Plunge(body, nodes, down, way, foot) for foot in ("nearest", "tracked")}
    seconds = dict.fromkeys(plunges, 0.0)
    for k in range(1, 31):
        for foot, plunge in plunges.items():
            plunge.ready(k)
            start = process_time()
            plunge(k)
            seconds[foot] += process_time() - start
    state = plunges["nearest"].state
    each = {foot: 1e6 * t / 30 / state.n_contact for foot, t in seconds.items()}
    note = (
        f"{each['nearest']:.1f} and {each['tracked']:.1f} µs a node and step, "
        f"{state.n_contact:,} nodes, {state.max_penetration / body.size:.1%} of the size deep"
    )
    value = seconds["nearest"] / seconds["tracked"]
    return row._replace(value=value, note=note, detail={"seconds": seconds})


def deep(size: Sizes) -> Iterator[Row]:
    """Nodes that lie deep in a part of many faces, and in a body of splines."""
    nodes = size.points * 4 // 25
    if NIST.is_file():
        part = cg.read_cad(NIST)
        yield _plunged(DEEP, part, nodes, 1, 0.0015)
        yield _copied(DEEP_COPIES, Plunge(part, size.points, 1, 0.0015, "nearest"), size)
    else:
        yield not_measured(DEEP, f"{NIST.name} is not there")
        yield not_measured(DEEP_COPIES, f"{NIST.name} is not there")
    if HEADFORM.is_file():
        yield _plunged(DEEP_FORM, cg.read_cad(HEADFORM), nodes, 2, 0.01)
    else:
        yield not_measured(DEEP_FORM, f"{HEADFORM.name} is not there: make demo")


def _copied(row: Row, plunge: Plunge, size: Sizes) -> Row:
    """The last step of a plunge beside copies of its state."""
    for k in range(1, 31):
        plunge.ready(k)
        start = process_time()
        plunge(k)
        step = process_time() - start
    n = len(plunge.points)
    arrays = [array for array in plunge.state.arrays.values() if array.shape[:1] == (n,)]
    start = process_time()
    for _ in range(size.copies):
        kept = [array.copy() for array in arrays]
    copies = process_time() - start
    del kept
    note = f"{1e9 * step / n:.0f} ns a node, {plunge.state.n_contact / n:.0%} in contact"
    return row._replace(value=step / copies, note=note, detail={"seconds": [step, copies]})


def small(size: Sizes) -> Iterator[Row]:
    """A ball that presses four nodes of a sheet, a little more and less from step to step."""
    sheet = cg.clouds.sample(cg.shapes.plane(width=4.95, length=2.45), 100, 50)  # 0.05 apart
    slave = cg.Slave(sheet)
    contact = cg.Contact(ball(), slave, law=cg.PenaltyLaw(1.0), area=cg.NodalArea(1.0))
    poses = [cg.motion.pose.translation([0.0, 0.0, 1.0 + up]) for up in (0.02, -1.5e-3, -1.6e-3)]
    state = contact.step(contact.start(sheet, pose=poses[0]), sheet, pose=poses[1])
    # As a solver that keeps two states: each step is written into that before the last.
    spare = contact.step(state, sheet, pose=poses[2])

    def work(k: int) -> None:
        nonlocal state, spare
        for i in range(size.small_steps):
            new = contact.step(state, sheet, pose=poses[1 + i % 2], out=spare)
            state, spare = new, state

    with on_threads(1):
        seconds = in_turns({"step": work}, min(size.rounds, 4), process_time)
    value = 1e6 * seconds["step"] / size.small_steps
    note = f"{state.n_contact} in contact; one thread"
    yield SMALL._replace(value=value, note=note)
