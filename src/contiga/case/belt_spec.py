"""The `belt` tables of a case: belts that are routed over bodies and laid along their path."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Annotated, Literal

from pydantic import Field

from contiga.case.material_spec import MaterialSpec
from contiga.case.spec import Count, Name, NotNegative, Positive, Spec, Vector
from contiga.case.spring_spec import WebbingSpec
from contiga.dynamics.belt import ENDS, FREE, GROUND, Belt, BeltEnd
from contiga.masters.protocol import Master
from contiga.routing.route import DEFAULT_CHORDS, route

Anchors = Annotated[list[Name], Field(min_length=2, max_length=2)]


class PathSpec(Spec):
    """`path = { start, end, via, over, points }`: the arguments of `contiga.route`."""

    start: Vector
    end: Vector
    via: list[Vector] = Field(default_factory=list)
    over: Annotated[list[Name], Field(min_length=1)]
    """Bodies that the belt stays outside of."""
    points: Annotated[int, Field(ge=10)] = DEFAULT_CHORDS


class BeltEndSpec(WebbingSpec[BeltEnd]):
    """`start` or `end`: webbing between an anchor and the nodes of a belt, a `BeltEnd`."""

    makes = BeltEnd
    length: Positive

    def describe(self) -> str:
        """Describe the table in words."""
        return "; ".join([f"webbing {self.length:g} long", *self.facts()])


class BeltSpec(Spec):
    """A `[[belt]]`: a slave that is laid over bodies at their places at the start."""

    name: Name
    path: PathSpec
    kind: Literal["bars", "ribbon", "membrane"] = "bars"
    width: Positive
    thickness: Positive
    material: MaterialSpec
    density: Positive
    segments: Count = 40
    across: Count = 4
    shortening: Annotated[float, Field(ge=0.0, lt=1.0)] = 0.0
    """Shortening of the belt at rest, as a share of its path."""
    anchors: Anchors = Field(default_factory=lambda: [GROUND, GROUND])
    """Holders of its start and its end: "ground", a body, or "free"."""
    start: BeltEndSpec | None = None
    """Webbing and devices between the first anchor and the nodes."""
    end: BeltEndSpec | None = None
    velocity: Vector = Field(default_factory=lambda: [0.0, 0.0, 0.0])
    """Velocity of its nodes at the start."""
    damping: NotNegative = 0.0

    @property
    def webbing(self) -> dict[str, BeltEndSpec]:
        """The webbing at its ends, by "start" and "end"."""
        specs = zip(ENDS, (self.start, self.end), strict=True)
        return {end: spec for end, spec in specs if spec is not None}

    def named_bodies(self) -> Iterator[tuple[str, str]]:
        """Yield the keys that name a body, and the names."""
        yield from ((f"path.over[{k}]", name) for k, name in enumerate(self.path.over))
        for k, name in enumerate(self.anchors):
            if name not in (GROUND, FREE):
                yield f"anchors[{k}]", name

    def belt_over(self, bodies: Mapping[str, Master]) -> Belt:
        """Return the belt over bodies at their places at the start.

        Raises
        ------
        InputError
            As `contiga.route`, and `Belt`.
        """
        path = self.path
        over = [bodies[name] for name in path.over]
        vx, vy, vz = self.velocity
        return Belt(
            path=route(over, path.start, path.end, path.via, points=path.points),
            material=self.material.instance,
            density=self.density,
            width=self.width,
            thickness=self.thickness,
            kind=self.kind,
            segments=self.segments,
            across=self.across,
            shortening=self.shortening,
            anchors=(self.anchors[0], self.anchors[1]),
            start=None if self.start is None else self.start.instance,
            end=None if self.end is None else self.end.instance,
            velocity=(vx, vy, vz),
            damping=self.damping,
            name=self.name,
        )

    def describe(self) -> str:
        """Describe the table in words."""
        across = "" if self.kind == "bars" else f" × {self.across}"
        return (
            f"{self.kind}, {self.segments}{across} elements, {self.width:g} wide, over "
            f"{', '.join(self.path.over)}, from {self.anchors[0]} to {self.anchors[1]}"
        )
