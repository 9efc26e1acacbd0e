"""The `geometry` tables of a case: a CAD file, a shape, explicit NURBS, a profile or several."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import (
    ConfigDict,
    Field,
    ValidationInfo,
    model_validator,
)

from contiga.case.placed_spec import Placed
from contiga.case.problems import validated
from contiga.case.spec import (
    Count,
    DiscriminatedBy,
    ExistingFile,
    LengthUnit,
    Parts,
    Positive,
    Spec,
    Vector,
    listed_choice,
    numbers_in,
    suggest,
)
from contiga.errors import CaseError
from contiga.geometry import shapes
from contiga.geometry.curve import NurbsCurve
from contiga.geometry.surface import NurbsSurface
from contiga.io.cad.parts import Solids
from contiga.masters.body import Body
from contiga.triangles.trimesh import TriMesh

Net = list[list[Vector]]


class _ShapeSpec(Spec):
    """`shape = "name"` with the shape's own keyword arguments (angles in radians)."""

    model_config = ConfigDict(extra="allow")
    shape_type: ClassVar[type] = NurbsSurface
    """Type that the shape must make: a curve or a surface."""

    shape: str

    @classmethod
    def known_keys(cls, data: dict[str, Any]) -> list[str]:
        """Return the keys of the table and the arguments of the shape it names.

        Raises
        ------
        CaseError
            There is no such shape.
        """
        catalogue = shape_catalogue(cls.shape_type)
        name = data.get("shape")
        if not isinstance(name, str) or name not in catalogue:
            raise CaseError(
                f"there is no such {'curve' if cls.shape_type is NurbsCurve else 'surface'}",
                where="shape",
                found=name,
                allowed=", ".join(sorted(catalogue)),
                remedy=suggest(name, catalogue),
            )
        parameters = inspect.signature(catalogue[name]).parameters
        return [*super().known_keys(data), *parameters]

    @model_validator(mode="after")
    def _shape_is_possible(self, info: ValidationInfo) -> Self:
        assert self.make(info.context) is not None
        return self

    def make(self, context: Any = None) -> Any:
        """Return the curve or surface; tables among its arguments are made to curves first.

        Raises
        ------
        InputError
            An argument is missing or wrong.
        """
        function = shape_catalogue(self.shape_type)[self.shape]
        arguments = dict(self.model_extra or {})
        parameters = inspect.signature(function).parameters
        for name, parameter in parameters.items():
            if parameter.default is parameter.empty and name not in arguments:
                raise CaseError(f"is missing; {self.shape} needs it", where=name)
        for name, value in arguments.items():
            _check_cells(value, name)
            if isinstance(value, dict):
                # A curve as an argument of a shape, as `curve = { shape = "arc", … }`.
                arguments[name] = validated(CurveSpec, value, context, name).make(context)
            elif parameters[name].annotation in (NurbsCurve, NurbsCurve.__name__):
                raise CaseError(
                    "must be a curve", where=name, found=value, allowed='{ shape = "arc", … }'
                )
        try:
            return function(**arguments)
        except OverflowError as error:
            raise CaseError("a number is too large", where=self.shape) from error


class _CurveShape(_ShapeSpec):
    shape_type: ClassVar[type] = NurbsCurve


class _CurveNurbs(Spec):
    class Values(Spec):
        """Degree, knots, control points and weights of a curve."""

        degree: int
        knots: list[float]
        control_points: list[Annotated[list[float], Field(min_length=2, max_length=3)]]
        weights: list[float] | None = None

    nurbs: Values

    @model_validator(mode="after")
    def _curve_is_possible(self) -> Self:
        assert self.make() is not None
        return self

    def make(self, context: Any = None) -> NurbsCurve:
        """Return the curve."""
        v = self.nurbs
        return NurbsCurve(v.degree, v.knots, v.control_points, v.weights)


class SurfaceValues(Spec):
    """Degrees, knots, control points and weights of a surface."""

    degrees: Annotated[list[int], Field(min_length=2, max_length=2)]
    knots: Annotated[list[list[float]], Field(min_length=2, max_length=2)]
    control_points: Net
    weights: list[list[float]] | None = None


class _SurfaceNurbs(Spec):
    nurbs: SurfaceValues

    @model_validator(mode="after")
    def _surface_is_possible(self) -> Self:
        assert self.make() is not None
        return self

    def make(self, context: Any = None) -> NurbsSurface:
        """Return the surface."""
        v = self.nurbs
        degrees, knots = (v.degrees[0], v.degrees[1]), (v.knots[0], v.knots[1])
        return NurbsSurface(degrees, knots, v.control_points, v.weights)


CurveSpec = Annotated[_CurveShape | _CurveNurbs, DiscriminatedBy("shape", "nurbs")]
PatchSpec = Annotated[_ShapeSpec | _SurfaceNurbs, DiscriminatedBy("shape", "nurbs")]


class _Geometry(Placed):
    flip: bool = False
    """Whether the free side and the contact side are swapped."""

    def body(self, name: str, unit: str) -> Body | TriMesh:
        """Return the body, moved by `transform`, then flipped if asked for; lengths in `unit`."""
        body = self.raw(name, unit)
        if self.transform:
            body = body.transformed(self.matrix)
        return body.flipped() if self.flip else body

    def raw(self, name: str, unit: str) -> Body | TriMesh:
        """Return the body before it is moved and flipped."""
        raise NotImplementedError


