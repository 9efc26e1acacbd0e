"""Parts of matter: elements of one kind and one material, checked."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from contiga.arrays.layout import positive
from contiga.errors import InputError, MeshError
from contiga.matter.coefficients import Material
from contiga.matter.shapes import FLAT, Shapes, bars, hexahedra, tetrahedra, triangles
from contiga.records import FloatArray, IntArray

CORNERS = {"tet4": 4, "hex8": 8, "tri3": 3, "bar2": 2}
DIMENSION = {"tet4": 3, "hex8": 3, "tri3": 2, "bar2": 1}
SHAPES = {"tet4": tetrahedra, "hex8": hexahedra, "tri3": triangles, "bar2": bars}
WHAT = {3: "volume", 2: "area", 1: "length"}


@dataclass(frozen=True, kw_only=True, eq=False)
class Part:
    """Elements of one kind, their material and what else they are made of.

    Parameters
    ----------
    kind : "tet4", "hex8", "tri3" (a membrane) or "bar2"
    elements : (n, k) rows of the nodes, corners in the order of VTK
    material : one of `contiga.materials` that is for this kind
    density : mass / volume
    thickness : of membranes, length
    section : of bars, area
    hourglass : of hex8, how stiff the modes are that the mean strain does not see: 1 bends a brick
        along its longer side as its material would
    bulk_viscosity : of solids, linear and quadratic coefficient; (0.06, 1.5) are usual. It takes
        the ringing behind shocks, and shortens the critical step by 1/(√(1 + b²) + b)
    name : what messages call it

    Raises
    ------
    InputError
        A kind that is not known, a material that is not for it, elements with another number of
        corners, a density or thickness that is not positive, is missing, or is not asked for.
    """

    kind: str
    elements: IntArray
    material: Material
    density: float
    thickness: float | None = None
    section: float | None = None
    hourglass: float = 1.0
    bulk_viscosity: tuple[float, float] = (0.0, 0.0)
    name: str = "part"

    def __post_init__(self) -> None:
        put = object.__setattr__
        if self.kind not in CORNERS:
            raise InputError(
                "is not a kind of element",
                where=f"{self.name}: kind",
                found=self.kind,
                allowed=", ".join(CORNERS),
            )
        if self.kind not in self.material.kinds:
            raise InputError(
                f"{type(self.material).__name__} is no material of {self.kind}",
                where=f"{self.name}: material",
                allowed=f"elements of kind {', '.join(self.material.kinds)}",
            )
        put(self, "elements", _corners(self.elements, self.kind, self.name))
        put(self, "density", positive(self.density, f"{self.name}: density"))
        put(self, "hourglass", positive(self.hourglass, f"{self.name}: hourglass"))
        self._check_viscosity()
        self._check_across()

    def _check_viscosity(self) -> None:
        linear, quadratic = (float(x) for x in self.bulk_viscosity)
        fits = min(linear, quadratic) >= 0.0 and max(linear, quadratic) < np.inf
        if not fits or (DIMENSION[self.kind] < 3 and max(linear, quadratic) > 0.0):
            raise InputError(
                "two numbers that are not negative" if not fits else "is for solids",
                where=f"{self.name}: bulk_viscosity",
                found=self.bulk_viscosity,
                allowed="(0.06, 1.5) as a rule, (0, 0) for none",
            )

    def _check_across(self) -> None:
        """Membranes have a thickness, bars a section, solids neither."""
        dimension = DIMENSION[self.kind]
        for key, value, of in (("thickness", self.thickness, 2), ("section", self.section, 1)):
            where = f"{self.name}: {key}"
            if of == dimension:
                if value is None:
                    raise InputError(
                        f"{self.kind} needs a {key}", where=where, allowed="a finite number > 0"
                    )
                object.__setattr__(self, key, positive(value, where))
            elif value is not None:
                raise InputError(
                    f"{self.kind} has no {key}", where=where, found=value, allowed="none"
                )

    @property
    def across(self) -> float:
        """Factor from an element's measure to its volume: thickness, section, or 1 for a solid."""
        return self.thickness or self.section or 1.0


def shapes_of(part: Part, nodes: FloatArray) -> Shapes:
    """Return the part's elements at rest, checked.

    Raises
    ------
    MeshError
        A node that is not there, or an element that is inside out or has no volume or area.
    """
    elements = part.elements
    if elements.max() >= len(nodes) or elements.min() < 0:
        row = int(np.flatnonzero(((elements >= len(nodes)) | (elements < 0)).any(axis=1))[0])
        raise MeshError(
            f"element {row} has a corner that is no row of the nodes",
            where=part.name,
            found=elements[row].tolist(),
            allowed=f"0 to {len(nodes) - 1}",
        )
    corners = nodes[elements]
    along = getattr(part.material, "direction", None)
    if along is None:
        shapes = SHAPES[part.kind](corners)
    else:
        shapes = triangles(corners, np.broadcast_to(along, (len(corners), 3)))
        _check_direction(part, shapes)
    dimension = DIMENSION[part.kind]
    least = FLAT * shapes.sizes**dimension
    wrong = np.flatnonzero(~(shapes.measures > least))
    if wrong.size:
        row = int(wrong[0])
        inside_out = shapes.measures[row] < -least[row]
        what = "is inside out" if inside_out else f"has no {WHAT[dimension]}"
        place = ", ".join(f"{x:.6g}" for x in corners[row].mean(axis=0))
        more = f", and {len(wrong) - 1} more" if len(wrong) > 1 else ""
        raise MeshError(
            f"element {row} ({part.kind}, at {place}) {what}{more}",
            where=part.name,
            found=float(shapes.measures[row]),
            allowed="a volume above zero, corners in the order of VTK" if dimension == 3 else "> 0",
            remedy="Turn the order of its corners" if inside_out else "Repair the mesh",
        )
    return shapes


def _check_direction(part: Part, shapes: Shapes) -> None:
    """Refuse a direction that has no part in the plane of an element."""
    across = np.flatnonzero(~np.isfinite(shapes.gradients).all(axis=1) & (shapes.measures > 0.0))
    if across.size:
        raise InputError(
            f"the warp of element {int(across[0])} is across its plane",
            where=f"{part.name}: direction",
            allowed="a direction along every element, or one for each of them (n, 3)",
        )


def _corners(elements: ArrayLike, kind: str, name: str) -> IntArray:
    """Return the rows (n, k) of nodes, checked."""
    rows = np.asarray(elements)
    wanted = CORNERS[kind]
    if rows.ndim != 2 or len(rows) == 0 or not np.issubdtype(rows.dtype, np.integer):
        raise MeshError(
            "elements must be rows of nodes",
            where=name,
            found=f"shape {rows.shape} of {rows.dtype}",
            allowed=f"whole numbers of shape (n, {wanted}), at least one row",
        )
    if rows.shape[1] != wanted:
        remedy = None
        if DIMENSION[kind] == 3 and rows.shape[1] == 3:
            remedy = "Triangles are membranes, no solids: kind='tri3' and a thickness"
        raise MeshError(
            f"{kind} has {wanted} corners",
            where=name,
            found=rows.shape[1],
            allowed=f"(n, {wanted})",
            remedy=remedy,
        )
    return np.ascontiguousarray(rows, dtype=np.int32)
