"""Materials of what deforms, in the units of the case: the public names are `contiga.materials`.

A material says its stage of the kernels and its numbers for each kind of element it is for.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, NamedTuple, Protocol

import numpy as np

from contiga.errors import InputError
from contiga.matter.kernels.elements_stress_nb import ELASTIC, NEO_HOOKE, SLACK
from contiga.num.arrays import positive
from contiga.records import FloatArray

SOLIDS = ("tet4", "hex8")


class Coefficients(NamedTuple):
    """A material as kernels take it."""

    stage: int
    """Of the kernels `elements_stress_nb`."""
    numbers: FloatArray
    stiffest: int
    """The stage whose stiffness bounds that of this one wherever it may get to."""
    modulus: float
    """Young's modulus at rest, by which hourglass modes are held."""


class Material(Protocol):
    """What is asked of a material."""

    kinds: ClassVar[tuple[str, ...]]
    """Elements it is for."""

    def coefficients(self, kind: str, thickness: float) -> Coefficients:
        """For elements of a kind; thickness is that of a membrane."""


def _poisson(value: object, name: str) -> float:
    """Poisson's ratio, above −1 and below ½."""
    allowed = "a number above -1 and below 0.5"
    try:
        number = float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError) as error:
        raise InputError("must be a number", where=name, found=value, allowed=allowed) from error
    if not -1.0 < number < 0.5:
        raise InputError(
            "Poisson's ratio of what can be pressed together is below a half",
            where=name,
            found=value,
            allowed=allowed,
            remedy="For rubber take 0.49 to 0.499",
        )
    return number


def _lame(young: float, poisson: float) -> tuple[float, float]:
    """μ and λ."""
    mu = 0.5 * young / (1.0 + poisson)
    return mu, 2.0 * mu * poisson / (1.0 - 2.0 * poisson)


@dataclass(frozen=True, kw_only=True)
class Elastic:
    """Linear in Green's strain: small strains, turned as far as they like.

    The material of Saint-Venant and Kirchhoff, S = λ tr(E) I + 2 μ E; membranes are in plane
    stress. Where it is pressed together to less than 0.6 of its length it softens: take `NeoHooke`.

    Parameters
    ----------
    young : Young's modulus, force / area
    poisson : Poisson's ratio, above −1 and below ½
    compression : False for membranes that wrinkle instead of carrying compression (a tension
        field) and for bars that go slack: cloth, cables

    Raises
    ------
    InputError
        A number outside its range.

    Examples
    --------
    >>> import contiga as cg
    >>> cg.materials.Elastic(young=210e3, poisson=0.3)
    Elastic(young=210000.0, poisson=0.3, compression=True)
    """

    kinds: ClassVar[tuple[str, ...]] = (*SOLIDS, "tri3")

    young: float
    poisson: float = 0.0
    compression: bool = True

    def __post_init__(self) -> None:
        object.__setattr__(self, "young", positive(self.young, "young"))
        object.__setattr__(self, "poisson", _poisson(self.poisson, "poisson"))

    def coefficients(self, kind: str, thickness: float) -> Coefficients:
        """See `Material`."""
        if kind in SOLIDS:
            if not self.compression:
                raise InputError(
                    "solids carry compression", where="compression", found=False, allowed="True"
                )
            numbers = np.array(_lame(self.young, self.poisson))
            return Coefficients(ELASTIC, numbers, ELASTIC, self.young)
        numbers = np.array([self.young * thickness, self.poisson])
        stage = ELASTIC if self.compression else SLACK
        return Coefficients(stage, numbers, ELASTIC, self.young)


@dataclass(frozen=True, kw_only=True)
class NeoHooke:
    """Rubber: W = μ/2 (I₁ − 3) − μ ln J + λ/2 (J − 1)², at any strain.

    Membranes are in plane stress; their thickness changes with the strain.

    Parameters
    ----------
    young, poisson : of small strains; μ = E/2(1 + ν), λ = 2 μ ν/(1 − 2 ν)

    Raises
    ------
    InputError
        A number outside its range.

    Examples
    --------
    >>> import contiga as cg
    >>> cg.materials.NeoHooke(young=3.0, poisson=0.49)
    NeoHooke(young=3.0, poisson=0.49)
    """

    kinds: ClassVar[tuple[str, ...]] = (*SOLIDS, "tri3")

    young: float
    poisson: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "young", positive(self.young, "young"))
        object.__setattr__(self, "poisson", _poisson(self.poisson, "poisson"))

    def coefficients(self, kind: str, thickness: float) -> Coefficients:
        """See `Material`."""
        numbers = np.array(_lame(self.young, self.poisson))
        scale = 1.0 if kind in SOLIDS else thickness
        return Coefficients(NEO_HOOKE, scale * numbers, NEO_HOOKE, self.young)
