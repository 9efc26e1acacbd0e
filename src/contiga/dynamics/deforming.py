"""`Deforming`: a slave that deforms by the forces of elements, or as a shell of splines."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from contiga.arrays.layout import as_points, check_types, positive, read_only
from contiga.dynamics.deforming_nodes import DeformingNodes, joints_of
from contiga.dynamics.deforming_parts import Filling, nodal_thickness, parts_of, uniform_thickness
from contiga.dynamics.free import Dependent, Number, checked_velocity
from contiga.dynamics.holding import attachment_hosts, clamped_edges, drives_of, held_dofs
from contiga.dynamics.mapped_nodes import Places, mapped, nodal_masses
from contiga.dynamics.nodal_loads import NodalForce, Pressure
from contiga.dynamics.nodal_masses import check_carried, lumped_masses
from contiga.dynamics.nodes import NodeMover
from contiga.dynamics.prescribed import Stopped, kinks_in
from contiga.errors import InputError
from contiga.matter.assemble import assemble
from contiga.matter.coefficients import Material
from contiga.matter.iga import Net, Shell, Symmetry, assemble_shell
from contiga.matter.parts import Part
from contiga.matter.protocol import Matter
from contiga.records import FloatArray
from contiga.slaves.skin import tributary_area
from contiga.slaves.slave import Slave

NodalLoad = Pressure | NodalForce
POINT_TOL = 1e-9
"""Distance of points of matter and slave, over the slave's size, below which they are the same."""


