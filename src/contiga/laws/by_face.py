"""Laws that differ from face to face of a master, such as skins and ribs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from contiga.errors import InputError
from contiga.laws.combined import CombinedLaw
from contiga.laws.law import Law, remembered
from contiga.laws.stress import StressLaw
from contiga.records import DepthSlopes, LawInput, LawOutput, LawTangent


@dataclass(frozen=True, init=False, eq=False)
class FaceLaws:
    """A law for each face of the master: a point has the law of the face that its foot is on.

    Parameters
    ----------
    rest : law of the faces that are not named
    faces : laws by face numbers from 0, one or several, in the order of `Body.patches`

    Notes
    -----
    When a foot moves to another face, the law of that face continues with the memory of the point:
    force and energy jump at the border if the laws differ.

    Raises
    ------
    InputError
        Laws that compute one force for all points together; a face that is named twice or is not a
        number from 0.

    >>> soft_rib = FaceLaws(StressLaw(10.0, 1.0), {(1, 2): StressLaw(4.0, 1.0)})
    >>> ones = np.ones(3)
    >>> inp = LawInput(0.1 * ones, 0.0 * ones, ones, None, None, 0.0, patch=np.array([0, 1, 2]))
    >>> soft_rib.respond(inp).force.round(12).tolist()
    [1.0, 0.4, 0.4]
    """

    laws: tuple[Law, ...]
    """Law of the faces that are not named, and the laws of the others in their order."""
    faces: tuple[tuple[int, ...], ...]
    """Faces of each law but the first."""

    def __init__(self, rest: Law, faces: Mapping[int | tuple[int, ...], Law]) -> None:
        groups: list[tuple[int, ...]] = []
        named: set[int] = set()
        for key in faces:
            group = key if isinstance(key, tuple) else (key,)
            for face in group:
                is_whole = isinstance(face, int | np.integer) and not isinstance(face, bool)
                if not is_whole or face < 0:
                    raise InputError(
                        "is not a face", where="faces", found=face, allowed="a whole number from 0"
                    )
                if face in named:
                    raise InputError(
                        "the face has two laws", where="faces", found=face, allowed="one"
                    )
                named.add(int(face))
            groups.append(tuple(map(int, group)))
        object.__setattr__(self, "laws", (rest, *faces.values()))
        object.__setattr__(self, "faces", tuple(groups))
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
        """Return the largest number of a named face, −1 without any."""
        return max((face for faces in self.faces for face in faces), default=-1)

    def with_slave(self, slave: StressLaw) -> FaceLaws:
        """Return the laws of the same faces, each a `CombinedLaw` with the slave's side.

        Raises
        ------
        InputError
            A law that `CombinedLaw` refuses as the master's side, or the slave's.
        """
        laws = [CombinedLaw(slave, law) for law in self.laws]  # type: ignore[arg-type]
        return FaceLaws(laws[0], dict(zip(self.faces, laws[1:], strict=True)))

    def respond(self, inp: LawInput) -> LawOutput:
        """Return the forces of each point by the law of its face, which `inp.patch` has to name.

        Memories of laws with fewer columns are filled up with zeros. There is no tangent if one of
        the laws with points has none.
        """
        assert inp.patch is not None
        n, memory = len(inp.penetration), remembered(inp, self.n_memory)
        force, stiffness, stored, hysteresis, damping = np.zeros((5, n))
        slope, viscosity, bend = np.zeros((3, n))
        new_memory, has_tangent = np.zeros((n, self.n_memory)), inp.wants_tangent
        law_of_point = np.zeros(n, np.intp)
        for k, faces in enumerate(self.faces, start=1):
            law_of_point[np.isin(inp.patch, faces)] = k
        for k, law in enumerate(self.laws):
            rows = np.flatnonzero(law_of_point == k)
            if len(rows) == 0:
                continue
            inputs: list[Any] = [
                column[rows] if isinstance(column, np.ndarray) and len(column) else column
                for column in inp
            ]
            old = memory[rows, : law.n_memory]
            out = law.respond(LawInput._make(inputs)._replace(memory=old))
            force[rows], stiffness[rows], stored[rows] = out.force, out.stiffness, out.stored
            new_memory[rows, : out.memory.shape[1]] = out.memory
            if out.hysteresis is not None:
                hysteresis[rows] = out.hysteresis
            if out.damping is not None:
                damping[rows] = out.damping
            if not isinstance(slopes := out.tangent, LawTangent):
                has_tangent = False
                continue
            slope[rows] = slopes.force.own
            viscosity[rows] = 0.0 if slopes.rate is None else slopes.rate
            bend[rows] = 0.0 if slopes.stiffness is None else slopes.stiffness.own
        tangent = LawTangent(DepthSlopes(slope), viscosity, DepthSlopes(bend))
        return LawOutput(
            force,
            stiffness,
            stored,
            new_memory,
            hysteresis,
            damping,
            tangent=tangent if has_tangent else None,
        )
