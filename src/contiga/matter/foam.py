"""Low-density foam, in the units of the case: see `contiga.materials`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from contiga.arrays.layout import positive
from contiga.curves.characteristic import Characteristic
from contiga.curves.curve_records import joined
from contiga.errors import InputError
from contiga.matter.coefficients import SOLIDS, Coefficients, Reach
from contiga.matter.curves import as_table
from contiga.matter.kernels.elements_stress_nb import FOAM
from contiga.matter.kernels.solid_foam_nb import MEMORY, MEMORY_OF_RATES, REACHED
from contiga.records import FloatArray


@dataclass(frozen=True, kw_only=True, eq=False)
class Foam:
    """Low-density foam, whose principal nominal stresses each follow a curve.

    It has no Poisson's ratio, unloads with less stress than it loads, and may stiffen with the
    rate.

    Parameters
    ----------
    loading : (n, 2) rows [strain, stress] in compression, both nominal and above zero, from [0, 0];
        or a modulus. The last piece is extrapolated: make it steep, so that elements do not turn
        inside out
    hysteresis : H, from 0 to 1; 1 has no hysteresis
    shape : S > 0; a full cycle returns the share H + (1 − H)/(S + 1) of W
    tension : modulus in tension; the first slope of `loading` if omitted
    rates : pairs (rate, table) at rising rates of nominal strain, 1/time, with stresses not below
        those of the previous table; `loading` is quasi-static
    filter : time constant of the filter of rates, needed with `rates`; some steps long

    Notes
    -----
    Below the largest energy Wₘ so far the force is that of the curve times H + (1 − H) (W/Wₘ)^S
    (the form of LS-DYNA's MAT_57). To each principal stress in compression the difference between
    the tables at its rate and `loading` is added, linear between rates, constant above the last. At
    a constant rate the stress is that of its table. An opening stretch has no overstress once the
    filter has settled, and no path of strain gains energy: the filter acts as a spring in series
    with a dashpot.

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
        rates: list[tuple[float, FloatArray]] = []
        last_rate, last_table = 0.0, self.loading
        for k, (rate, curve) in enumerate(self.rates):
            name = f"rates[{k}]"
            if not last_rate < float(rate) < np.inf:
                raise InputError(
                    "rates must rise", where=name, found=rate, allowed=f"> {last_rate:.6g}"
                )
            table = as_table(curve, name)
            strain = np.union1d(last_table[:, 0], table[:, 0])
            lower_bound = Characteristic(last_table)(strain) * (1.0 - 1e-12)
            falls = Characteristic(table)(strain) < lower_bound
            if falls.any():
                raise InputError(
                    f"the stress falls with the rate at the strain {strain[np.argmax(falls)]:.6g}",
                    where=name,
                    allowed="stresses not below those of the table before",
                )
            last_rate, last_table = float(rate), table
            rates.append((last_rate, table))
        put(self, "rates", tuple(rates))
        if self.rates or self.filter is not None:
            put(self, "filter", positive(self.filter, "filter"))

    @property
    def returned(self) -> float:
        """Share of the energy that a full cycle returns."""
        return self.hysteresis + (1.0 - self.hysteresis) / (self.shape + 1.0)

    def coefficients(self, kind: str, across: float) -> Coefficients:
        """See `Material`."""
        tables = [self.loading, *(table for _, table in self.rates)]
        parameters = [self.hysteresis, self.shape, self.tension, self.filter or 1.0]
        numbers = np.array([*parameters, 0.0, *(rate for rate, _ in self.rates)], dtype=np.float64)
        secants = self.loading[1:, 1] / self.loading[1:, 0]
        first, least = float(secants[0]), float(secants.min())
        return Coefficients(
            FOAM,
            numbers,
            least if least > 0.0 else first,  # hourglass modes as soft as the plateau
            first,
            memory=MEMORY_OF_RATES if self.rates else MEMORY,
            reaches=Reach.of("strain", self.loading, REACHED),
            curves=joined(*(Characteristic(table).pieces for table in tables)),
        )
