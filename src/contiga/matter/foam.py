"""Low-density foam, in the units of the case: see `contiga.materials`."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from contiga.arrays.layout import positive
from contiga.curves.characteristic import Characteristic
from contiga.curves.curve_records import joined
from contiga.errors import InputError
from contiga.matter.coefficients import SOLIDS, Coefficients, Reach
from contiga.matter.curves import CurveLike, as_table
from contiga.matter.kernels.elements_stress_nb import FOAM
from contiga.matter.kernels.solid_foam_nb import MEMORY, MEMORY_OF_RATES, REACHED
from contiga.records import FloatArray


@dataclass(frozen=True, kw_only=True, eq=False)
class Foam:
    """Low-density foam, whose principal nominal stresses follow a curve each.

    It has no Poisson's ratio, unloads with less stress than it loads, and may stiffen with the
    rate.

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
    curve (the form of LS-DYNA's MAT_57). Each principal stretch that shortens has what the tables
    have above `loading` at its own rate added, linear between rates; above the last one it stays.
    At a steady rate the stress is that of its table. What opens has none once the filter has
    settled, and no path of strain gains energy: the filter is a spring in series with a dashpot.

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

    def coefficients(self, kind: str, across: float) -> Coefficients:
        """See `Material`."""
        tables = [self.loading, *(table for _, table in self.rates)]
        head = [self.hysteresis, self.shape, self.tension, self.filter or 1.0]
        numbers = np.array([*head, 0.0, *(rate for rate, _ in self.rates)], dtype=np.float64)
        secants = self.loading[1:, 1] / self.loading[1:, 0]
        first, least = float(secants[0]), float(secants.min())
        return Coefficients(
            FOAM,
            numbers,
            least if least > 0.0 else first,  # hourglass modes of a plateau are as soft as that
            first,
            memory=MEMORY_OF_RATES if self.rates else MEMORY,
            reaches=Reach.of("strain", self.loading, REACHED),
            curves=joined(*(Characteristic(table).pieces for table in tables)),
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
        falls = Characteristic(table)(strain) < Characteristic(before)(strain) * (1.0 - 1e-12)
        if falls.any():
            raise InputError(
                f"the stress falls with the rate at the strain {strain[np.argmax(falls)]:.6g}",
                where=name,
                allowed="stresses not below those of the table before",
            )
        last, before = float(rate), table
        yield last, table