@dataclass(frozen=True, init=False, eq=False)
class Deforming(Dependent):
    """A slave that deforms: its points are the nodes of elements of a material.

    The elements are those of the mesh that the slave was read from (`Slave.elements`); the facets
    of a slave without such elements become membranes. A slave of splines (`Slave.surfaces`) is a
    Kirchhoff-Love shell whose degrees of freedom are control points; a place holds all control
    points that move one of its nodes.

    Parameters
    ----------
    material : one of `contiga.materials`, or an object of the user's own with the methods of
        `contiga.matter.Matter`, whose points are those of the slave
    density : mass / volume; matter of one's own has its mass
    thickness : thickness of membranes and shells, length; the slave's if omitted
    bending : bending stiffness of shells of splines over that of a solid sheet; 0 is a membrane
    section : cross-section of bars, area
    hourglass, bulk_viscosity : of solids, see `contiga.matter.Part`
    parts : `contiga.matter.Part` of elements, rows of the slave's points, each with a material of
        its own; all other elements of the slave have the material of the motion. Bars need not be
        elements of the slave
    fixed : nodes that are held: (n,) or (n, 3) bool, numbers of nodes, a table
        ``{"box": [low, high]}``, ``{"plane": [point, normal]}``, ``{"side": [direction, degrees]}``
        (of the normals of facets), ``{"layer": [direction, depth]}`` (below the outermost node),
        ``{"curve": NurbsCurve}``, ``{"edge": "u0"}`` of a slave of splines (with several patches
        ``("u0", patch)``) or ``{"nodes": …}`` with ``"hold": ["x", "y", "z"]``, or a list of such
        tables. ``"slope": True`` also holds the slope of edges of splines that are wholly at the
        place: clamps, planes of symmetry
    velocity : (3,) or (n, 3) at the start, world axes; zero for held nodes
    damping : α of a force −α m v on each node, 1/time
    loads : `contiga.motion.Pressure` and `NodalForce`, one or several
    driven : nodes that a motion drives: a table as for `fixed` with the ``"motion"`` of a body,
        which moves the nodes from their places in the slave; or a list of them
    attached : nodes that are fixed to a body: a table of a place as for `fixed` (all nodes without
        one) with the name of the ``"body"``, in whose axes they are; or a list of them. Their
        masses are added to a free body, and all forces on them act on it
    masses : lumped masses in addition to those of the elements: a table of a place as for `fixed`
        (all nodes without one) with a ``"mass"``, a total that nodes share as they share a
        `NodalForce`, or one mass for each node of the place; or a list of them. `Slave.mass` is not
        added: ``{"mass": slave.mass}`` does that
    rest : (n, 3) nodes at which no element is strained, for a slave of splines (m, 3) control
        points; the slave as it is if omitted
    mass_scaling : time; nodes get the additional mass with which the critical step of the elements
        at rest is not shorter. Findings name the added mass of each part

    Raises
    ------
    InputError
        A number outside its range, arrays that do not fit the slave, elements of another kind than
        the material's, no elements, an element that is inside out.

    Notes
    -----
    Elements neither break nor touch each other: there is no contact of a slave with itself.

    Examples
    --------
    >>> import contiga as cg
    >>> rubber = cg.materials.NeoHooke(young=3.0, poisson=0.4)
    >>> motion = cg.motion.Deforming(
    ...     material=rubber, density=1e-3, fixed={"plane": [[0, 0, 0], [0, 0, 1]]}
    ... )
    >>> tetra = [[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    >>> block = cg.Slave(tetra, [[0, 2, 1], [0, 1, 3]], elements={"tetra": [[0, 1, 2, 3]]})
    >>> ball = cg.Body([cg.shapes.sphere(radius=1.0, centre=(0, 0, 3))])
    >>> simulation = cg.Simulation(
    ...     bodies={"ball": ball},
    ...     slaves={"block": (block, motion)},
    ...     contacts=[cg.Contact(ball, block, law=cg.PenaltyLaw(1.0))],
    ...     gravity=[0, 0, -10.0],
    ...     end=0.01,
    ...     step=1e-4,
    ... )
    >>> state = simulation.run().state
    >>> [bool(v < 0.0) for v in state.slaves["block"].velocities[:, 2]]
    [False, False, False, True]
    """

    material: Material | Matter | None
    density: float | None
    thickness: float | None
    bending: float
    section: float | None
    hourglass: float
    bulk_viscosity: tuple[float, float]
    parts: tuple[Part, ...]
    fixed: Any
    velocity: FloatArray
    damping: float
    loads: tuple[NodalLoad, ...]
    driven: Any
    attached: Any
    masses: Any
    rest: FloatArray | None
    mass_scaling: float | None

    def __init__(
        self,
        *,
        material: Material | Matter | None = None,
        density: float | None = None,
        thickness: float | None = None,
        bending: float = 1.0,
        section: float | None = None,
        hourglass: float = 1.0,
        bulk_viscosity: tuple[float, float] = (0.0, 0.0),
        parts: Sequence[Part] = (),
        fixed: Any = None,
        velocity: ArrayLike = (0.0, 0.0, 0.0),
        damping: float = 0.0,
        loads: NodalLoad | Sequence[NodalLoad] = (),
        driven: Any = None,
        attached: Any = None,
        masses: Any = None,
        rest: ArrayLike | None = None,
        mass_scaling: float | None = None,
    ) -> None:
        is_matter = hasattr(material, "forces")
        if not (is_matter or hasattr(material, "coefficients") or (material is None and parts)):
            raise InputError(
                "must be a material",
                where="Deforming(material)",
                found=type(material).__name__,
                allowed="one of contiga.materials, matter of one's own, or parts that have theirs",
            )
        put = object.__setattr__
        put(self, "material", material)
        put(self, "density", None if density is None else positive(density, "density"))
        put(self, "thickness", None if thickness is None else positive(thickness, "thickness"))
        put(self, "bending", bending)
        put(self, "section", None if section is None else positive(section, "section"))
        put(self, "hourglass", positive(hourglass, "hourglass"))
        put(self, "bulk_viscosity", _checked_viscosity(bulk_viscosity))
        put(self, "parts", tuple(parts))
        check_types(Part, self.parts, "parts", "must be a part", "contiga.matter.Part")
        put(self, "fixed", fixed)
        put(self, "velocity", checked_velocity(velocity))
        put(self, "damping", float(damping))
        put(self, "loads", (loads,) if isinstance(loads, NodalLoad) else tuple(loads))
        put(self, "driven", _as_tables(driven, "driven", "motion", "a motion of a body"))
        put(self, "attached", _as_tables(attached, "attached", "body", "its name"))
        put(self, "masses", _as_tables(masses, "masses", "mass", "a number, or one a node"))
        put(self, "rest", None if rest is None else read_only(as_points(rest, "rest")))
        scale = None if mass_scaling is None else positive(mass_scaling, "mass_scaling")
        put(self, "mass_scaling", scale)
        if is_matter and self.parts:
            raise InputError("matter of one's own has no parts here", where="parts")
        for key, value in (("mass_scaling", scale), ("masses", self.masses)):
            if is_matter and value:
                raise InputError("matter of one's own has its masses", where=key)
        if not (np.isfinite(self.damping) and self.damping >= 0.0):
            raise InputError("must be 0 or more", where="damping", found=damping)
        kinds = "contiga.motion.Pressure, NodalForce"
        check_types(NodalLoad, self.loads, "loads", "must be a load on nodes", kinds)

    @property
    def kinks(self) -> FloatArray:
        """Times at which steps must end to resolve its loads and motions."""
        sources = [*self.loads, *(table.get("motion") for table in self.driven)]
        return np.concatenate([np.zeros(0), *map(kinks_in, sources)])

    @property
    def hosts(self) -> tuple[str, ...]:
        """Names of the bodies that nodes are attached to."""
        return tuple(dict.fromkeys(table["body"] for table in self.attached))

    def resting(self, time: float) -> Deforming:
        """Return a copy without velocity, with loads and motions stopped at `time`."""
        at_rest = copy(self)
        put = object.__setattr__
        put(at_rest, "velocity", read_only(np.zeros(3)))
        put(at_rest, "loads", tuple(load.at_time(time) for load in self.loads))
        stopped = [table | {"motion": Stopped(table["motion"], time)} for table in self.driven]
        put(at_rest, "driven", stopped)
        return at_rest

    def nodes(self, where: str, slave: Slave, number: Number) -> NodeMover:
        """Return the mover of the slave's nodes; nodes in no element are held.

        A shell of splines, or matter with `points(q)`, gets `MappedNodes`, all other matter
        `DeformingNodes`. `where` starts the names in messages, `number` gives a body's number.

        Raises
        ------
        InputError
            Velocities or a rest that do not fit the slave, a node held twice over, elements or
            places that do not exist.
        """
        shape = slave.points.shape
        _check_shape(where, "rest", self._rest_of(slave), shape)
        if self.velocity.ndim == 2:
            _check_shape(where, "velocity", self.velocity, shape)
        held = held_dofs(self.fixed, slave, f"{where}: fixed")
        drives = drives_of(self.driven, held, slave, f"{where}: driven")
        for drive in drives:
            held |= drive.dofs
        hosts = attachment_hosts(self.attached, held, number, slave, f"{where}: attached")
        held[hosts >= 0] = True
        loads = [load.nodes(slave, f"{where}: loads[{k}]") for k, load in enumerate(self.loads)]
        surface_matter = self._surface_matter(slave, where)
        if surface_matter is not None:
            places = Places(held, drives, hosts)
            return mapped(
                where, surface_matter, places, loads, self.velocity, self.damping, motion=self
            )
        parts = self._parts(slave, where)
        matter, rows = self._matter(where, slave, parts, np.any(~held, axis=1))
        bare = np.ones(len(slave), np.bool_)
        bare[rows] = False
        held[bare] = True
        mass = _masses(matter, rows, len(slave))
        velocity = np.where(held, 0.0, self.velocity)
        return DeformingNodes(
            where,
            matter,
            rows,
            mass,
            slave.points,
            velocity,
            held,
            self.damping,
            self,
            tuple(loads),
            drives,
            joints_of(hosts, slave.points, np.where(bare, 0.0, mass)),
            tuple(parts),
        )

    def _surface_matter(self, slave: Slave, where: str) -> Matter | None:
        """Return the matter whose surface points x = N q are the points of the slave.

        For a slave of splines it is the shell. None if the points are the degrees of freedom q. An
        `InputError` is raised if the points of matter of one's own are at the start farther than
        `POINT_TOL` times the slave's size from those of the slave.
        """
        matter: Any = self.material
        if slave.surfaces is not None and not hasattr(matter, "forces"):
            return self._shell(slave.surfaces.net, slave, where)
        if not callable(getattr(matter, "points", None)):
            return None
        q = matter.start().points
        points = np.asarray(matter.points(q))
        if points is q:
            return None
        distance = np.inf
        if points.shape == slave.points.shape:
            distance = float(np.abs(points - slave.points).max(initial=0.0))
        size = float(np.ptp(slave.points, axis=0).max())
        if not distance <= POINT_TOL * size:
            raise InputError(
                "its points must be those of the slave",
                where=f"{where}: material",
                found=f"{len(points)} points" if np.isinf(distance) else f"{distance:.3g} apart",
                allowed=f"{len(slave)} points, apart by no more than {POINT_TOL:g} of their size",
            )
        surface_matter: Matter = matter
        return surface_matter

    def _shell(self, net: Net, slave: Slave, where: str) -> Shell:
        """Return the shell of a slave of splines, clamped at edges whose slope is held.

        An `InputError` is raised for options of meshes, a missing density or thickness, a thickness
        that is not the same everywhere, a rest that is not one row a control point.
        """
        of_meshes = {
            "parts": self.parts,
            "section": self.section,
            "masses": self.masses,
            "mass_scaling": self.mass_scaling,
        }
        for key, option in of_meshes.items():
            if option:
                raise InputError(
                    "is for elements of a mesh: the slave is a surface of splines",
                    where=f"{where}: {key}",
                    allowed="material, density, thickness and bending of a shell",
                )
        thickness = uniform_thickness(where, slave, self.thickness)
        for key, value in (("density", self.density), ("thickness", thickness)):
            if value is None:
                raise InputError("is missing: a shell needs it", where=f"{where}: {key}")
        if self.rest is not None:
            _check_shape(where, "rest", self.rest, net.points.shape)
        edges = clamped_edges(self.fixed, slave, f"{where}: fixed")
        material: Any = self.material
        return assemble_shell(
            net,
            material=material,
            density=self.density or 0.0,
            thickness=thickness or 0.0,
            bending=self.bending,
            symmetry=[Symmetry(name, patch=patch) for patch, name in edges],
            rest=self.rest,
        )

    def with_masses(self, slave: Slave) -> Slave:
        """Return a copy of the slave with the masses (n,) of its elements and of `masses`.

        What `mass_scaling` adds is in them. A slave of splines gets the masses of its shell, matter
        of one's own shares its `mass` among the points that it moves. The slave's previous masses
        do not count. A node in no element gets the mean mass.

        Laws with a `damping_ratio` use these masses: make contacts and simulation with that slave.

        Raises
        ------
        InputError
            A mesh without elements, unless the material is matter of one's own.
        """
        surface_matter = self._surface_matter(slave, "masses")
        if surface_matter is not None:
            return slave.with_mass(nodal_masses(surface_matter, len(slave)))
        matter, rows = self._matter("masses", slave, self._parts(slave, "masses"))
        return slave.with_mass(_masses(matter, rows, len(slave)))

    def nodal_thickness(self, slave: Slave) -> FloatArray:
        """Return the thickness (n,) of membranes at the nodes for `Contact(shell_thickness=…)`.

        It is the mean of the membranes at a node, and 0 at a node without one. On a slave of
        splines it is the one thickness everywhere, 0 if none is given.

        Raises
        ------
        InputError
            A slave without elements; matter of one's own, whose thickness is not known.
        """
        if hasattr(self.material, "forces"):
            raise InputError(
                "matter of one's own does not tell of a thickness",
                where="nodal_thickness(slave)",
                found=type(self.material).__name__,
            )
        if slave.surfaces is not None:
            thickness = uniform_thickness("nodal_thickness(slave)", slave, self.thickness)
            return np.full(len(slave), thickness or 0.0)
        return nodal_thickness(self._parts(slave, "thickness"), len(slave))

    def contact_stiffness(self, slave: Slave) -> float:
        """Return the stiffness per area of a slave's skin that its elements have at rest.

        It is an upper bound, force / volume: the sum of the row sums of their stiffness at the
        nodes of facets, over the area of the facets. `PenaltyLaw(scale * stiffness,
        per_area=True)` with a scale of 0.1 to 1 keeps surfaces apart within the accuracy of the
        mesh, and shortens the critical step by about √(1 + scale). Of splines, or matter with
        `points(q)`, the row sums of all degrees of freedom count.

        Raises
        ------
        InputError
            A slave without facets, or without elements.
        """
        if slave.facets is None or len(slave.facets) == 0:
            raise InputError(
                "has no facets: the stiffness of its skin is not known",
                where="contact_stiffness(slave)",
                found=slave.name or "a cloud",
            )
        area = tributary_area(self._rest_of(slave), slave.facets, slave.quads)
        shell = self._surface_matter(slave, "contact_stiffness")
        if shell is not None:
            return float(shell.stiffness(shell.start()).sum() / area.sum())
        parts = self._parts(slave, "contact_stiffness")
        matter, rows = self._matter("contact_stiffness", slave, parts)
        sums = np.zeros(len(slave))
        sums[rows] = matter.stiffness(matter.start())
        return float(sums[np.unique(slave.facets)].sum() / area.sum())

    def _rest_of(self, slave: Slave) -> FloatArray:
        """Return the nodes (n, 3) at which no element of a mesh is strained."""
        return slave.points if self.rest is None or slave.surfaces is not None else self.rest

    def _matter(
        self,
        where: str,
        slave: Slave,
        parts: Sequence[Part],
        free: NDArray[np.bool_] | None = None,
    ) -> tuple[Matter, NDArray[np.intp]]:
        """Return the matter, and the node of the slave (k,) for each of its degrees of freedom.

        Degrees of freedom are the nodes of elements, ascending, or all nodes for matter of one's
        own. Facets with a node in no element are dropped. `free` (n,) is a mask of the nodes that
        forces move, all if omitted: `mass_scaling` adds mass to these only.

        Raises
        ------
        InputError
            Own matter with another number of masses than the slave has points, a lumped mass on a
            node in no element.
        """
        if hasattr(self.material, "forces"):
            matter: Any = self.material
            if np.shape(matter.mass) != (len(slave),):
                raise InputError(
                    "its degrees of freedom must be the points of the slave, or have points(q)",
                    where=f"{where}: material",
                    found=f"{np.shape(matter.mass)} masses",
                    allowed=f"({len(slave)},)",
                )
            return matter, np.arange(len(slave), dtype=np.intp)
        rows = np.unique(np.concatenate([part.elements.ravel() for part in parts]))
        dof_of_node = np.zeros(len(slave), np.int32)
        dof_of_node[rows] = np.arange(len(rows), dtype=np.int32)
        facets = slave.facets
        if facets is not None:
            facets = dof_of_node[facets[np.isin(facets, rows).all(axis=1)]]
        lumped = lumped_masses(self.masses, slave, f"{where}: masses")
        check_carried(lumped, rows, slave, f"{where}: masses")
        matter = assemble(
            self._rest_of(slave)[rows],
            [replace(part, elements=dof_of_node[part.elements]) for part in parts],
            facets=facets,
            lumped=lumped[rows],
            mass_scaling=self.mass_scaling,
            free=None if free is None else free[rows],
        )
        return matter, rows.astype(np.intp)

    def _parts(self, slave: Slave, where: str) -> list[Part]:
        """Return elements with materials, as rows of the slave's points; [] for own matter.

        They are the parts and, if the motion has a material, all other elements; see `parts_of` for
        errors.
        """
        material: Any = self.material
        if hasattr(material, "forces"):
            return []
        filling = None
        if material is not None:
            filling = Filling(
                material,
                self.density,
                self.thickness,
                self.section,
                self.hourglass,
                self.bulk_viscosity,
            )
        return parts_of(slave, self.parts, filling, where)


