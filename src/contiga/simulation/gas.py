"""Gas of a simulation: the volumes of its chambers, how it pushes nodes, what the history says."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import NamedTuple

import numpy as np

from contiga.arrays.ordered import row_lengths
from contiga.dynamics.gas import Chamber, Chambers, GasState
from contiga.dynamics.nodes import SlaveState
from contiga.errors import InputError, RunError
from contiga.records import FloatArray, IntArray
from contiga.slaves.slave import Slave

OF_GAS = ("pressure", "temperature", "volume", "mass", "flow_in", "flow_out")
"""Columns of a chamber; the last two are the enthalpies that came in and went out so far."""
SAME = 1e-9
"""Part of its own by which a chamber's volume may depend on where it is measured from."""


class ChamberState(NamedTuple):
    """A chamber at one time."""

    gas: GasState
    force: FloatArray
    """(k, 3) on the nodes of its facets."""


class Skin(NamedTuple):
    """The facets around a chamber."""

    rows: IntArray
    """(k,) nodes of the slave, ascending."""
    corners: IntArray
    """(f, 3) rows of these."""

    def volume(self, points: FloatArray) -> tuple[float, FloatArray]:
        """V = ⅙ Σ x₀·(x₁ × x₂) of facets with nodes at points (n, 3), and its gradient (k, 3)."""
        nodes = points[self.rows]
        # From their middle, for the digits: of a closed surface it makes no other difference.
        a, b, c = np.moveaxis((nodes - nodes.mean(axis=0))[self.corners], 1, 0)
        gradients = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=1) / 6.0
        volume = float((a * gradients[:, 0]).sum())
        total = np.zeros((len(self.rows), 3))
        for d in range(3):
            weights = gradients[:, :, d].ravel()
            total[:, d] = np.bincount(self.corners.ravel(), weights, minlength=len(total))
        return volume, total

    def area(self, points: FloatArray) -> float:
        """Of the facets."""
        a, b, c = np.moveaxis(points[self.rows][self.corners], 1, 0)
        return 0.5 * float(row_lengths(np.cross(b - a, c - a)).sum())

    def stiffness(self, points: FloatArray) -> FloatArray:
        """(k,) bounds of the row sums of ∂²V/∂x²: sides of facets over six."""
        a, b, c = np.moveaxis(points[self.rows][self.corners], 1, 0)
        sides = np.stack([row_lengths(c - b), row_lengths(a - c), row_lengths(b - a)], axis=1)
        whole = sides.sum(axis=1, keepdims=True) / 6.0
        both = np.broadcast_to(whole, sides.shape).ravel()
        sums = np.bincount(self.corners.ravel(), both, minlength=len(self.rows))
        return sums.astype(np.float64)


class GasSystem:
    """The chambers of a model.

    Raises
    ------
    InputError
        No slave of this name, facets that do not close a space or whose normals point into it.
    """

    def __init__(self, chambers: Mapping[str, Chamber], slaves: Mapping[str, Slave]) -> None:
        self.chambers = dict(chambers)
        self.names = tuple(chambers)
        self.skins = {name: _skin(name, chamber, slaves) for name, chamber in self.chambers.items()}

    @cached_property
    def physics(self) -> Chambers:
        """What flows between them."""
        return Chambers(list(self.chambers.values()))

    @cached_property
    def of_slave(self) -> Mapping[str, list[str]]:
        """Chambers in the facets of each slave."""
        names: dict[str, list[str]] = {}
        for name, chamber in self.chambers.items():
            names.setdefault(chamber.slave, []).append(name)
        return names

    def states(
        self,
        last: Mapping[str, ChamberState] | None,
        slaves: Mapping[str, SlaveState],
        time: float,
        dt: float,
        fired: Mapping[str, float],
    ) -> dict[str, ChamberState]:
        """All chambers where their nodes are now, after the `last` states; None at the start.

        `fired` are the times at which triggers fire, by their sensors.
        """
        volumes, gradients, areas = [], [], []
        for name, skin in self.skins.items():
            points = slaves[self.chambers[name].slave].points
            volume, gradient = skin.volume(points)
            if not 0.0 < volume < np.inf:
                raise RunError(
                    f"t = {time:g}: gas {name!r} has no room left: its facets hold a volume of "
                    f"{volume:.4g}. Look at what presses them together, at their material and at "
                    "the step; a flat bag needs a little volume at the start"
                )
            volumes.append(volume)
            gradients.append(gradient)
            areas.append(skin.area(points) if self.chambers[name].leak else 0.0)
        now = np.array(volumes)
        if last is None:
            gas = self.physics.start(now)
        else:
            before = [last[name].gas for name in self.names]
            gas = self.physics.step(before, now, np.array(areas), time, dt, fired)
        states = {}
        for name, state, gradient in zip(self.names, gas, gradients, strict=True):
            excess = state.pressure - self.chambers[name].surroundings.pressure
            states[name] = ChamberState(state, excess * gradient)
        return states

    def came(self, last: Mapping[str, ChamberState], now: Mapping[str, ChamberState]) -> float:
        """Enthalpy that has come in within a step, less what went out."""
        return sum(
            (now[name].gas.came - last[name].gas.came) - (now[name].gas.left - last[name].gas.left)
            for name in self.names
        )

    def columns(self, states: Mapping[str, ChamberState]) -> dict[str, float]:
        """What a row of the history says of all chambers: ``<gas>.pressure`` and so on."""
        columns: dict[str, float] = {}
        for name, (gas, _) in states.items():
            values = (
                gas.pressure,
                gas.temperature,
                gas.volume,
                float(gas.masses.sum()),
                gas.came,
                gas.left,
            )
            columns |= {f"{name}.{c}": v for c, v in zip(OF_GAS, values, strict=True)}
        return columns


def _skin(name: str, chamber: Chamber, slaves: Mapping[str, Slave]) -> Skin:
    where = f"gas {name!r}: slave"
    if chamber.slave not in slaves:
        raise InputError(
            "no slave of this name is there",
            where=where,
            found=chamber.slave,
            allowed=", ".join(map(repr, slaves)),
        )
    slave = slaves[chamber.slave]
    if slave.facets is None or len(slave.facets) == 0:
        raise InputError("has no facets around a chamber", where=where, found=chamber.slave)
    rows, inverse = np.unique(slave.facets, return_inverse=True)
    corners = inverse.reshape(slave.facets.shape).astype(np.int32)
    sides = np.stack([corners, np.roll(corners, -1, axis=1)], axis=2).reshape(-1, 2)
    ordered = {tuple(side) for side in sides.tolist()}
    lone = [side for side in sides.tolist() if (side[1], side[0]) not in ordered]
    if lone or len(ordered) < len(sides):
        first = lone[0] if lone else sides[0].tolist()
        ends = slave.points[rows[first]].round(6).tolist()
        what = f"{len(lone)} sides of facets are open" if lone else "facets are there twice"
        raise InputError(
            f"its facets do not close a space: {what}, the first from {ends[0]} to {ends[1]}",
            where=where,
            found=chamber.slave,
            remedy="Sew the facets together, all normals outward, or choose a part that is closed",
        )
    skin = Skin(rows.astype(np.int32), corners)
    volume, _ = skin.volume(slave.points)
    if not volume > 0.0:
        raise InputError(
            "the normals of its facets point into the chamber, or it has no volume",
            where=where,
            found=f"a volume of {volume:.4g}",
            remedy="Turn the facets round, or give the bag a little volume at the start",
        )
    return skin
