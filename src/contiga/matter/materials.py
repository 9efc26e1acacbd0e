"""Materials of what deforms, in the units of the case: the public names are `contiga.materials`.

A material says its stage of the kernels and its numbers for each kind of element it is for.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import ClassVar, NamedTuple, Protocol

import numpy as np

from contiga.errors import InputError
from contiga.matter.curves import CurveLike, as_table, at, packed
from contiga.matter.kernels.elements_stress_nb import ELASTIC, FOAM, NEO_HOOKE, SLACK
from contiga.num.arrays import positive
from contiga.records import FloatArray

SOLIDS = ("tet4", "hex8")
VOLUMES = ("element", "nodes")


class Coefficients(NamedTuple):
    """A material as kernels take it."""

    stage: int
    """Of the kernels `elements_stress_nb`."""
    numbers: FloatArray
    stiffest: int
    """The stage whose stiffness bounds that of this one wherever it may get to."""
    modulus: float
    """Young's modulus at rest, by which hourglass modes are held."""
    wave_modulus: float
    """That of pressure waves at rest, λ + 2 μ."""
    memory: int = 0
    """Numbers an element that are remembered."""
    asks_rates: bool = False
    averaged: float = 0.0
    """λ of what is averaged at nodes."""


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
            remedy="For rubber take 0.49 to 0.499, and volume='nodes' for tetrahedra",
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
            mu, lam = _lame(self.young, self.poisson)
            numbers = np.array([mu, lam])
            return Coefficients(ELASTIC, numbers, ELASTIC, self.young, lam + 2.0 * mu)
        numbers = np.array([self.young * thickness, self.poisson])
        stage = ELASTIC if self.compression else SLACK
        return Coefficients(stage, numbers, ELASTIC, self.young, self.young)


@dataclass(frozen=True, kw_only=True)
class NeoHooke:
    """Rubber: W = μ/2 (I₁ − 3) − μ ln J + λ/2 (J − 1)², at any strain.

    Membranes are in plane stress; their thickness changes with the strain.

    Parameters
    ----------
    young, poisson : of small strains; μ = E/2(1 + ν), λ = 2 μ ν/(1 − 2 ν)
    volume : whose change of volume λ acts on: that of each "element", or averaged at "nodes", by
        which tetrahedra do not lock as ν comes near a half (after Bonet and Burton, Commun. Numer.
        Methods Eng. 14, 1998). Only tet4 need it, and only theirs is averaged

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
        object.__setattr__(self, "poisson", _poisson(self.poisson, "poisson"))
        if self.volume not in VOLUMES:
            raise InputError(
                "is not known", where="volume", found=self.volume, allowed=", ".join(VOLUMES)
            )

    def coefficients(self, kind: str, thickness: float) -> Coefficients:
        """See `Material`."""
        mu, lam = _lame(self.young, self.poisson)
        numbers = np.array([mu, lam]) * (1.0 if kind in SOLIDS else thickness)
        wave = lam + 2.0 * mu
        averaged = lam if kind == "tet4" and self.volume == "nodes" else 0.0
        return Coefficients(NEO_HOOKE, numbers, NEO_HOOKE, self.young, wave, averaged=averaged)


@dataclass(frozen=True, kw_only=True, eq=False)
class Foam:
    """Low-density foam: principal nominal stresses that follow a curve each, without Poisson's
    ratio; it unloads by less than it loads, and may stiffen with the rate.

    Parameters
    ----------
    loading : (n, 2) rows [strain, stress] in compression, both nominal and above zero, from [0, 0];
        or a modulus. Beyond the last row its last piece goes on: let it be steep, so that elements
        do not turn inside out
    hysteresis : H, from 0 to 1; 1 gives back all that was taken
    shape : S > 0; what is given back of W is H + (1 − H)/(S + 1) after a full cycle
    tension : modulus in tension; the first slope of `loading` if omitted
    rates : pairs (rate, table) beside `loading`, which is at rest: at rising rates of nominal
        strain, 1/time, with stresses not below those of the table before
    filter : time by which rates are smoothed, needed with `rates`; some steps long

    Notes
    -----
    Below the largest energy Wₘ that was taken, the force is H + (1 − H) (W/Wₘ)^S of that of the
    curve (the form of LS-DYNA's MAT_57). Rates add the tables' excess at the rate of the stretch
    that is shortest. Between rates it is linear, above the last one it stays.

    Raises
    ------
    InputError
        A table that falls or does not begin at zero, numbers outside their range, rates that do
        not rise or stresses that fall with them.

    Examples
    --------
    >>> import contiga as cg
    >>> pad = cg.materials.Foam(loading=[[0, 0], [0.05, 0.1], [0.6, 0.2], [0.9, 3]], hysteresis=0.1)
    >>> pad.returned
    0.19
    """

    kinds: ClassVar[tuple[str, ...]] = SOLIDS

    loading: FloatArray
    hysteresis: float = 1.0
    shape: float = 9.0
    tension: float | None = None
    rates: tuple[tuple[float, FloatArray], ...] = ()
    filter: float | None = None

    def __post_init__(self) -> None:
        put = object.__setattr__
        put(self, "loading", as_table(self.loading, "loading"))
        if not 0.0 <= self.hysteresis <= 1.0:
            raise InputError(
                "is a share", where="hysteresis", found=self.hysteresis, allowed="0 to 1"
            )
        put(self, "shape", positive(self.shape, "shape"))
        first = float(self.loading[1, 1] / self.loading[1, 0])
        tension = first if self.tension is None else self.tension
        put(self, "tension", positive(tension, "tension"))
        put(self, "rates", tuple(_rate_curves(self.loading, self.rates)))
        if self.rates or self.filter is not None:
            put(self, "filter", positive(self.filter, "filter"))

    @property
    def returned(self) -> float:
        """Share of the energy taken that a full cycle gives back."""
        return self.hysteresis + (1.0 - self.hysteresis) / (self.shape + 1.0)

    def coefficients(self, kind: str, thickness: float) -> Coefficients:
        """See `Material`."""
        tables = [self.loading, *(table for _, table in self.rates)]
        strain = np.unique(np.concatenate([table[:, 0] for table in tables]))
        rest = np.stack([strain, at(self.loading, strain)], axis=1)
        head = [self.hysteresis, self.shape, self.tension, self.filter or 1.0]
        numbers = [np.array([*head, len(strain), len(tables)], dtype=np.float64), packed(rest)]
        numbers.append(np.array([0.0, *(rate for rate, _ in self.rates)]))
        numbers += [at(table, strain) for table in tables]
        modulus = float(rest[1, 1] / rest[1, 0])
        return Coefficients(
            FOAM, np.concatenate(numbers), FOAM, modulus, modulus, 2, len(self.rates) > 0
        )


def _rate_curves(
    rest: FloatArray, rates: Iterable[tuple[float, CurveLike]]
) -> Iterator[tuple[float, FloatArray]]:
    """Rates and their tables, checked one after the other."""
    last, before = 0.0, rest
    for k, (rate, curve) in enumerate(rates):
        name = f"rates[{k}]"
        if not last < float(rate) < np.inf:
            raise InputError("rates must rise", where=name, found=rate, allowed=f"> {last:.6g}")
        table = as_table(curve, name)
        strain = np.union1d(before[:, 0], table[:, 0])
        falls = at(table, strain) < at(before, strain) * (1.0 - 1e-12)
        if falls.any():
            raise InputError(
                f"the stress falls with the rate at the strain {strain[np.argmax(falls)]:.6g}",
                where=name,
                allowed="stresses not below those of the table before",
            )
        last, before = float(rate), table
        yield last, table
