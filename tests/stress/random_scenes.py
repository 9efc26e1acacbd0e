"""Scenes of bodies, pulses, panels, springs, laws and motions, each from a number.

Sizes are about one, before a scene is put into units of its own: lengths, masses and times by
powers of ten.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from tests.scenes import box

import contiga as cg
from contiga.laws.law import Law

FAR = 4.0
"""Half of the width of what is wide."""


class Units(NamedTuple):
    """What a length, a mass and a time of one are, in those of the scene."""

    length: float
    mass: float
    time: float

    @property
    def speed(self) -> float:
        """A length by a time."""
        return self.length / self.time

    @property
    def force(self) -> float:
        """A mass by an acceleration."""
        return self.mass * self.length / self.time**2

    @property
    def stiffness(self) -> float:
        """A force by a length."""
        return self.mass / self.time**2


class Scene(NamedTuple):
    """What a simulation is made of, but for its steps."""

    text: str
    parts: dict[str, Any]
    end: float

    def simulation(self, **time: Any) -> cg.Simulation:
        """With steps of some kind."""
        return cg.Simulation(**self.parts, **time)


def scene(seed: int) -> Scene:
    """The scene of a number."""
    return _Maker(seed).scene()


class _Maker:
    """Draws one scene. The master stands about the origin, and the slave comes from above."""

    def __init__(self, seed: int) -> None:
        self.rng = np.random.default_rng([seed, 41])
        self.units = Units(*(10.0 ** self.rng.integers(-3, 4, 3)))
        self.words: list[str] = []

    def scene(self) -> Scene:
        """All of it."""
        u = self.units
        self.kind = self.pick(
            "master", "carrier", "both", "nodes", "driven carrier", "driven nodes"
        )
        self.mass, self.speed = self.log(-1, 1), self.log(-1, 1)
        self.gap = self.log(-2, 0.3)
        self.pull = self.log(-1, 1) * self.speed**2 if self.chance(0.3) else 0.0
        self.struck = np.sqrt(self.speed**2 + 2.0 * self.pull * self.gap)
        self.deep = self.log(-2.5, -0.6)
        self.end = self.gap / self.struck + self.deep / self.struck * np.pi * self.log(-0.3, 0.7)
        top, master = self.master()
        slave = self.slave(top)
        contact = cg.Contact(
            master, slave, law=self.law(len(slave)), friction=self.friction(),
            through=self.pick("release", "release", "hold"),
        )  # fmt: skip
        parts = {"contacts": [contact], **self.standing(master, slave, top)}
        parts["springs"] = self.springs(parts["bodies"], top)
        parts["loads"] = self.loads(parts["bodies"])
        down = -self.pull * u.length / u.time**2
        parts["gravity"] = [0.1 * down, 0.0, down]
        end = self.end * u.time
        return Scene(", ".join(self.words), parts, end)

    # ------------------------------------------------------------ how things are drawn

    def chance(self, share: float) -> bool:
        return bool(self.rng.random() < share)

    def log(self, low: float, high: float) -> float:
        """A number between two powers of ten."""
        return float(10.0 ** self.rng.uniform(low, high))

    def pick(self, *words: str) -> str:
        word = str(self.rng.choice(words))
        self.words.append(word)
        return word

    def way(self) -> np.ndarray:
        """A direction."""
        v = self.rng.normal(size=3)
        return v / np.linalg.norm(v)

    # ------------------------------------------------------------ the two sides

    def master(self) -> tuple[float, cg.Body]:
        """How high its top is, and the body."""
        L, rng = self.units.length, self.rng
        shape = self.pick("sphere", "ellipsoid", "torus", "block", "panel")
        if shape == "sphere":
            return 1.0, cg.Body([cg.shapes.sphere(radius=L)])
        if shape == "ellipsoid":
            a, b, c = rng.uniform(0.4, 2.0, 3)
            return c, cg.Body([cg.shapes.ellipsoid(axes=(a * L, b * L, c * L))])
        if shape == "torus":
            r = rng.uniform(0.2, 0.6)
            return r, cg.Body([cg.shapes.torus(major=1.5 * L, minor=r * L)])
        half, thick = (1.0, 1.0) if shape == "block" else (FAR, self.log(-2, -0.5))
        low, high = (-half * L, -half * L, -2 * thick * L), (half * L, half * L, 0.0)
        return 0.0, box(low, high)

    def slave(self, top: float) -> cg.Slave:
        """Points above the master: one, a few, a grid."""
        L = self.units.length
        count = int(self.rng.choice([1, 2, 3, 5]))
        half = self.rng.uniform(0.1, 0.6)
        x, y = np.meshgrid(*2 * [np.linspace(-half, half, count) if count > 1 else np.zeros(1)])
        points = np.column_stack([x.ravel(), y.ravel(), np.zeros(count * count)])
        points += [*self.rng.uniform(-0.1, 0.1, 2), top + self.gap]
        if self.words[1] == "torus":
            points[:, 0] += 1.5
        self.words.append(f"{count * count} points")
        mass = self.mass * self.units.mass / len(points) * self.rng.uniform(0.5, 2.0, len(points))
        own = {"mass": mass} if self.kind.endswith("nodes") else {}
        area = np.full(len(points), (2 * half * L / count) ** 2)
        return cg.Slave(points * L, area=area, thickness=np.full(len(points), 0.5 * L), **own)

    def standing(self, master: cg.Body, slave: cg.Slave, top: float) -> dict[str, Any]:
        """Bodies and slaves with what moves them."""
        bodies: dict[str, Any] = {"master": master}
        slaves: dict[str, Any] = {"slave": slave}
        u = self.units
        down = np.array([*0.3 * self.rng.normal(size=2), -1.0]) * self.speed * u.speed
        if self.kind == "master":
            bodies["master"] = master, self.free(-down, np.zeros(3))
        if self.kind.startswith("driven"):
            bodies["master"] = master, self.drive()
            down = np.zeros(3)
        if self.kind.endswith("nodes"):
            slaves["slave"] = slave, cg.motion.Free(velocity=down)
        if self.kind in ("carrier", "both", "driven carrier"):
            centre = np.array([0.0, 0.0, top + self.gap + 0.7])
            ball = cg.Body([cg.shapes.sphere(radius=0.3 * u.length, centre=centre * u.length)])
            bodies["carrier"] = ball, self.free(down, centre)
            slaves["slave"] = slave, cg.motion.Attached("carrier")
        if self.kind == "both":
            bodies["master"] = master, self.free(np.zeros(3), np.zeros(3))
        return {"bodies": bodies, "slaves": slaves}

    def free(self, velocity: np.ndarray, centre: np.ndarray) -> cg.motion.Free:
        """A free body; some turn, some are held."""
        u, rng = self.units, self.rng
        mass = self.mass * u.mass * (1.0 if velocity.any() else self.log(-0.5, 1.0))
        axes = np.sort(rng.uniform(0.3, 1.0, 3))
        axes[2] = min(axes[2], 0.9 * (axes[0] + axes[1]))
        turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        inertia = mass * 0.4 * u.length**2 * turn @ np.diag(axes) @ turn.T
        hold = ["rx", "ry", "rz"] if self.chance(0.3) else ["x"] if self.chance(0.1) else []
        spin = self.way() * self.speed * self.log(-1.5, 0.3) / u.time
        if "rx" in hold or self.chance(0.4):
            spin = np.zeros(3)
        velocity = velocity * [0.0 if "x" in hold else 1.0, 1.0, 1.0]
        self.words.append("held" if hold else "spins" if spin.any() else "free")
        inertia = 0.5 * (inertia + inertia.T)
        return cg.motion.Free(
            mass=mass, inertia=inertia, centre=centre * u.length, velocity=velocity, spin=spin,
            hold=hold,
        )  # fmt: skip

    def drive(self) -> Any:
        """A motion that brings the master up against the slave."""
        u, rng = self.units, self.rng
        way = (self.gap + self.deep) * rng.uniform(1.0, 1.5)
        when, takes = self.end * rng.uniform(0.0, 0.5), way / self.struck
        kind = self.pick("blow", "velocity", "acceleration", "turning")
        late = when + 2.0 * takes + self.end
        if kind == "blow":
            rows = [[0, 0], [when + 0.01 * takes, 0], [when + takes, way], [when + 2 * takes, 0]]
            rows.append([late, 0])
            table = [[t * u.time, 0.0, 0.0, z * u.length] for t, z in rows]
            return cg.motion.Translate(table)
        if kind == "velocity":
            rows = [[0, 0], [when + 0.01 * takes, 0], [when + takes, self.struck], [late, 0]]
            table = [[t * u.time, v * u.speed] for t, v in rows]
            return cg.motion.Velocity(table, direction="z", smooth=self.chance(0.5))
        if kind == "acceleration":
            a = 2.0 * way / takes**2
            rows = [[0, 0], [when + 0.01 * takes, 0], [when + takes, 2 * a], [late, -0.3 * a]]
            table = [[t * u.time, v * u.speed / u.time] for t, v in rows]
            return cg.motion.Accelerated(table, direction="z")
        arm = 2.0
        degrees = np.degrees(way / arm)
        rows = [[0, 0], [when + 0.01 * takes, 0], [when + takes, degrees], [late, 2 * degrees]]
        table = [[t * u.time, d] for t, d in rows]
        return cg.motion.Rotate(table, axis="y", centre=(arm * u.length, 0.0, 0.0))

    # ------------------------------------------------------------ what acts

    def law(self, count: int) -> Law:
        """A law under which what strikes goes about as deep as is wanted."""
        u, deep = self.units, self.deep
        whole = self.mass * self.struck**2 / deep**2
        k, each = whole * u.stiffness, whole / count * u.stiffness
        damper = 2.0 * np.sqrt(each * self.mass / count * u.mass)
        kind = self.pick("penalty", "damped", "force", "stiffening", "unloading", "stress")
        if kind == "penalty":
            return cg.PenaltyLaw(each)
        if kind == "damped":
            return cg.PenaltyLaw(each, damping=damper * self.log(-2, 0))
        if kind == "force":
            return cg.ForceLaw(k)
        if kind == "stress":
            area = deep**2 * u.length**2 + 1e-3 * u.length**2
            return cg.StressLaw(0.5 * k * u.length / area)
        x = np.array([0.0, 0.3, 0.7, 1.0, 1.2]) * deep * u.length
        if kind == "stiffening":
            return cg.ForceLaw(np.column_stack([x, k * x * [0, 0.3, 0.7, 2.0, 6.0]]))
        curve = np.column_stack([x, k * x])
        return cg.ForceLaw(
            curve, unloading=curve * [1.0, 0.4], hysteresis_slope=k * self.log(0.5, 1.5)
        )

    def friction(self) -> Any:
        """None, or sticking, or viscous."""
        kind = self.pick("smooth", "smooth", "coulomb", "viscous")
        if kind == "coulomb":
            return cg.Coulomb(self.rng.uniform(0.1, 0.8))
        if kind == "viscous":
            return cg.ViscousFriction(0.3, self.struck * self.log(-2, 0) * self.units.speed)
        return None

    def springs(self, bodies: dict[str, Any], top: float) -> list[cg.Spring]:
        """Up to two of them on what is free."""
        u, found = self.units, []
        free = [n for n, b in bodies.items() if isinstance(b, tuple) and hasattr(b[1], "spin")]
        for number in range(int(self.rng.integers(0, 3)) if free and self.chance(0.5) else 0):
            name = str(self.rng.choice(free))
            height = top + self.gap + 0.7 if name == "carrier" else 0.0
            at = np.array([0.0, 0.0, height]) + 0.3 * self.way()
            rate = 2.0 * np.pi / self.end * self.log(-0.7, 0.7)
            k = self.mass * rate**2 * u.stiffness
            damping = 2.0 * self.mass * rate * self.log(-2.5, -0.5) * u.mass / u.time
            law: dict[str, Any] = {"curve": k}
            kind = self.pick("spring", "damper", "rope", "belt")
            if kind == "damper":
                law = {"curve": k, "damping": damping}
            if kind == "rope":
                law = {"curve": [[-u.length, 0.0], [0.0, 0.0], [u.length, k * u.length]]}
            if kind == "belt":
                curve = np.array([[0.0, 0.0], [u.length, k * u.length]])
                law = {"curve": curve, "unloading": curve * [1.0, 0.4], "hysteresis_slope": 5.0 * k}
            ends = np.array([at, at + self.way() * self.rng.uniform(1.0, 3.0)]) * u.length
            found.append(cg.Spring((name, "ground"), at=ends, name=f"{kind} {number}", **law))
        return found

    def loads(self, bodies: dict[str, Any]) -> list[cg.Load]:
        """Up to two of them on what is free: short pulses, and what stays."""
        u, found = self.units, []
        free = [n for n, b in bodies.items() if isinstance(b, tuple) and hasattr(b[1], "spin")]
        for _ in range(int(self.rng.integers(0, 3)) if free and self.chance(0.5) else 0):
            impulse = self.mass * self.speed * self.log(-1, 0) * self.way()
            own = {"follow": self.chance(0.3)}
            if self.pick("pulse", "load") == "load":
                force = impulse / self.end * u.force
            else:
                wide = self.end * self.log(-4, -0.5)
                at = self.rng.uniform(0.0, self.end - wide)
                most = 2.0 * impulse / wide
                rows = [[0, *0 * most], [at, *0 * most], [at + 0.4 * wide, *most]]
                rows += [[at + wide, *0 * most], [2 * self.end, *0 * most]]
                force = np.array(rows[1:] if at == 0.0 else rows)
                force *= [u.time, u.force, u.force, u.force]
            found.append(cg.Load(str(self.rng.choice(free)), force=force, **own))
        return found
