"""The deformable side of a contact and its law, by its own laws or by the layers of its bodies.

A body may have a `layer`, the law of its own surface, and other layers on some of its faces. A
contact without a law takes the laws of its two sides: in series if both deform.
"""

from __future__ import annotations

from functools import cached_property
from typing import Annotated, NamedTuple, Self

from pydantic import Field, model_validator

from contiga.case.contact_spec import ContactSpec
from contiga.case.law_spec import LawSpec, PenaltySpec
from contiga.case.spec import Count, Spec
from contiga.contact.checks import law_of
from contiga.errors import CaseError
from contiga.laws.by_face import FaceLaws
from contiga.laws.law import Law


class FaceLayerSpec(Spec):
    """`{ faces, law }`: another layer on some faces of a body."""

    faces: Annotated[list[Count], Field(min_length=1)]
    """Numbers from 1, in the order of the body's faces."""
    law: LawSpec


class LayeredSpec(Spec):
    """The keys of a `[[body]]` that give it a layer; a rigid one has none of them."""

    layer: LawSpec | None = None
    """Layer of all its faces, or of the rest."""
    face_layer: Annotated[list[FaceLayerSpec], Field(min_length=1)] | None = None
    """Layers of some faces."""

    @cached_property
    def surface_law(self) -> Law | None:
        """The law of its surface; None if it is rigid."""
        if self.layer is None or not self.face_layer:
            return None if self.layer is None else self.layer.instance
        laws = {
            tuple(face - 1 for face in layer.faces): layer.law.instance for layer in self.face_layer
        }
        return FaceLaws(self.layer.instance, laws)  # type: ignore[arg-type]

    def layers(self) -> str:
        """Describe the layers in words; there must be one."""
        assert self.layer is not None
        faces = (
            f"faces {str(face.faces)[1:-1]} {face.law.describe()}" for face in self.face_layer or []
        )
        return "; ".join([self.layer.describe(), *faces])

    @model_validator(mode="after")
    def _all_faces_have_layers(self) -> Self:
        """Refuse layers of some faces alone, and laws that need elements or a slave's thickness."""
        if self.face_layer and self.layer is None:
            raise CaseError(
                "is missing: some faces have layers, and the others none",
                where="layer",
                remedy="Give the layer of the rest of the body",
            )
        for law in (self.layer, *(face.law for face in self.face_layer or [])):
            if isinstance(law, PenaltySpec) and law.scale is not None:
                raise CaseError(
                    "is of the stiffness of a slave's elements: a layer has none",
                    where="layer.scale",
                    found=law.scale,
                    allowed="stiffness",
                )
        if self.surface_law is not None and self.surface_law.needs_thickness:
            raise CaseError("is missing", where="layer.thickness")
        return self


class Sides(NamedTuple):
    """The two sides of a contact."""

    type: str
    """The deformable side: "slave", "master" or "combined"."""
    law: Law
    """Law of the deformable side; of the slave's if both deform."""
    master_law: Law | None
    """Law of the master if both sides deform."""


def sides_of(contact: ContactSpec, master: LayeredSpec, slave: LayeredSpec | None) -> Sides:
    """Return the sides of a contact with the body `master`.

    `slave` is the body whose points touch it, if they belong to one. The contact's own laws precede
    the layers of the bodies. Without a type, the side that has a law deforms, or both ("combined").

    Raises
    ------
    InputError
        A side that should deform has no law or thickness; the two laws cannot be combined; the
        slave's body has layers of single faces.
    """
    law_of_contact = None if contact.law is None else contact.law.instance
    if law_of_contact is not None or slave is None:
        slave_law = law_of_contact
    elif slave.face_layer:
        raise CaseError(
            "is missing: only the master's side tells faces with layers of their own apart",
            where="law",
            remedy="Make that body the master, or give the contact a law",
        )
    else:
        slave_law = slave.surface_law
    master_law = master.surface_law if contact.master_law is None else contact.master_law.instance
    kind = contact.type
    if kind is None:
        kind = "slave" if master_law is None else "master" if slave_law is None else "combined"
    if kind == "master":
        law, second_law = master_law if law_of_contact is None else law_of_contact, None
    else:
        law, second_law = slave_law, master_law if kind == "combined" else None
    if law is None:
        raise CaseError(
            "is missing", where="law", allowed="a law, or a body of the contact that has a layer"
        )
    if kind == "combined" and second_law is None:
        raise CaseError(
            "is missing",
            where="master_law",
            remedy='type = "combined" needs both laws: give it, or the body a layer',
        )
    if kind == "master" and law.needs_thickness:
        raise CaseError(
            "is missing",
            where="law.thickness",
            remedy='type = "master" deforms the master: its thickness, not the slave\'s',
        )
    law_of(law, second_law, kind)  # type: ignore[arg-type]  # refused there
    return Sides(kind, law, second_law)
