"""Laws that differ from face to face of a master: skins, ribs, and what is beneath them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from contiga.errors import InputError
from contiga.laws.combined import CombinedLaw
from contiga.laws.law import Law, remembered
from contiga.laws.stress import StressLaw
from contiga.records import DepthSlopes, FloatArray, LawInput, LawOutput, LawTangent


@dataclass(frozen=True, init=False, eq=False)
class FaceLaws:
    """A law for each face of the master: a point takes that of the face its foot is on.

    Parameters
    ----------
    rest : law of the faces that are not named
    faces : laws by face: numbers of faces from 0, as `Body.patches` has them, one or several

    Notes
    -----
    A point whose foot passes from face to face goes on by the law of the new one, with what that
    law makes of its memory: at the border force and energy jump where the laws differ.

    Raises
    ------
    InputError
        Laws that give one force for all points, whose points cannot be told apart; a face that is
        named twice or is no number from 0.

    >>> soft_rib = FaceLaws(StressLaw(10.0, 1.0), {(1, 2): StressLaw(4.0, 1.0)})
    >>> one = np.ones(3)
    >>> pressed = LawInput(0.1 * one, 0.0 * one, one, None, None, 0.0, patch=np.array([0, 1, 2]))
    >>> soft_rib.respond(pressed).force.round(12).tolist()
    [1.0, 0.4, 0.4]
    """

    laws: tuple[Law, ...]
    """The rest's law, and the others in their order."""
    faces: tuple[tuple[int, ...], ...]
    """Faces of each of the others."""

    def __init__(self, rest: Law, faces: Mapping[int | tuple[int, ...], Law]) -> None:
        put = object.__setattr__
        put(self, "laws", (rest, *faces.values()))
        named = [key if isinstance(key, tuple) else (key,) for key in faces]
        put(self, "faces", tuple(tuple(map(_number, group)) for group in named))
        _check_once([face for group in self.faces for face in group])
        for law in self.laws:
            if isinstance(law, FaceLaws) or not isinstance(law, StressLaw | CombinedLaw):
                raise InputError(
                    "laws of faces must act on each point by itself",
                    where="faces",
                    found=type(law).__name__,
                    allowed="StressLaw",
                )

    needs_patch = True

    @property
    def has_rate(self) -> bool:
        """True if the force of one of the laws depends on the rate."""
        return any(getattr(law, "has_rate", False) for law in self.laws)

    @property
    def needs_mass(self) -> bool:
        """True if one of the laws needs nodal masses."""
        return any(law.needs_mass for law in self.laws)

    @property
    def needs_thickness(self) -> bool:
        """True if one of the laws needs nodal thicknesses."""
        return any(law.needs_thickness for law in self.laws)

    @property
    def n_memory(self) -> int:
        """The largest number of memory columns of its laws."""
        return max(law.n_memory for law in self.laws)

    def largest(self) -> int:
        """The largest number of a face that is named, −1 if there is none."""
        return max((face for faces in self.faces for face in faces), default=-1)

    def with_slave(self, slave: StressLaw) -> FaceLaws:
        """Return the laws, each in series with that of the slave's side."""
        both = [CombinedLaw(slave, law) for law in self.laws]  # type: ignore[arg-type]
        return FaceLaws(both[0], dict(zip(self.faces, both[1:], strict=True)))

    def respond(self, inp: LawInput) -> LawOutput:
        """The forces of each point by the law of its face."""
        assert inp.patch is not None
        n, memory = len(inp.penetration), remembered(inp, self.n_memory)
        force, stiffness, stored, lost, damping = np.zeros((5, n))
        slope, viscosity, bend = np.zeros((3, n))
        left, has_tangent = np.zeros((n, self.n_memory)), inp.wants_tangent
        filled = force, stiffness, stored, left, lost, damping
        chosen = np.zeros(n, np.intp)
        for k, faces in enumerate(self.faces, start=1):
            chosen[np.isin(inp.patch, faces)] = k
        for k, law in enumerate(self.laws):
            rows = np.flatnonzero(chosen == k)
            if len(rows) == 0:
                continue
            kept = memory[rows, : law.n_memory]
            answer = law.respond(_part(inp, rows)._replace(memory=kept))
            parts = answer.force, answer.stiffness, answer.stored, answer.memory
            losses = answer.hysteresis, answer.damping
            for whole, part in zip(filled, (*parts, *losses), strict=True):
                if part is not None:
                    _put(whole, rows, part)
            if not isinstance(slopes := answer.tangent, LawTangent):
                has_tangent = False
                continue
            slope[rows] = slopes.force.own
            viscosity[rows] = 0.0 if slopes.rate is None else slopes.rate
            bend[rows] = 0.0 if slopes.stiffness is None else slopes.stiffness.own
        tangent = LawTangent(DepthSlopes(slope), viscosity, DepthSlopes(bend))
        return LawOutput(*filled, tangent=tangent if has_tangent else None)


def _put(whole: FloatArray, rows: np.ndarray, part: FloatArray) -> None:
    if part.ndim == 2:
        whole[rows, : part.shape[1]] = part
    else:
        whole[rows] = part


def _part(inp: LawInput, rows: np.ndarray) -> LawInput:
    """Return the rows of an input that belong to some points."""
    return LawInput._make(v[rows] if isinstance(v, np.ndarray) and len(v) else v for v in inp)


def _number(face: object) -> int:
    if isinstance(face, bool) or not isinstance(face, int | np.integer) or face < 0:
        raise InputError(
            "is not a face", where="faces", found=face, allowed="a whole number from 0"
        )
    return int(face)


def _check_once(faces: Iterable[int]) -> None:
    seen: set[int] = set()
    for face in faces:
        if face in seen:
            raise InputError("the face has two laws", where="faces", found=face, allowed="one")
        seen.add(face)
