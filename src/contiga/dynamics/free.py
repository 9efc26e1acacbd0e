"""Bodies and nodes that move by the forces on them, or are fixed to other bodies."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from copy import copy
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from contiga.arrays.layout import as_numbers, positive, read_only, real
from contiga.dynamics.holding import held_names
from contiga.dynamics.nodes import CarriedNodes, FreeNodes, NodeMover
from contiga.dynamics.prescribed import is_still
from contiga.errors import InputError
from contiga.records import FloatArray, MassProperties
from contiga.rigid.inertia import check_inertia
from contiga.rigid.transform import vector
from contiga.slaves.slave import Slave

HOLDS = ("x", "y", "z", "rx", "ry", "rz")
"""Degrees of freedom of a free body: translations along the world's axes, rotations about them."""


Number = Callable[[str], int]
"""Number of the body, by name, that a body is fixed to in the end: its own if it is not fixed."""


class Dependent:
    """A motion that is not prescribed: it follows from forces or from another body."""

    @property
    def hosts(self) -> tuple[str, ...]:
        """Names of the bodies that it, or some of its nodes, are fixed to."""
        return ()

    def nodes(self, where: str, slave: Slave, number: Number) -> NodeMover:
        """Return the mover of the nodes of `slave`; `where` is for messages.

        Raises
        ------
        InputError
            The motion does not fit the slave.
        """
        raise NotImplementedError

    def resting(self, time: float) -> Dependent:
        """Return the motion for coming to rest, with loads and motions stopped at `time`.

        Here it is `self`; subclasses with velocities, loads or motions return a copy.
        """
        return self


def is_driven(motion: object) -> bool:
    """Return whether a motion is prescribed and moves; True for one of which it is not known."""
    return not (isinstance(motion, Dependent) or is_still(motion))


@dataclass(frozen=True, init=False, eq=False)
class Free(Dependent):
    """A rigid body, or the nodes of a slave, moved by forces.

    Parameters
    ----------
    mass : mass of the body, or its `MassProperties` from `body.mass_properties(density)`. For a
        slave the mass of each node, one number or (n,); the slave's masses if omitted
    inertia : (3, 3) about the centre of mass, in the axes of the body
    centre : (3,) centre of mass, in the axes of the body, which are those of its placed geometry
    velocity : (3,) of the centre of mass at the start, world axes; for nodes (3,) or (n, 3)
    spin : (3,) at the start, world axes, radians / time
    hold : degrees of freedom without motion, world axes: x, y, z (of the centre of mass) and rx,
        ry, rz (rotations)

    Raises
    ------
    InputError
        No mass, an inertia that no body can have, a velocity or spin along a held direction.

    Notes
    -----
    Nodes have no inertia, centre or spin, and none of their directions can be held.

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
        if mass is not None and np.ndim(mass) == 0:
            mass = positive(mass, "mass")
        elif mass is not None:
            mass = as_numbers(mass, "mass")
            if mass.ndim != 1 or not (np.isfinite(mass).all() and (mass > 0.0).all()):
                raise InputError(
                    "must be finite and above zero at every node", where="mass", found=mass.shape
                )
            mass = read_only(mass)
        put = object.__setattr__
        put(self, "mass", mass)
        put(self, "inertia", None if inertia is None else check_inertia(inertia, "inertia"))
        put(self, "centre", None if centre is None else read_only(vector(centre, "centre")))
        put(self, "velocity", checked_velocity(velocity))
        put(self, "spin", read_only(vector(spin, "spin")))
        put(self, "hold", held_names(hold, HOLDS, "hold"))
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
        """Return a copy without velocity and spin."""
        at_rest = copy(self)
        object.__setattr__(at_rest, "velocity", read_only(np.zeros(3)))
        object.__setattr__(at_rest, "spin", read_only(np.zeros(3)))
        return at_rest

    def nodes(self, where: str, slave: Slave, number: Number) -> NodeMover:
        """Return nodes that are each a free mass, with the slave's masses if the motion has none.

        Raises
        ------
        InputError
            An inertia, a centre or a hold; no masses, masses that are not positive, masses or
            velocities of another number than the slave's points.
        """
        if self.inertia is not None or self.centre is not None or self.hold:
            raise InputError(
                "nodes have a mass and a velocity only",
                where=where,
                found="inertia, centre or hold",
                allowed="Free(mass=…, velocity=…)",
            )
        mass = slave.mass if self.mass is None else self.mass
        if mass is None:
            raise InputError(
                "free nodes need masses and the slave has none",
                where=where,
                remedy="Give Free(mass=…), or the slave its nodal masses",
            )
        if np.ndim(mass) and len(np.atleast_1d(mass)) != len(slave):
            raise InputError(
                "expected one mass for each node",
                where=where,
                found=np.shape(mass),
                allowed=f"({len(slave)},)",
            )
        masses = np.broadcast_to(np.asarray(real(mass, where), dtype=np.float64), len(slave)).copy()
        is_massless = ~(masses > 0.0)
        if is_massless.any():
            raise InputError(
                f"{int(np.count_nonzero(is_massless))} free nodes have no mass",
                where=where,
                found=f"first at node {int(np.argmax(is_massless))}",
                allowed="above zero at every node",
            )
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
    """A body, or the points of a slave, fixed to another body.

    Forces on them act on that body. Their geometry is in its axes.

    Parameters
    ----------
    body : name of the body that they are fixed to
    mass : mass properties of an attached body, in the common axes; a free body has them added to
        its own
    """

    body: str
    mass: MassProperties | None = None

    @property
    def hosts(self) -> tuple[str, ...]:
        """Name of the body that it is fixed to."""
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
        """Return nodes that are fixed to the body."""
        return CarriedNodes(number(self.body), slave.points, self)


def checked_velocity(velocity: ArrayLike) -> FloatArray:
    """Return a read-only velocity (3,), or (n, 3) of nodes.

    Raises
    ------
    InputError
        Another shape, or numbers that are not finite.
    """
    vectors = as_numbers(velocity, "velocity")
    if vectors.ndim not in (1, 2) or vectors.shape[-1] != 3 or not np.isfinite(vectors).all():
        raise InputError(
            "must be finite numbers",
            where="velocity",
            found=vectors.shape,
            allowed="(3,), or (n, 3) of the nodes of a slave",
        )
    return read_only(vectors)
