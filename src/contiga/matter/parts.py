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

N_CORNERS = {"tet4": 4, "hex8": 8, "tri3": 3, "bar2": 2}
DIMENSION = {"tet4": 3, "hex8": 3, "tri3": 2, "bar2": 1}
SHAPES = {"tet4": tetrahedra, "hex8": hexahedra, "tri3": triangles, "bar2": bars}
MEASURES = {3: "volume", 2: "area", 1: "length"}


@dataclass(frozen=True, kw_only=True, eq=False)
class Part:
    """Elements of one kind, with their material and section.

    Parameters
    ----------
    kind : "tet4", "hex8", "tri3" (a membrane) or "bar2"
    elements : (n, k) rows of the nodes, corners in the order of VTK
    material : one of `contiga.materials` that is for this kind
    density : mass / volume
    thickness : thickness of membranes, length
    section : cross-section of bars, area
    hourglass : factor on the stiffness of the hourglass modes of hex8; with 1 a brick bends along
        its longer side as its material does
    bulk_viscosity : linear and quadratic coefficient for solids; (0.06, 1.5) are usual. It damps
        the ringing behind shocks, and shortens the critical step by 1/(√(1 + b²) + b)
    name : name in messages

    Raises
    ------
    InputError
        An unknown kind, a material that is not for it, elements with another number of corners, a
        density or thickness that is not positive, missing, or not for this kind.
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
        if self.kind not in N_CORNERS:
            raise InputError(
                "is not a kind of element",
                where=f"{self.name}: kind",
                found=self.kind,
                allowed=", ".join(N_CORNERS),
            )
        if self.kind not in self.material.kinds:
            raise InputError(
                f"{type(self.material).__name__} is no material of {self.kind}",
                where=f"{self.name}: material",
                allowed=f"elements of kind {', '.join(self.material.kinds)}",
            )
        put(self, "elements", _checked_elements(self.elements, self.kind, self.name))
        put(self, "density", positive(self.density, f"{self.name}: density"))
        put(self, "hourglass", positive(self.hourglass, f"{self.name}: hourglass"))
        dimension = DIMENSION[self.kind]
        linear, quadratic = (float(x) for x in self.bulk_viscosity)
        is_valid = min(linear, quadratic) >= 0.0 and max(linear, quadratic) < np.inf
        if not is_valid or (dimension < 3 and max(linear, quadratic) > 0.0):
            raise InputError(
                "is for solids" if is_valid else "two numbers that are not negative",
                where=f"{self.name}: bulk_viscosity",
                found=self.bulk_viscosity,
                allowed="(0.06, 1.5) as a rule, (0, 0) for none",
            )
        # Membranes have a thickness, bars a section, solids neither.
        for key, value, needed_by in (
            ("thickness", self.thickness, 2),
            ("section", self.section, 1),
        ):
            where = f"{self.name}: {key}"
            if dimension == needed_by:
                if value is None:
                    raise InputError(
                        f"{self.kind} needs a {key}", where=where, allowed="a finite number > 0"
                    )
                put(self, key, positive(value, where))
            elif value is not None:
                raise InputError(
                    f"{self.kind} has no {key}", where=where, found=value, allowed="none"
                )

    @property
    def across(self) -> float:
        """Factor from an element's measure to its volume: thickness, section, or 1 for a solid."""
        return self.thickness or self.section or 1.0


def shapes_of(part: Part, nodes: FloatArray) -> Shapes:
    """Return the shapes of the part's elements at rest.

    Raises
    ------
    MeshError
        A corner that is not a node, or an element that is inside out or has no volume, area or
        length, by `FLAT`.
    InputError
        A direction of the material across the plane of an element.
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
    direction = getattr(part.material, "direction", None)
    if direction is None:
        shapes = SHAPES[part.kind](corners)
    else:
        shapes = triangles(corners, np.broadcast_to(direction, (len(corners), 3)))
        # The gradients of an element are not finite if the direction has no part in its plane.
        is_across = ~np.isfinite(shapes.gradients).all(axis=1) & (shapes.measures > 0.0)
        if is_across.any():
            raise InputError(
                f"the warp of element {int(np.argmax(is_across))} is across its plane",
                where=f"{part.name}: direction",
                allowed="a direction along every element, or one for each of them (n, 3)",
            )
    dimension = DIMENSION[part.kind]
    least = FLAT * shapes.sizes**dimension
    degenerate = np.flatnonzero(~(shapes.measures > least))
    if degenerate.size:
        row = int(degenerate[0])
        is_inverted = shapes.measures[row] < -least[row]
        problem = "is inside out" if is_inverted else f"has no {MEASURES[dimension]}"
        place = ", ".join(f"{x:.6g}" for x in corners[row].mean(axis=0))
        more = f", and {len(degenerate) - 1} more" if len(degenerate) > 1 else ""
        raise MeshError(
            f"element {row} ({part.kind}, at {place}) {problem}{more}",
            where=part.name,
            found=float(shapes.measures[row]),
            allowed="a volume above zero, corners in the order of VTK" if dimension == 3 else "> 0",
            remedy="Turn the order of its corners" if is_inverted else "Repair the mesh",
        )
    return shapes


def _checked_elements(elements: ArrayLike, kind: str, name: str) -> IntArray:
    """Return the rows (n, k) of nodes of elements of a kind, as int32.

    Raises `MeshError` for anything but whole numbers, at least one row, of k corners.
    """
    rows = np.asarray(elements)
    n_corners = N_CORNERS[kind]
    if rows.ndim != 2 or len(rows) == 0 or not np.issubdtype(rows.dtype, np.integer):
        raise MeshError(
            "elements must be rows of nodes",
            where=name,
            found=f"shape {rows.shape} of {rows.dtype}",
            allowed=f"whole numbers of shape (n, {n_corners}), at least one row",
        )
    if rows.shape[1] != n_corners:
        remedy = None
        if DIMENSION[kind] == 3 and rows.shape[1] == 3:
            remedy = "Triangles are membranes, no solids: kind='tri3' and a thickness"
        raise MeshError(
            f"{kind} has {n_corners} corners",
            where=name,
            found=rows.shape[1],
            allowed=f"(n, {n_corners})",
            remedy=remedy,
        )
    return np.ascontiguousarray(rows, dtype=np.int32)