class FileGeometry(_Geometry):
    """`{ file, unit, parts, faces, solids }`.

    `unit` replaces the unit of the file, which is wrong or missing there.
    """

    file: ExistingFile
    unit: LengthUnit | None = None
    parts: Parts | None = None
    """Names or numbers of parts; all if `faces` is omitted too."""
    faces: Annotated[list[Count], Field(min_length=1)] | None = None
    """Numbers of single faces, in addition to `parts`."""
    solids: Solids | None = None
    """Treatment of solids that touch or overlap; they are united, with a warning, if omitted."""

    def raw(self, name: str, unit: str) -> Body:
        """Return the faces of the file as a body; CaseError if its suffix is none of CAD."""
        from contiga.io.cad.formats import SUFFIXES
        from contiga.io.cad.read_cad import read_cad

        if Path(self.file).suffix.lower() not in SUFFIXES:
            raise CaseError(
                "is not a CAD file",
                where="file",
                found=self.file,
                allowed=" ".join(SUFFIXES),
                remedy="For a mesh write geometry = { mesh = … }",
            )
        body = read_cad(
            self.file,
            unit=unit,
            file_unit=self.unit,
            parts=self.parts,
            faces=self.faces,
            solids=self.solids,
        )
        return body.renamed(name)

    def describe(self) -> str:
        """Describe the table in words."""
        parts = listed_choice("parts", self.parts) + listed_choice("faces", self.faces)
        return f"{self.file}{parts}, {numbers_in(self.unit, 'its own unit')}"


class MeshGeometry(_Geometry):
    """`{ mesh, normals, unit, parts, orient }`: the surface of a mesh, with its own triangles."""

    mesh: ExistingFile
    normals: Literal["facet", "vertex"] = "facet"
    unit: LengthUnit | None = None
    """Unit of the file; the case's if omitted."""
    parts: Parts | None = None
    orient: bool = False
    """Whether triangles that face other ways than their neighbours are turned."""

    def raw(self, name: str, unit: str) -> TriMesh:
        """Return the triangles of the file, oriented if `orient`; CaseError if it is CAD."""
        from contiga.io.cad.formats import SUFFIXES
        from contiga.io.mesh.read_master import read_master

        if Path(self.mesh).suffix.lower() in SUFFIXES:
            raise CaseError(
                "is CAD, not a mesh",
                where="mesh",
                found=self.mesh,
                remedy="Write geometry = { file = … }, or make a mesh of it with contiga mesh",
            )
        mesh = read_master(
            self.mesh, unit=unit, file_unit=self.unit, parts=self.parts, normals=self.normals
        ).renamed(name)
        return mesh.oriented() if self.orient else mesh

    def describe(self) -> str:
        """Describe the table in words."""
        parts = listed_choice("parts", self.parts)
        numbers = numbers_in(self.unit, "the case's unit")
        return f"triangles of {self.mesh}{parts}, {self.normals} normals, {numbers}"


class ShapeGeometry(_Geometry, _ShapeSpec):
    """`{ shape = "torus", major = 2.0, … }`."""

    def raw(self, name: str, unit: str) -> Body:
        """Return the shape as a body of one patch."""
        return Body([self.make()], name=name, unit=unit)

    def describe(self) -> str:
        """Describe the table in words."""
        values = ", ".join(f"{key} = {value}" for key, value in (self.model_extra or {}).items())
        return f"{self.shape}({values})"


class NurbsGeometry(_Geometry, _SurfaceNurbs):
    """`{ nurbs = { degrees, knots, control_points, weights } }`."""

    def raw(self, name: str, unit: str) -> Body:
        """Return the surface as a body of one patch."""
        return Body([self.make()], name=name, unit=unit)

    def describe(self) -> str:
        """Describe the table in words."""
        return f"one NURBS patch of degrees {self.nurbs.degrees}"


class ProfileGeometry(_Geometry):
    """`{ profile = { curve }, depth }`: a plane problem, `Body.from_profile`."""

    profile: CurveSpec
    depth: Positive = 1.0

    @model_validator(mode="after")
    def _profile_is_possible(self) -> Self:
        assert self.raw("profile", "") is not None
        return self

    def raw(self, name: str, unit: str) -> Body:
        """Return the profile with its depth."""
        return Body.from_profile(self.profile.make(), self.depth).renamed(name)

    def describe(self) -> str:
        """Describe the table in words."""
        return f"a profile of depth {self.depth:g}"


class PatchesGeometry(_Geometry):
    """`{ patches = [ { shape … }, { nurbs … } ] }`."""

    patches: Annotated[list[PatchSpec], Field(min_length=1)]

    def raw(self, name: str, unit: str) -> Body:
        """Return the patches as one body."""
        return Body([patch.make() for patch in self.patches], name=name, unit=unit)

    def describe(self) -> str:
        """Describe the table in words."""
        return f"{len(self.patches)} patches"


GeometrySpec = Annotated[
    FileGeometry | MeshGeometry | ShapeGeometry | NurbsGeometry | ProfileGeometry | PatchesGeometry,
    DiscriminatedBy("file", "mesh", "shape", "nurbs", "profile", "patches"),
]


def shape_catalogue(shape_type: type) -> dict[str, Callable[..., Any]]:
    """Return the functions of `contiga.geometry.shapes` that make a curve or a surface, by name."""
    return {
        name: function
        for name, function in vars(shapes).items()
        if inspect.isfunction(function)
        and function.__module__ == shapes.__name__
        and not name.startswith("_")
        and inspect.signature(function).return_annotation in (shape_type, shape_type.__name__)
    }


def _check_cells(value: Any, key: str) -> None:
    """Refuse text and booleans in a list, which numpy would accept as numbers."""
    for i, cell in enumerate(value if isinstance(value, list) else ()):
        _check_cells(cell, f"{key}[{i}]")
        if isinstance(cell, str | bool):
            raise CaseError("must be a number", where=f"{key}[{i}]", found=cell)
