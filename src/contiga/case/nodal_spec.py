"""Tables about single nodes of a deforming slave: held, driven, loaded, and where they are."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cached_property
from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, model_validator

from contiga.case.geometry_spec import CurveSpec
from contiga.case.load_spec import OverTime
from contiga.case.points_spec import SideSpec
from contiga.case.rigid_spec import PrescribedMotionSpec
from contiga.case.spec import NotNegative, Pair, Spec, Vector, is_number, is_number_or_rows, must_be
from contiga.dynamics.nodal_loads import NodalForce, Pressure
from contiga.errors import CaseError

Direction = Literal["x", "y", "z"]
_DIRECTIONS: tuple[Direction, ...] = ("x", "y", "z")
_PLACES = ("box", "plane", "set", "side", "layer", "curve", "edge", "nodes")
NodesOf = Callable[[str | int | list[int]], Any]
"""Selection of nodes: (n,) mask of a set by name or number; (k,) rows by numbers in the file."""


class LayerSpec(Spec):
    """`layer = { direction, depth }`: nodes furthest along a direction, and those below them."""

    direction: Vector
    depth: NotNegative = 0.0


class EdgeSpec(Spec):
    """`edge = { name, patch }` of a slave of splines; the name alone if it has one patch."""

    name: Literal["u0", "u1", "v0", "v1"]
    """Side of the patch at which u or v begins (0) or ends (1)."""
    patch: Annotated[int, Field(ge=0)] | None = None
    """Number of the patch in the geometry, from 0."""


class NodesSpec(Spec):
    """A selection of nodes: `box`, `plane`, `set`, `side`, `layer`, `curve`, `edge` or `nodes`."""

    box: Pair | None = None
    """Lowest and highest corner."""
    plane: Pair | None = None
    """A point and the normal."""
    set: str | int | None = None
    """A set, part or group of the mesh file."""
    side: SideSpec | None = None
    """Corners of facets whose normals are near a direction."""
    layer: LayerSpec | None = None
    curve: CurveSpec | None = None
    """A curve that nodes lie on."""
    edge: (
        Annotated[EdgeSpec, BeforeValidator(lambda v: {"name": v} if isinstance(v, str) else v)]
        | None
    ) = None
    nodes: Annotated[list[int], Field(min_length=1)] | None = None
    """Numbers of nodes in the mesh file."""

    @model_validator(mode="after")
    def _one_place(self) -> Self:
        if len(self._places) > 1:
            raise CaseError(
                "says twice which nodes",
                found=", ".join(self._places),
                allowed="one of " + ", ".join(_PLACES),
            )
        return self

    @cached_property
    def _places(self) -> list[str]:
        return [key for key in _PLACES if getattr(self, key) is not None]

    def place(self, nodes_of: NodesOf) -> dict[str, Any]:
        """Return the place as keys of a table of `Deforming`; empty for all nodes."""
        if self.set is not None:
            return {"nodes": nodes_of(self.set)}
        if self.nodes is not None:
            return {"nodes": nodes_of(self.nodes)}
        if self.side is not None:
            return {"side": (self.side.direction, self.side.angle)}
        if self.layer is not None:
            return {"layer": (self.layer.direction, self.layer.depth)}
        if self.curve is not None:
            return {"curve": self.curve.make()}
        if self.edge is not None:
            name, patch = self.edge.name, self.edge.patch
            return {"edge": name if patch is None else (name, patch)}
        return {key: getattr(self, key) for key in self._places}


class HeldSpec(NodesSpec):
    """A table of `fixed`: a place, `hold` and `slope`."""

    hold: list[Direction] = Field(default_factory=lambda: [*_DIRECTIONS])
    """World directions in which these nodes do not move."""
    slope: bool = False
    """Whether edges of splines that are selected as a whole do not turn either."""

    @model_validator(mode="after")
    def _somewhere(self) -> Self:
        if not self._places:
            raise CaseError(f"must have exactly one of the keys {', '.join(_PLACES)}")
        return self

    def table(self, nodes_of: NodesOf) -> dict[str, Any]:
        """Return the held nodes as an entry of `fixed` of `Deforming`."""
        return self.place(nodes_of) | {"hold": self.hold, "slope": self.slope}


class DrivenSpec(NodesSpec):
    """A table of `driven`: a place (all nodes if omitted), `motion`, and `hold`."""

    motion: PrescribedMotionSpec
    hold: list[Direction] = Field(default_factory=lambda: [*_DIRECTIONS])
    """World directions in which these nodes follow the motion."""

    def table(self, nodes_of: NodesOf) -> dict[str, Any]:
        """Return the driven nodes as an entry of `driven` of `Deforming`, without the motion."""
        return self.place(nodes_of) | {"hold": self.hold}

    def describe(self) -> str:
        """Describe the table in words."""
        return f"nodes {self.motion.describe()}"


class AttachedSpec(NodesSpec):
    """A table of `attached`: a place (all nodes if omitted), and `body`."""

    body: str
    """Name of the body that carries these nodes, their mass and the forces on them."""

    def table(self, nodes_of: NodesOf) -> dict[str, Any]:
        """Return the attached nodes as an entry of `attached` of `Deforming`."""
        return self.place(nodes_of) | {"body": self.body}


class MassesSpec(NodesSpec):
    """A table of `masses`: a place (all nodes if omitted), and `mass`."""

    mass: Annotated[
        float | list[float],
        must_be(
            lambda value: all(
                is_number(mass) and 0.0 <= mass < math.inf
                for mass in (value if isinstance(value, list) else [value])
            ),
            "must be a number, or one for each of nodes",
            "0 or more",
        ),
    ]
    """Mass of all nodes together, or of each, in the order of `nodes`."""

    @model_validator(mode="after")
    def _each_node_has_one(self) -> Self:
        if isinstance(self.mass, list) and len(self.mass) != len(self.nodes or ()):
            raise CaseError(
                "must have one mass for each of nodes",
                where="mass",
                found=f"{len(self.mass)} for {len(self.nodes or ())}",
                allowed="a number in all, or as many as there are nodes = […]",
            )
        return self

    def table(self, nodes_of: NodesOf) -> dict[str, Any]:
        """Return the masses as an entry of `masses` of `Deforming`."""
        return self.place(nodes_of) | {"mass": self.mass}

    def describe(self) -> str:
        """Describe the table in words."""
        total = sum(self.mass) if isinstance(self.mass, list) else self.mass
        return f"masses of {total:g} on nodes"


class NodalLoadSpec(NodesSpec):
    """A table of `loads`: a place (all nodes if omitted), and `pressure` or `force`."""

    pressure: (
        Annotated[
            float | list[list[float]],
            must_be(is_number_or_rows, "must be a number, or rows over time", "p or [[t, p], …]"),
        ]
        | None
    ) = None
    force: OverTime | None = None
    smooth: bool = False

    @model_validator(mode="after")
    def _load_is_possible(self) -> Self:
        if (self.pressure is None) == (self.force is None):
            raise CaseError("must have exactly one of the keys pressure or force")
        self.load(lambda key: [True])
        return self

    def load(self, nodes_of: NodesOf) -> Pressure | NodalForce:
        """Return the load."""
        on = self.place(nodes_of)
        if self.pressure is not None:
            return Pressure(self.pressure, on=on, smooth=self.smooth)
        assert self.force is not None
        return NodalForce(self.force, on=on, smooth=self.smooth)

    def describe(self) -> str:
        """Describe the table in words."""
        name = "force" if self.pressure is None else "pressure"
        value: Any = getattr(self, name)
        rows = isinstance(value, list) and isinstance(value[0], list)
        return f"{name} {f'of {len(value)} rows over time' if rows else value}"