def _masses(matter: Matter, rows: NDArray[np.intp], n: int) -> FloatArray:
    """Return the masses (n,) of nodes; nodes in no element, which are held, get the mean mass."""
    mass = np.full(n, float(np.mean(matter.mass)))
    mass[rows] = matter.mass
    return mass


def _checked_viscosity(coefficients: Sequence[float]) -> tuple[float, float]:
    """Return the linear and the quadratic coefficient of bulk viscosity.

    An `InputError` is raised unless they are two finite numbers ≥ 0.
    """
    try:
        linear, quadratic = (float(number) for number in coefficients)
    except (TypeError, ValueError):
        linear = quadratic = -1.0
    if not (0.0 <= linear < np.inf and 0.0 <= quadratic < np.inf):
        raise InputError(
            "must be two numbers that are not negative",
            where="bulk_viscosity",
            found=coefficients,
            allowed="(0.06, 1.5) as a rule, (0, 0) for none",
        )
    return linear, quadratic


def _as_tables(value: Any, name: str, key: str, meaning: str) -> list[dict[str, Any]]:
    """Return copies of one table, or of several, as a list; [] for None.

    An `InputError` is raised for anything but tables; it shows `key` and `meaning` as an example.
    """
    is_list = isinstance(value, Iterable) and not isinstance(value, str | Mapping)
    tables = list(value) if is_list else [] if value is None else [value]
    allowed = f'{{"plane": …, "{key}": {meaning}}}, or a list of such tables'
    check_types(Mapping, tables, name, "must be tables", allowed)
    return [dict(table) for table in tables]


def _check_shape(where: str, name: str, rows: FloatArray, shape: tuple[int, ...]) -> None:
    if rows.shape != shape:
        raise InputError(
            f"{name} must have one row a slave point",
            where=where,
            found=rows.shape,
            allowed=str(shape),
        )
