"""Bodies and nodes that move by the forces on them, or are fixed to other bodies."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from copy import copy
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from contiga.arrays.layout import as_numbers, positive, read_only, real
from contiga.dynamics.holding import names_held
from contiga.dynamics.nodes import CarriedNodes, FreeNodes, NodeMover
from contiga.dynamics.prescribed import is_still
from contiga.errors import InputError
from contiga.records import FloatArray, MassProperties
from contiga.rigid.inertia import check_inertia
from contiga.rigid.transform import vector
from contiga.slaves.slave import Slave

HOLDS = ("x", "y", "z", "rx", "ry", "rz")
"""What can be held of a free body: ways along the world's axes and turns about them."""


Number = Callable[[str], int]
"""The number of the body that one of a name is fixed to in the end: itself where it is not."""


class Dependent:
    """A motion that nothing tells beforehand: forces decide it, or another body."""

    @property
    def hosts(self) -> tuple[str, ...]:
        """Names of the bodies that it stands on, or nodes of it do."""
        return ()

    def nodes(self, where: str, slave: Slave, number: Number) -> NodeMover:
        """Return the mover of the nodes of `slave`; `where` is for messages.

        Raises
        ------
        InputError
            It cannot.
        """
        raise NotImplementedError

    def resting(self, time: float) -> Dependent:
        """Return the motion at rest, with what changes over time as it is at `time`."""
        return self


def is_driven(motion: object) -> bool:
    """Return whether a motion is prescribed and not known to be at rest."""
    return not (isinstance(motion, Dependent) or is_still(motion))


@dataclass(frozen=True, init=False, eq=False)
class Free(Dependent):
    """A rigid body, or the nodes of a slave, that the forces on them move.

    Parameters
    ----------
    mass : of the body; or all its `MassProperties`, as `body.mass_properties(density)` gives them.
        Of a slave: of each node, one number or (n,); the slave's own if omitted
    inertia : (3, 3) about the centre, in the axes of the body
    centre : (3,) of mass, in the axes of the body: those of its placed geometry
    velocity : (3,) of the centre at the start, world axes; of a slave's nodes (3,) or (n, 3)
    spin : (3,) at the start, world axes, radians a time
    hold : of x, y, z (ways of the centre) and rx, ry, rz (turns), world axes: what stays as it is

    Raises
    ------
    InputError
        No mass, an inertia that is none, a velocity or spin along what is held.

    Notes
    -----
    Nodes have no inertia, centre or spin, and nothing of them is held.

    Examples
    --------
    >>> import contiga as cg
    >>> cg.motion.Free(mass=2.0, inertia=np.eye(3), velocity=[0, 0, -1.0], hold=["x"]).hold
    ('x',)
    """

    mass: float | FloatArray | None
    inertia: FloatArray | None
    centre: FloatArray | None
    velocity: FloatArray
    spin: FloatArray
    hold: tuple[str, ...]

    def __init__(
        self,
        mass: float | MassProperties | ArrayLike | None = None,
        *,
        inertia: ArrayLike | None = None,
        centre: ArrayLike | None = None,
        velocity: ArrayLike = (0.0, 0.0, 0.0),
        spin: ArrayLike = (0.0, 0.0, 0.0),
        hold: Iterable[str] = (),
    ) -> None:
        if isinstance(mass, MassProperties):
            if inertia is not None or centre is not None:
                raise InputError(
                    "are given twice",
                    where="inertia" if inertia is not None else "centre",
                    allowed="mass properties, or mass with inertia and centre",
                )
            properties = mass
            mass, centre, inertia = properties.mass, properties.centre, properties.inertia
        put = object.__setattr__
        put(self, "mass", _mass(mass))
        put(self, "inertia", None if inertia is None else check_inertia(inertia, "inertia"))
        put(self, "centre", None if centre is None else read_only(vector(centre, "centre")))
        put(self, "velocity", _velocity(velocity))
        put(self, "spin", read_only(vector(spin, "spin")))
        put(self, "hold", names_held(hold, HOLDS, "hold"))
        moving = np.broadcast_to(self.velocity, (3,)) if self.velocity.ndim == 1 else np.zeros(3)
        for name, rate in zip(HOLDS, (*moving, *self.spin), strict=True):
            if name in self.hold and rate != 0.0:
                raise InputError(
                    "is held, and starts moving that way",
                    where=f"hold: {name}",
                    found=float(rate),
                    allowed="velocity and spin of zero along what is held",
                )

    def resting(self, time: float) -> Free:
        """Return the motion with nothing in motion."""
        still = copy(self)
        object.__setattr__(still, "velocity", read_only(np.zeros(3)))
        object.__setattr__(still, "spin", read_only(np.zeros(3)))
        return still

    def nodes(self, where: str, slave: Slave, number: Number) -> NodeMover:
        """Each a mass: of this motion, else the slave's own."""
        if self.inertia is not None or self.centre is not None or self.hold:
            raise InputError(
                "nodes have a mass and a velocity only",
                where=where,
                found="inertia, centre or hold",
                allowed="Free(mass=…, velocity=…)",
            )
        masses = _nodal_masses(where, slave, slave.mass if self.mass is None else self.mass)
        if self.velocity.ndim == 2 and len(self.velocity) != len(slave):
            raise InputError(
                "expected one velocity, or one for each node",
                where=where,
                found=self.velocity.shape,
                allowed=f"(3,) or ({len(slave)}, 3)",
            )
        return FreeNodes(masses, slave.points, self.velocity, self)


