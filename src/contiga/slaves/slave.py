"""The slave: points that can touch a master, with the data of their mesh."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from contiga.arrays.layout import as_points, read_only, real
from contiga.display import Displayed, Facts
from contiga.errors import MeshError
from contiga.geometry.surface import NurbsSurface
from contiga.patches.splines import Splines
from contiga.records import FloatArray, IndexArray, IntArray
from contiga.rigid.transform import PoseLike, as_matrix, scaling
from contiga.slaves.checks import as_active, as_facets, as_nodal, check_nodes, check_points
from contiga.slaves.elements import as_elements, mirrored
from contiga.slaves.quads import halves_of
from contiga.slaves.selection import Criteria, Surface, select
from contiga.slaves.skin import tributary_area
from contiga.triangles.pyvista_mesh import pyvista_mesh

if TYPE_CHECKING:
    import pyvista

_SIMILARITY_TOL = 1e-9
_AREA_TOL = 1e-9


class MeshPart(NamedTuple):
    """A part, set or physical group of a mesh file."""

    id: int | None
    name: str | None
    n_cells: int
    """Number of cells; 0 for a set of nodes."""
    n_nodes: int
    """Number of nodes, its own or of its cells."""

    @property
    def label(self) -> str:
        """The name for users."""
        if self.name is None:
            return str(self.id)
        return self.name if self.id is None else f"{self.id} ({self.name})"


class Slave(Displayed):
    """Points that can touch a master: a cloud, or the nodes of a finite-element mesh. Immutable.

    Parameters
    ----------
    points : (n, 3), length
        All nodes of the mesh, so that results fit it; the nodes of `surfaces` if omitted.
    facets : (m, 3) or (m, 4) rows of `points`
        Surface facets; quadrilaterals are split along their shorter diagonal.
    area : (n,) or one for every point, length², at least 0
        Contact area of each point; by default a third of each facet at the point, and ∫ N dA of the
        bilinear shape function on quadrilateral faces of solid elements.
    thickness : (n,) or one for every point, length, at least 0
        Thickness of the shell at each point, 0 where there is no shell.
    mass : (n,) or one for every point, at least 0
    active : (n,) bool
        Points that take part in contact; by default the corners of the facets, or every point
        without facets.
    name : name in messages and results
    unit : unit of lengths, if known
    cells : number of cells of its file by kind, for reports
    parts : parts, sets and groups of its file, for reports
    elements : cells by kind ("tetra", "hexahedron", "triangle" …), each (e, k) rows of `points`
        with the corners in the order of VTK; they may deform
    surfaces : NurbsSurface, one or several that share the control points of their joints
        The slave is a surface of splines: its points are nodes of that surface, with the areas and
        facets between them. `contiga.motion.Deforming` makes a shell or a membrane of it.

    Raises
    ------
    InputError
        Surfaces that do not meet, meet with other control points or along a part of an edge, have
        a pole, or are of a degree above 5.
    MeshError
        No points, a coordinate that is not finite, a facet that refers to no point, an array that
        does not fit.

    Examples
    --------
    >>> import contiga as cg
    >>> sheet = cg.Slave([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]], name="sheet")
    >>> len(sheet), sheet.facets.shape, float(sheet.area.sum().round(12))
    (4, (2, 3), 1.0)
    >>> cg.Slave([[0, 0, 0], [1, 0, 0]]).area is None  # a cloud
    True
    >>> tube = cg.Slave(surfaces=cg.shapes.cylinder(radius=1.0, height=2.0), name="tube")
    >>> len(tube), round(float(tube.area.sum()) / np.pi, 3)
    (48, 4.0)
    """

    points: FloatArray
    """(n, 3), read-only."""
    facets: IntArray | None
    """(m, 3) int32 triangles, read-only."""
    area: FloatArray | None
    """(n,) tributary area; None for a cloud without areas."""
    thickness: FloatArray | None
    mass: FloatArray | None
    active: NDArray[np.bool_]
    name: str
    unit: str | None
    cells: Mapping[str, int]
    parts: tuple[MeshPart, ...]
    elements: Mapping[str, IntArray]
    """(e, k) rows of `points` by kind, read-only; empty if unknown."""
    surfaces: Splines | None
    """The patches of a slave of splines and their joints; None for others."""
    quads: IntArray
    """(q, 2) int32 rows of `facets`, read-only: the halves of each quadrilateral face of a solid
    element, which is bilinear in areas, quadrature and loads."""

    __slots__ = (
        *("points", "facets", "area", "thickness", "mass"),
        *("active", "name", "unit", "cells", "parts", "elements", "surfaces", "quads"),
        "__weakref__",
    )

    def __init__(
        self,
        points: ArrayLike | None = None,
        facets: ArrayLike | None = None,
        *,
        area: ArrayLike | None = None,
        thickness: ArrayLike | None = None,
        mass: ArrayLike | None = None,
        active: ArrayLike | None = None,
        name: str = "slave",
        unit: str | None = None,
        cells: Mapping[str, int] | None = None,
        parts: Sequence[MeshPart] = (),
        elements: Mapping[str, ArrayLike] | None = None,
        surfaces: NurbsSurface | Sequence[NurbsSurface] | Splines | None = None,
    ) -> None:
        if surfaces is None or isinstance(surfaces, Splines):
            splines = surfaces
        else:
            splines = Splines.of(surfaces)
        if splines is not None and points is None:
            nodes = splines.nodes
            points, facets = splines.points, nodes.facets if facets is None else facets
            area = nodes.weight if area is None else area
        if points is None:
            raise MeshError("needs points, or surfaces", where=name, found="neither")
        coordinates = read_only(as_points(points, f"{name}: points"))
        if splines is not None:
            check_nodes(splines.points, coordinates, name)
        check_points(coordinates, where=name)
        triangles = None if facets is None else as_facets(coordinates, facets, name)
        cells_by_kind = as_elements(elements, len(coordinates), name)
        quads = halves_of(triangles, cells_by_kind, len(coordinates))
        quads.flags.writeable = False
        if area is None and triangles is not None:
            area = tributary_area(coordinates, triangles, quads)
        values: dict[str, Any] = {
            "points": coordinates,
            "facets": triangles,
            "area": as_nodal(area, "area", len(coordinates), name),
            "thickness": as_nodal(thickness, "thickness", len(coordinates), name),
            "mass": as_nodal(mass, "mass", len(coordinates), name),
            "active": as_active(active, triangles, len(coordinates), name),
            "name": name,
            "unit": unit,
            "cells": MappingProxyType(dict(cells or {})),
            "parts": tuple(parts),
            "elements": cells_by_kind,
            "surfaces": splines,
            "quads": quads,
        }
        for key, value in values.items():
            object.__setattr__(self, key, value)

    @classmethod
    def of(cls, matter: Any, name: str = "slave") -> Slave:
        """Return a slave with the points, facets and areas of user-made matter, which moves it.

        `Slave(surfaces=…)` is simpler for a shell that `Deforming` makes.

        Parameters
        ----------
        matter : object with the methods of `contiga.matter.Matter`, such as the result of
            `contiga.matter.iga.assemble_shell`; with `facets`, and with `areas` if its points have
            areas of their own
        name : name in messages and results

        Raises
        ------
        MeshError
            Invalid points or facets.

        Examples
        --------
        >>> import contiga as cg
        >>> from contiga.matter.iga import assemble_shell
        >>> cloth = cg.materials.Elastic(young=1.0, poisson=0.3)
        >>> sheet = cg.shapes.plane(width=2.0, length=1.0).k_refined((1, 1), [], [])
        >>> shell = assemble_shell([sheet], material=cloth, density=1.0, thickness=0.1)
        >>> slave = cg.Slave.of(shell)
        >>> len(slave), len(shell.mass), float(slave.area.sum().round(12))
        (16, 9, 2.0)
        """
        q = matter.start().points
        points = q if not hasattr(matter, "points") else matter.points(q)
        facets = getattr(matter, "facets", None)
        return cls(points, facets, area=getattr(matter, "areas", None), name=name)

    def __setattr__(self, key: str, value: object) -> None:
        raise AttributeError(f"a Slave is immutable: cannot set {key!r}")

    def __delattr__(self, key: str) -> None:
        raise AttributeError(f"a Slave is immutable: cannot delete {key!r}")

    def __len__(self) -> int:
        return len(self.points)

    def _picture(self) -> bytes | None:
        from contiga.rendering.picture import picture_of  # kernels of its own

        if self.facets is None or len(self.facets) == 0:
            return None
        return picture_of(self.points, self.facets)

    def to_pyvista(self) -> pyvista.PolyData:
        """Return the facets, or the points of a cloud, as a copy in a `pyvista.PolyData`.

        Raises
        ------
        MissingPackageError
            pyvista is not installed.
        """
        return pyvista_mesh("Slave.to_pyvista", self.points, self.facets)

    def _facts(self) -> Facts:
        facets = 0 if self.facets is None else len(self.facets)
        unit = [("unit", self.unit)] if self.unit else []
        active = int(self.active.sum())
        patches = [] if self.surfaces is None else [("patches", len(self.surfaces.patches))]
        return [("points", len(self)), ("active", active), ("facets", facets), *patches, *unit]

    def __reduce__(self) -> tuple[Any, ...]:
        return _rebuild, (self._values(),)

    def bounds(self) -> FloatArray:
        """Return the lowest and highest coordinates (2, 3) of active points; of all if none is."""
        return box_of(self.points, self.active)

    def selected(
        self,
        *,
        nodes: ArrayLike | None = None,
        box: ArrayLike | None = None,
        side: tuple[ArrayLike, float] | None = None,
    ) -> Slave:
        """Return a copy with fewer active points; all points stay, so that results fit the mesh.

        All criteria must hold. A facet stays if all its corners are selected and it faces `side`;
        its corners, and without `side` selected points on no facet, are active. Areas that are
        shares of the facets become shares of the remaining facets; others do not change.

        Parameters
        ----------
        nodes : (n,) bool, or rows of points
        box : (2, 3) lowest and highest corner, length; points on its border are inside
        side : direction (3,), and largest angle between it and normals of facets, degrees

        Raises
        ------
        MeshError
            An invalid criterion, or nothing is selected.

        Examples
        --------
        >>> import contiga as cg
        >>> pad = cg.read_mesh("pad.vtu")  # a cube of side 1
        >>> top = pad.selected(side=([0, 0, 1], 30.0))
        >>> len(top), int(top.active.sum()), top.bounds()[:, 2].tolist(), float(top.area.sum())
        (8, 4, [1.0, 1.0], 1.0)
        """
        criteria = Criteria(nodes, box, side)
        surface = Surface(self.points, self.facets, self.quads)
        facets, active = select(surface, self.active, criteria, self.name)
        fields = self._values()
        if self.area is not None and self.facets is not None:
            areas = tributary_area(self.points, self.facets, self.quads)
            # Motion and scale have changed the last bits of tributary areas.
            if (np.abs(self.area - areas) <= _AREA_TOL * areas.max(initial=0.0)).all():
                fields["area"] = None  # the shares of the remaining facets
        return Slave(**(fields | {"facets": facets, "active": active}))

    def transformed(self, transform: PoseLike) -> Slave:
        """Return a copy moved by a (4, 4) similarity: rotation, translation, uniform scale, mirror.

        A scipy `Rotation` or a pair (R, t) is accepted. Lengths, areas and thicknesses scale with
        it; a mirror turns the facets so that their normals stay on the same side. Mass stays.

        Raises
        ------
        InputError
            The rotation or the translation of a pair does not fit.
        MeshError
            The matrix is not (4, 4), or no similarity: areas could not follow it.
        """
        transform = as_matrix(transform, f"{self.name}, transform")
        matrix = np.asarray(real(transform, self.name), dtype=np.float64)
        if (
            matrix.shape != (4, 4)
            or not np.isfinite(matrix).all()
            or matrix[3].tolist() != [0.0, 0.0, 0.0, 1.0]
        ):
            raise MeshError(
                "a transform must be a finite (4, 4) matrix with last row 0 0 0 1",
                where=self.name,
                found=matrix.tolist(),
            )
        linear = matrix[:3, :3]
        gram = linear.T @ linear
        square = np.trace(gram) / 3.0
        if not square > 0.0 or np.abs(gram - square * np.eye(3)).max() > _SIMILARITY_TOL * square:
            raise MeshError(
                "a slave can be turned, moved, mirrored and scaled alike in all directions only",
                where=self.name,
                found=matrix.tolist(),
                allowed="rotation times one scale",
            )
        facets, elements = self.facets, self.elements
        if np.linalg.det(linear) < 0.0:
            facets = None if facets is None else facets[:, ::-1]
            elements = mirrored(elements)
        points = self.points @ linear.T + matrix[:3, 3]
        fields = {"points": points, "facets": facets, "elements": elements}
        return self._copy(fields, matrix, float(np.sqrt(square)))

    def scaled(self, factor: float, unit: str | None = None) -> Slave:
        """Return a copy with all lengths times `factor`, and the label `unit` if given.

        Areas scale with the square; masses stay.

        Raises
        ------
        MeshError
            The factor is not positive and finite.
        """
        if not (np.isfinite(factor) and factor > 0.0):
            raise MeshError(
                "the scale must be a positive number",
                where=self.name,
                found=factor,
                allowed="> 0",
            )
        fields = {"points": self.points * factor, "unit": unit or self.unit}
        return self._copy(fields, scaling(factor), factor)

    def with_mass(self, mass: ArrayLike) -> Slave:
        """Return a copy with the masses `mass`: one for all or (n,), in the unit of mass.

        Raises
        ------
        InputError
            A mass is not finite or below zero, or there is not one a point.
        """
        return Slave(**(self._values() | {"mass": mass}))

    def _values(self) -> dict[str, Any]:
        """Return the arguments of a copy by name; mappings as plain dicts, which can be pickled."""
        values = {key: getattr(self, key) for key in _FIELDS}
        return {key: dict(v) if isinstance(v, Mapping) else v for key, v in values.items()}

    def _copy(self, fields: dict[str, Any], matrix: FloatArray, factor: float) -> Slave:
        """Return a copy with new `fields`, its areas and thickness scaled, its surfaces moved.

        `matrix` is the similarity (4, 4) of the scale `factor`.
        """
        scaled_fields = {
            "area": None if self.area is None else self.area * factor**2,
            "thickness": None if self.thickness is None else self.thickness * factor,
            "surfaces": None if self.surfaces is None else self.surfaces.transformed(matrix),
        }
        return Slave(**(self._values() | fields | scaled_fields))


_FIELDS = tuple(key for key in Slave.__slots__ if key not in ("quads", "__weakref__"))


def box_of(points: FloatArray, active: NDArray[np.bool_] | None = None) -> FloatArray:
    """Return the lowest and highest coordinates (2, 3) of points (n, 3); of active ones, if any."""
    if active is not None and active.any():
        points = points[active]
    return np.stack([points.min(axis=0), points.max(axis=0)])


def _rebuild(fields: dict[str, Any]) -> Slave:
    return Slave(**fields)


def own_nodes(slave: Slave) -> IndexArray:
    """Return (k,) rows of the points that are the slave's own, ascending.

    They are the active points and those of its facets and elements; all points of a slave without
    `cells`, which is not from a file. A part of a mesh file has the nodes of other parts, too:
    these are neither counted nor drawn.
    """
    is_own = slave.active | (len(slave.cells) == 0)
    for rows in (slave.facets, *slave.elements.values()):
        if rows is not None:
            is_own[rows] = True
    return np.flatnonzero(is_own)
