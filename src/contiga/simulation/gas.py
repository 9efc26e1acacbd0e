"""Couple gas to slaves: volumes of chambers, forces on nodes, and columns of the history."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.arrays.layout import locked
from contiga.arrays.threads import run_ranges
from contiga.contact.contact import Contact
from contiga.contact.state import State
from contiga.dynamics.gas import Chamber, Chambers, Exposed, GasState
from contiga.dynamics.kernels.closed_skin_nb import AT_NODES, measure_facets, sum_at_nodes
from contiga.dynamics.nodes import SlaveState
from contiga.dynamics.places import box_text, facets_at, place_of
from contiga.errors import InputError, RunError
from contiga.jit import straight
from contiga.matter.blocks import NodeSums, count_blocks, node_sums, nodes_in_lanes
from contiga.matter.kernels.lanes_nb import LANES
from contiga.records import FloatArray, IntArray
from contiga.slaves.slave import Slave

GAS_COLUMNS = ("pressure", "temperature", "volume", "mass", "flow_in", "flow_out")
"""Columns of a chamber; the last two are the enthalpies that have flowed in and out so far."""
BLOCKS, NODES = 32, 4096
"""Fewest blocks of facets, and nodes, for one thread."""
MAX_PLACES = 4
"""Largest number of places that a message names."""
CoveredShares = Callable[[str], FloatArray]
"""Function from the name of a slave to the share (f,) of each of its facets that bodies cover."""


class ChamberState(NamedTuple):
    """The state of a chamber at one time."""

    gas: GasState
    force: FloatArray
    """(k, 3) on the nodes of its facets."""


class Closed(NamedTuple):
    """The volume that facets enclose, and its derivatives with respect to the nodes."""

    volume: float
    gradient: FloatArray
    """(k, 3) of the volume."""
    stiffness: FloatArray
    """(k,) bounds of the row sums of ∂²V/∂x²: sides of facets over six."""
    areas: FloatArray
    """(f,) of the facets."""


class SkinTables(NamedTuple):
    """Connectivity of the facets around a chamber, as kernels need it."""

    corners: IntArray
    """(b, 3, LANES) nodes of the slave; degenerate facets fill up the last block."""
    sums: NodeSums
    """Facets at each node."""


@dataclass(frozen=True, eq=False)
class Skin:
    """The facets around a chamber."""

    rows: IntArray
    """(k,) nodes of the slave, ascending."""
    corners: IntArray
    """(f, 3) rows of these."""
    vents: tuple[NDArray[np.bool_] | None, ...] = ()
    """(f,) mask of the facets of each vent; None for a vent without facets."""

    @cached_property
    def _tables(self) -> SkinTables:
        count = len(self.corners)
        padded = np.zeros((count_blocks(count) * LANES, 3), np.int32)
        padded[:count] = self.rows[self.corners]
        starts, places = node_sums(self.corners.ravel(), len(self.rows))
        facets = (places // 3).astype(np.int32)
        return SkinTables(nodes_in_lanes(padded), NodeSums(starts, facets))

    def closed(self, points: FloatArray) -> Closed:
        """Return the enclosed volume, its gradient and stiffness at nodes, and the areas of facets.

        `points` (n, 3) are those of all nodes of the slave.
        """
        corners, (starts, rows) = self._tables
        blocks, count = len(corners), len(self.rows)
        facets, areas = np.empty((blocks * LANES, AT_NODES)), np.empty((blocks, LANES))
        volumes, points = np.empty(blocks), locked(np.ascontiguousarray(points, np.float64))
        by_block = points, corners, facets.reshape(blocks, LANES, AT_NODES), areas, volumes
        run_ranges(straight(measure_facets), blocks, BLOCKS, *by_block)
        gradient, stiffness = np.empty((count, 3)), np.empty(count)
        at_nodes = facets, starts, rows, gradient, stiffness
        run_ranges(straight(sum_at_nodes), count, NODES, *at_nodes)
        volume = float(volumes.sum())
        return Closed(volume, gradient, stiffness, areas.reshape(-1)[: len(self.corners)])

    def exposed(self, areas: FloatArray, covered: FloatArray) -> Exposed:
        """Return the open area of all facets, and the open share (v,) of each vent.

        `areas` (f,) are those of the facets, `covered` (f,) the shares that are covered. A vent
        without facets is open: 1.
        """
        open_areas = areas * (1.0 - covered)
        shares = [
            1.0 if in_vent is None else float(open_areas[in_vent].sum() / areas[in_vent].sum())
            for in_vent in self.vents
        ]
        return Exposed(float(open_areas.sum()), np.array(shares))


class GasSystem:
    """The chambers of a model.

    Raises
    ------
    InputError
        An unknown slave, facets that do not close a space or whose normals point into it, two
        chambers in the same facets, a vent without facets.
    """

    def __init__(self, chambers: Mapping[str, Chamber], slaves: Mapping[str, Slave]) -> None:
        self.chambers = dict(chambers)
        self.names = tuple(chambers)
        gas_of_slave: dict[str, str] = {}
        for name, chamber in chambers.items():
            if chamber.slave in gas_of_slave:
                raise InputError(
                    f"gas {gas_of_slave[chamber.slave]!r} fills these facets already",
                    where=f"gas {name!r}: slave",
                    found=chamber.slave,
                    remedy="Give each chamber a slave of its own, or one chamber both inflators",
                )
            gas_of_slave[chamber.slave] = name
        self.skins = {
            name: _make_skin(name, chamber, slaves) for name, chamber in self.chambers.items()
        }
        self._last: dict[str, tuple[FloatArray, Closed]] = {}

    @cached_property
    def physics(self) -> Chambers:
        """The gas model: states of the gas, and the flow between the chambers."""
        return Chambers(list(self.chambers.values()))

    @cached_property
    def of_slave(self) -> Mapping[str, list[str]]:
        """Names of the chambers in each slave, by its name; slaves without any are left out."""
        names: dict[str, list[str]] = {}
        for name, chamber in self.chambers.items():
            names.setdefault(chamber.slave, []).append(name)
        return names

    def closed(self, name: str, points: FloatArray) -> Closed:
        """Return the result of `Skin.closed` for a chamber by name: volume, derivatives and areas.

        The last result is kept: a step and its critical length need it for the same nodes.
        """
        last = self._last.get(name)
        if last is None or last[0] is not points:
            last = self._last[name] = points, self.skins[name].closed(points)
        return last[1]

    def states(
        self,
        last: Mapping[str, ChamberState] | None,
        slaves: Mapping[str, SlaveState],
        covered: CoveredShares,
        time: float,
        dt: float,
        fired: Mapping[str, float],
    ) -> dict[str, ChamberState]:
        """Return all chambers after a step from their `last` states, which are None at the start.

        `covered` is asked only for slaves of chambers that leak or have vents on facets. `fired`
        are the times at which triggers fire, by sensor.

        Raises
        ------
        RunError
            The facets of a chamber hold no volume.
        """
        volumes, gradients, exposed = [], [], []
        for name, skin in self.skins.items():
            points = slaves[self.chambers[name].slave].points
            volume, gradient, _, areas = self.closed(name, points)
            if not 0.0 < volume < np.inf:
                raise RunError(
                    f"t = {time:g}: gas {name!r} has no room left: its facets hold a volume of "
                    f"{volume:.4g}. Look at what presses them together, at their material and at "
                    "the step; a flat bag needs a little volume at the start"
                )
            volumes.append(volume)
            gradients.append(gradient)
            if self.chambers[name].leaks or any(on is not None for on in skin.vents):
                exposed.append(skin.exposed(areas, covered(self.chambers[name].slave)))
            else:
                exposed.append(Exposed(0.0, np.ones(len(skin.vents))))
        now = np.array(volumes)
        if last is None:
            gas = self.physics.start(now)
        else:
            before = [last[name].gas for name in self.names]
            gas = self.physics.step(before, now, exposed, time, dt, fired)
        states = {}
        for name, state, gradient in zip(self.names, gas, gradients, strict=True):
            excess = state.pressure - self.chambers[name].surroundings.pressure
            states[name] = ChamberState(state, excess * gradient)
        return states

    def first_states(self, at_rest: Mapping[str, ChamberState]) -> dict[str, ChamberState]:
        """Return the chambers at the start of a run that begins from a state at rest.

        Vents are as at the start again, energies count from there.
        """
        states = {}
        for name, (gas, force) in at_rest.items():
            chamber = self.chambers[name]
            enthalpy = gas.energy + chamber.surroundings.pressure * gas.volume
            first = gas._replace(is_open=chamber.open_at_start, stored=0.0, at_start=enthalpy)
            states[name] = ChamberState(first, force)
        return states

    def came(self, last: Mapping[str, ChamberState], now: Mapping[str, ChamberState]) -> float:
        """Return the enthalpy that flowed into all chambers within a step, less that flowed out."""
        return sum(
            (now[name].gas.came - last[name].gas.came) - (now[name].gas.left - last[name].gas.left)
            for name in self.names
        )

    def columns(self, states: Mapping[str, ChamberState]) -> dict[str, float]:
        """Return the history columns of all chambers by name: ``<gas>.pressure`` and so on."""
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
            columns |= {f"{name}.{c}": v for c, v in zip(GAS_COLUMNS, values, strict=True)}
        return columns


def _make_skin(name: str, chamber: Chamber, slaves: Mapping[str, Slave]) -> Skin:
    """Return the facets around a chamber, all those of its slave, with a mask (f,) for each vent.

    Raises
    ------
    InputError
        No such slave, no facets, facets that do not close a space or point into it, a vent that no
        facet lies on with all its corners.
    """
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
    _check_closed(where, chamber.slave, corners, slave.points[rows])
    vents = []
    for k, vent in enumerate(chamber.vents):
        at = f"gas {name!r}: vents[{k}]: on"
        on = None
        if vent.on is not None:
            key = place_of(vent.on, (), at)
            on = facets_at(key, vent.on[key or ""], slave, at)
            if not on.any():
                raise InputError(
                    "the vent is on no fabric: no facet has all its corners there",
                    where=at,
                    found=vent.on,
                    allowed=f"a larger place; the slave reaches {box_text(slave.points)}",
                )
        vents.append(on)
    skin = Skin(rows.astype(np.int32), corners, tuple(vents))
    volume = skin.closed(slave.points).volume
    if not volume > 0.0:
        raise InputError(
            "the normals of its facets point into the chamber, or it has no volume",
            where=where,
            found=f"a volume of {volume:.4g}",
            remedy="Turn the facets round, or give the bag a little volume at the start",
        )
    return skin


def _check_closed(where: str, slave: str, corners: IntArray, points: FloatArray) -> None:
    """Refuse facets with edges that are open, shared by more than two, or with opposing normals.

    Raises
    ------
    InputError
        The message is about the first of these defects: the number of edges and up to `MAX_PLACES`
        places.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    sides = np.stack([corners, np.roll(corners, -1, axis=1)], axis=2).reshape(-1, 2)
    ends, kind = np.unique(np.sort(sides, axis=1), axis=0, return_inverse=True)
    count = np.bincount(kind.ravel(), minlength=len(ends))
    forward = np.bincount(kind.ravel()[sides[:, 0] < sides[:, 1]], minlength=len(ends))
    for is_wrong, defect, remedy in (
        (count == 1, "are open", "Sew the facets together, or choose a part that is closed"),
        (count > 2, "join more than two facets", "Leave out what is there twice or inside"),
        (forward * 2 != count, "join facets whose normals disagree", "Turn facets outward"),
    ):
        if not is_wrong.any():
            continue
        _, holes = connected_components(
            coo_array((np.ones(is_wrong.sum()), ends[is_wrong].T), shape=(len(points),) * 2)
        )
        label = holes[ends[is_wrong, 0]]
        places = [ends[is_wrong][label == hole] for hole in np.unique(label)]
        texts = [f"{len(edges)} {box_text(points[edges.ravel()])}" for edges in places[:MAX_PLACES]]
        more_text = (
            f", and at {len(places) - MAX_PLACES} more places" if len(places) > MAX_PLACES else ""
        )
        raise InputError(
            f"its facets do not close a space: {is_wrong.sum()} sides {defect}: "
            f"{'; '.join(texts)}{more_text}",
            where=where,
            found=slave,
            remedy=f"{remedy}, all normals outward",
        )


def covered_by(contacts: Iterable[tuple[Contact, State]], slave: Slave) -> FloatArray:
    """Return the share (f,) of each facet of a slave that its contacts cover together, at most 1.

    `contacts` are those of the slave.
    """
    assert slave.facets is not None
    shares = np.zeros(len(slave.facets))
    for contact, state in contacts:
        shares += contact.covered(state)
    return np.minimum(shares, 1.0)