@dataclass(frozen=True)
class Attached(Dependent):
    """A body, or the points of a slave, that are fixed to another body and go where that goes.

    What they feel that body feels. Their geometry stands in the axes of that body's.

    Parameters
    ----------
    body : its name
    mass : of a body that is attached, in the axes of both: a free body carries it as its own
    """

    body: str
    mass: MassProperties | None = None

    @property
    def hosts(self) -> tuple[str, ...]:
        """The body that it is attached to."""
        return (self.body,)

    def __post_init__(self) -> None:
        if not isinstance(self.mass, MassProperties | None):
            raise InputError(
                "must be mass properties",
                where="Attached(mass)",
                found=type(self.mass).__name__,
                allowed="MassProperties, as body.mass_properties(density) answers",
            )
        if not isinstance(self.body, str) or not self.body:
            raise InputError("must be the name of a body", where="Attached(body)", found=self.body)

    def nodes(self, where: str, slave: Slave, number: Number) -> NodeMover:
        """Fixed to the body."""
        return CarriedNodes(number(self.body), slave.points, self)


def _nodal_masses(where: str, slave: Slave, given: float | FloatArray | None) -> FloatArray:
    """Return the masses (n,) of all nodes."""
    if given is None:
        raise InputError(
            "free nodes need masses and the slave has none",
            where=where,
            remedy="Give Free(mass=…), or the slave its nodal masses",
        )
    if np.ndim(given) and len(np.atleast_1d(given)) != len(slave):
        raise InputError(
            "expected one mass for each node",
            where=where,
            found=np.shape(given),
            allowed=f"({len(slave)},)",
        )
    masses = np.broadcast_to(np.asarray(real(given, where), dtype=np.float64), (len(slave),)).copy()
    if not (masses > 0.0).all():
        bare = int(np.count_nonzero(~(masses > 0.0)))
        raise InputError(
            f"{bare} free nodes have no mass",
            where=where,
            found=f"first at node {int(np.argmin(masses > 0.0))}",
            allowed="above zero at every node",
        )
    return masses


def _mass(mass: float | ArrayLike | None) -> float | FloatArray | None:
    """Return one number, or one by node, checked."""
    if mass is None or np.ndim(mass) == 0:
        return None if mass is None else positive(mass, "mass")
    each = as_numbers(mass, "mass")
    if each.ndim != 1 or not (np.isfinite(each).all() and (each > 0.0).all()):
        raise InputError(
            "must be finite and above zero at every node", where="mass", found=each.shape
        )
    return read_only(each)


def _velocity(velocity: ArrayLike) -> FloatArray:
    vectors = as_numbers(velocity, "velocity")
    if vectors.ndim not in (1, 2) or vectors.shape[-1] != 3 or not np.isfinite(vectors).all():
        raise InputError(
            "must be finite numbers",
            where="velocity",
            found=vectors.shape,
            allowed="(3,), or (n, 3) of the nodes of a slave",
        )
    return read_only(vectors)
