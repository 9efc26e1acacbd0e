"""Elastic materials, in the units of the case: see `contiga.materials`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from contiga.arrays.layout import positive
from contiga.errors import InputError
from contiga.matter.coefficients import NONE, SOLIDS, Coefficients, lame, poisson_ratio
from contiga.matter.kernels.elements_stress_nb import BAR, ELASTIC, NEO_HOOKE, SLACK

VOLUMES = ("element", "nodes")


@dataclass(frozen=True, kw_only=True)
class Elastic:
    """Linear elasticity in Green's strain, for small strains and any rotations.

    The Saint-Venant-Kirchhoff material S = λ tr(E) I + 2 μ E; membranes are in plane stress. It
    softens when compressed to less than 0.6 of its length: use `NeoHooke` there.

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

    kinds: ClassVar[tuple[str, ...]] = (*SOLIDS, "tri3", "bar2")

    young: float
    poisson: float = 0.0
    compression: bool = True

    def __post_init__(self) -> None:
        object.__setattr__(self, "young", positive(self.young, "young"))
        object.__setattr__(self, "poisson", poisson_ratio(self.poisson, "poisson"))

    def coefficients(self, kind: str, across: float) -> Coefficients:
        """See `Material`."""
        if kind in SOLIDS:
            if not self.compression:
                raise InputError(
                    "solids carry compression", where="compression", found=False, allowed="True"
                )
            mu, lam = lame(self.young, self.poisson)
            numbers = np.array([mu, lam])
            return Coefficients(ELASTIC, numbers, self.young, lam + 2.0 * mu)
        if kind == "bar2":
            stiffness = self.young * across
            numbers = np.array([stiffness, stiffness if self.compression else 0.0, 0.0])
            return Coefficients(BAR, numbers, self.young, self.young)
        numbers = np.array([self.young * across, self.poisson])
        plane = self.young * across / (1.0 - self.poisson**2)
        tangent = plane * np.array([1.0, 1.0, self.poisson, 0.5 * (1.0 - self.poisson)])
        law = ELASTIC if self.compression else SLACK
        bending = tangent if self.compression else NONE
        return Coefficients(law, numbers, self.young, self.young, tangent, bending)


@dataclass(frozen=True, kw_only=True)
class NeoHooke:
    """Rubber-like material, W = μ/2 (I₁ − 3) − μ ln J + λ/2 (J − 1)², for large strains.

    Membranes are in plane stress; their thickness changes with the strain.

    Parameters
    ----------
    young, poisson : at small strains; μ = E/2(1 + ν), λ = 2 μ ν/(1 − 2 ν)
    volume : change of volume that λ acts on: that of each "element", or the average at "nodes",
        with which tetrahedra do not lock as ν approaches ½ (after Bonet and Burton, Commun. Numer.
        Methods Eng. 14, 1998). It affects tet4 only

    Raises
    ------
    InputError
        A number outside its range.

    Examples
    --------
    >>> import contiga as cg
    >>> cg.materials.NeoHooke(young=3.0, poisson=0.49)
    NeoHooke(young=3.0, poisson=0.49, volume='element')
    """

    kinds: ClassVar[tuple[str, ...]] = (*SOLIDS, "tri3")

    young: float
    poisson: float
    volume: str = "element"

    def __post_init__(self) -> None:
        object.__setattr__(self, "young", positive(self.young, "young"))
        object.__setattr__(self, "poisson", poisson_ratio(self.poisson, "poisson"))
        if self.volume not in VOLUMES:
            raise InputError(
                "is not known", where="volume", found=self.volume, allowed=", ".join(VOLUMES)
            )

    def coefficients(self, kind: str, across: float) -> Coefficients:
        """See `Material`."""
        mu, lam = lame(self.young, self.poisson)
        numbers = np.array([mu, lam]) * (1.0 if kind in SOLIDS else across)
        wave = lam + 2.0 * mu
        averaged = lam if kind == "tet4" and self.volume == "nodes" else 0.0
        return Coefficients(NEO_HOOKE, numbers, self.young, wave, averaged=averaged)
