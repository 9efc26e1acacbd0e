"""Materials in SI units, and a ball that is pressed into a block, a sheet or bars of one."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

import contiga as cg
from contiga.io.units import base_factor
from contiga.materials import Belt, Elastic, Fabric, Foam, NeoHooke
from contiga.matter.skin import skin

SYSTEMS = {
    "mm-g-ms": ("mm", "g", "ms"),
    "mm-kg-ms": ("mm", "kg", "ms"),
    "m-kg-s": ("m", "kg", "s"),
    "mm-t-s": ("mm", "t", "s"),
}


class Units(NamedTuple):
    """How many units of a case one SI unit is."""

    length: float
    mass: float
    time: float

    @classmethod
    def of(cls, names: tuple[str, str, str]) -> Units:
        of = ("length", "mass", "time")
        return cls(*(1.0 / base_factor(*one) for one in zip(names, of, strict=True)))

    @property
    def stress(self) -> float:
        return self.mass / self.length / self.time**2

    @property
    def density(self) -> float:
        return self.mass / self.length**3

    @property
    def force(self) -> float:
        return self.mass * self.length / self.time**2


class Matter(NamedTuple):
    """A material in SI units, made for a case in others."""

    density: float
    made: Callable[[Units], object]
    kind: str = "hexahedron"
    across: float = 0.0
    """Thickness or section."""


def foam(density: float, *rows: tuple[float, float], **more: float) -> Matter:
    def made(units: Units) -> object:
        return Foam(loading=np.array([(0.0, 0.0), *rows]) * [1.0, units.stress], **more)

    return Matter(density, made)


def with_rates(density: float, rows: list[tuple[float, float]], *rates: float) -> Matter:
    def made(units: Units) -> object:
        table = np.array([(0.0, 0.0), *rows]) * [1.0, units.stress]
        faster = [(rate / units.time, table * [1.0, 1.2 + 0.1 * k]) for k, rate in enumerate(rates)]
        return Foam(loading=table, rates=faster, filter=1e-4 * units.time)

    return Matter(density, made)


def elastic(density: float, young: float, poisson: float, **more: object) -> Matter:
    return Matter(
        density, lambda units: Elastic(young=young * units.stress, poisson=poisson), **more
    )


def rubber(density: float, young: float, poisson: float, volume="element", **more) -> Matter:
    def made(units: Units) -> object:
        return NeoHooke(young=young * units.stress, poisson=poisson, volume=volume)

    return Matter(density, made, **more)


def fabric(density: float, thickness: float, *rows: tuple[float, float]) -> Matter:
    def made(units: Units) -> object:
        warp = np.array([(0.0, 0.0), *rows]) * [1.0, units.stress]
        return Fabric(warp=warp, shear=5e6 * units.stress, direction=[1, 0, 0])

    return Matter(density, made, "triangle", thickness)


def belt(density: float, section: float, *rows: tuple[float, float]) -> Matter:
    def made(units: Units) -> object:
        return Belt(loading=np.array([(0.0, 0.0), *rows]) * [1.0, units.force])

    return Matter(density, made, "line", section)


EPP = [(0.05, 1.5e5), (0.5, 2.8e5), (0.9, 3e6)]
MATTER = {
    "EPS of 15 kg/m³": foam(15.0, (0.03, 7e4), (0.5, 1.3e5), (0.7, 4e5)),
    "EPS of 30": foam(30.0, (0.03, 1.8e5), (0.5, 2.9e5), (0.7, 9e5)),
    "EPS of 90, of a helmet": foam(90.0, (0.03, 9e5), (0.5, 1.6e6), (0.8, 1e7)),
    "EPP of 20": foam(20.0, (0.05, 5e4), (0.5, 1.1e5), (0.9, 1.2e6)),
    "EPP of 60": foam(60.0, *EPP),
    "EPP of 60 that unloads by less": foam(60.0, *EPP, hysteresis=0.1, shape=8.0),
    "EPP of 60 with rates": with_rates(60.0, EPP, 1.0, 10.0, 100.0),
    "EPP of 60 with the rates of bars": with_rates(60.0, EPP, 100.0, 3000.0),
    "EPP of 200": foam(200.0, (0.05, 1.6e6), (0.5, 3.2e6), (0.8, 2e7)),
    "PU of a seat": foam(45.0, (0.08, 3e3), (0.5, 5e3), (0.8, 4e4)),
    "PU that remembers": foam(50.0, (0.1, 8e2), (0.5, 1.6e3), (0.85, 2e4)),
    "PU that is rigid": foam(100.0, (0.04, 7e5), (0.5, 9e5), (0.75, 5e6)),
    "melamine of 10": foam(10.0, (0.08, 6e3), (0.5, 9e3), (0.8, 5e4)),
    "PE of 24": foam(24.0, (0.1, 2e4), (0.5, 9e4), (0.8, 5e5)),
    "EVA of a sole": foam(130.0, (0.1, 1e5), (0.5, 4e5), (0.8, 3e6)),
    "neoprene sponge": foam(200.0, (0.2, 3e4), (0.5, 1.2e5), (0.8, 1e6)),
    "PVC foam of 80": foam(80.0, (0.02, 1.2e6), (0.5, 1.5e6), (0.7, 6e6)),
    "PMI foam of 110": foam(110.0, (0.03, 3e6), (0.5, 3.6e6), (0.7, 1.2e7)),
    "aluminium foam": foam(400.0, (0.02, 7e6), (0.5, 1.1e7), (0.65, 4e7)),
    "honeycomb": foam(83.0, (0.005, 2.3e6), (0.7, 2.4e6), (0.75, 2e7)),
    "foam by a modulus": foam(60.0, (1.0, 1e6)),
    "foam whose last row stands far off": foam(60.0, *EPP, (5.0, 1e8)),
    "natural rubber": rubber(950.0, 1.5e6, 0.49),
    "silicone, tetrahedra": rubber(1100.0, 4e5, 0.495, "nodes", kind="tetra"),
    "EPDM, tetrahedra": rubber(1100.0, 5e6, 0.45, kind="tetra"),
    "rubber of a tyre": rubber(1150.0, 8e6, 0.499),
    "rubber full of lead": rubber(4000.0, 6e6, 0.48),
    "gelatine of 20 %": rubber(1060.0, 1e5, 0.4999),
    "gelatine of 10 %, tetrahedra": rubber(1030.0, 1e4, 0.499, "nodes", kind="tetra"),
    "brain": rubber(1040.0, 3e3, 0.4995),
    "fat": rubber(920.0, 2e3, 0.49),
    "muscle": elastic(1060.0, 4e4, 0.45),
    "gel": rubber(1000.0, 6e2, 0.49),
    "steel": elastic(7850.0, 2.1e11, 0.3),
    "steel, tetrahedra": elastic(7850.0, 2.1e11, 0.3, kind="tetra"),
    "aluminium": elastic(2700.0, 7e10, 0.33),
    "lead": elastic(11340.0, 1.6e10, 0.44),
    "tungsten": elastic(19300.0, 4.1e11, 0.28),
    "beryllium": elastic(1850.0, 2.9e11, 0.03),
    "diamond": elastic(3520.0, 1.1e12, 0.07),
    "PMMA": elastic(1190.0, 3e9, 0.37),
    "balsa along its grain": elastic(150.0, 4e9, 0.2),
    "cork": elastic(180.0, 2e7, 0.0),
    "nylon of an airbag": fabric(800.0, 3.5e-4, (1.0, 3.8e8)),
    "nylon with crimp": fabric(800.0, 3.5e-4, (0.02, 1e6), (0.1, 2.5e7), (0.3, 1e8)),
    "stretch cloth": fabric(400.0, 6e-4, (0.3, 1e5), (1.2, 1e6), (2.5, 2e7)),
    "linen": fabric(700.0, 1e-3, (1.0, 2e8)),
    "PET film": elastic(1390.0, 4e9, 0.38, kind="triangle", across=5e-5),
    "latex balloon": rubber(950.0, 1.2e6, 0.49, kind="triangle", across=3e-4),
    "steel foil": elastic(7850.0, 2.1e11, 0.3, kind="triangle", across=1e-4),
    "webbing": belt(1100.0, 5.8e-5, (0.03, 2.5e3), (0.06, 6e3), (0.12, 1.1e4)),
    "bungee cord": belt(950.0, 1e-4, (0.5, 1e2), (1.0, 1.5e2), (2.0, 4e2)),
    "steel cable": elastic(7850.0, 1e11, 0.0, kind="line", across=2e-5),
}  # fmt: skip


def mesh(kind: str, n: int, scale: float) -> cg.Slave:
    """A block of 40 mm, a sheet or a row of bars, its top at z = 0."""
    if kind == "line":
        x = np.linspace([-0.04, 0.0, 0.0], [0.04, 0.0, 0.0], 2 * n + 1) * scale
        rows = np.stack([np.arange(2 * n), np.arange(1, 2 * n + 1)], axis=1)
        return cg.Slave(x, area=np.full(len(x), 1e-4 * scale**2), elements={"line": rows})
    counts = np.array([n, n, 0 if kind == "triangle" else n]) + 1
    axes = [np.linspace(-0.02, 0.02, k) for k in counts[:2]]
    axes.append(np.linspace(-0.04, 0.0, counts[2]) if counts[2] > 1 else np.zeros(1))
    x = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3) * scale
    grid = np.arange(len(x)).reshape(counts)
    if kind == "triangle":
        a, b, c, d = (grid[i : i + n, j : j + n, 0].ravel() for i, j in
                      ((0, 0), (1, 0), (1, 1), (0, 1)))  # fmt: skip
        rows = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
        return cg.Slave(x, rows)
    corners = (
        (0, 0, 0),
        (1, 0, 0),
        (1, 1, 0),
        (0, 1, 0),
        (0, 0, 1),
        (1, 0, 1),
        (1, 1, 1),
        (0, 1, 1),
    )
    rows = np.stack([grid[a : a + n, b : b + n, c : c + n].ravel() for a, b, c in corners], axis=1)
    if kind == "hexahedron":
        return cg.Slave(x, skin([("hex8", rows)]), elements={kind: rows})
    six = ((0, 1, 2, 6), (0, 2, 3, 6), (0, 3, 7, 6), (0, 7, 4, 6), (0, 4, 5, 6), (0, 5, 1, 6))
    rows = np.concatenate([rows[:, k] for k in six])
    return cg.Slave(x, skin([("tet4", rows)]), elements={kind: rows})


def pressed(
    matter: Matter, units: Units, names=("", "", ""), n=3, deep=5e-3, **other
) -> cg.Simulation:
    """A ball of 30 mm that comes down on it at 2 m/s, and goes back."""
    slave = mesh(matter.kind, n, units.length)
    across = {"triangle": "thickness", "line": "section"}.get(matter.kind)
    power = {"thickness": 1, "section": 2}.get(str(across), 0)
    options = {across: matter.across * units.length**power} if across else {}
    place = {"nodes": [0, len(slave) - 1]} if power else {"layer": ([0, 0, -1], 0.0)}
    options |= {"material": matter.made(units), "density": matter.density * units.density}
    motion = cg.motion.Deforming(**{"fixed": place} | options | other)
    ball = cg.Body(
        [cg.shapes.sphere(radius=0.03 * units.length, centre=(0, 0, 0.0302 * units.length))]
    )
    turn, deepest = (deep + 2e-4) / 2.0 * units.time, (deep + 2e-4) * units.length
    way = cg.motion.Translate([[0, 0, 0, 0], [turn, 0, 0, -deepest], [2 * turn, 0, 0, 0]])
    stiff = 1e9 * units.stress / units.length
    if power < 2:
        stiff = 0.3 * motion.contact_stiffness(slave)
    contact = cg.Contact(
        ball,
        slave,
        law=cg.PenaltyLaw(stiff, per_area=True),
        quadrature="nodes" if power == 2 else 3,
    )
    return cg.Simulation(
        bodies={"ball": (ball, way)},
        slaves={"pad": (slave, motion)},
        contacts=[contact],
        end=2.0 * turn,
        step="auto",
        units=names,
    )
