"""Gases whose heat capacity is constant, a table or a polynomial, and mixtures of them."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numba import njit
from scipy.integrate import quad

from contiga.dynamics.gas import Chamber, Chambers, Exposed, Inflator, Surroundings
from contiga.dynamics.gas_tables import GasTable, gas_table
from contiga.dynamics.gases import Gas, IdealGas, Mixture, ThermallyPerfectGas
from contiga.dynamics.kernels import gases_nb
from contiga.errors import InputError

AIR = IdealGas(1.4, 287.05)
TABLE = ThermallyPerfectGas(296.8, [[300.0, 1040.0], [600.0, 1075.0], [1000.0, 1167.0]])
CURVED = ThermallyPerfectGas(188.9, [500.0, 1.4, -6e-4], between=(250.0, 1100.0))


@njit
def of_kernels(gases: Any, g: int, start: float, end: float) -> Any:
    return (
        gases_nb.heat_capacity(gases, g, end),
        gases_nb.enthalpy(gases, g, end),
        gases_nb.entropy(gases, g, start, end),
    )


@njit
def of_masses(gases: Any, masses: Any, start: float, end: float) -> Any:
    return (
        gases_nb.mass_of(masses),
        gases_nb.constant_of(gases, masses),
        gases_nb.enthalpy_of(gases, masses, end),
        gases_nb.energy_of(gases, masses, end),
        gases_nb.capacity_of(gases, masses, end),
        gases_nb.entropy_of(gases, masses, start, end),
    )


@pytest.mark.interpreted
@pytest.mark.parametrize("end", [100.0, 250.0, 300.0, 450.0, 1000.0, 1100.0, 2000.0])
def test_kernels_have_the_heat_of_gases_and_of_their_mixtures(end: float) -> None:
    gases, start, masses = (AIR, TABLE, CURVED), 280.0, np.array([0.3, 0.5, 0.2])
    table: GasTable = gas_table(gases)
    known = [(g.heat_capacity(end), g.enthalpy(end), g.entropy(start, end)) for g in gases]
    for g, expected in enumerate(known):
        np.testing.assert_allclose(of_kernels(table, g, start, end), expected, rtol=1e-13)
    heat, enthalpy, entropy = masses @ np.array(known)
    constant = masses @ [gas.constant for gas in gases]
    expected = 1.0, constant, enthalpy, enthalpy - constant * end, heat - constant, entropy
    np.testing.assert_allclose(of_masses(table, masses, start, end), expected, rtol=1e-12)


@pytest.mark.parametrize("gas", [AIR, TABLE, CURVED])
@pytest.mark.parametrize("ends", [(280.0, 290.0), (310.0, 900.0), (150.0, 1500.0), (800.0, 400.0)])
def test_enthalpy_and_entropy_are_integrals(gas: Gas, ends: tuple[float, float]) -> None:
    start, end = ends
    breaks = [t for t in (250.0, 300.0, 600.0, 1000.0, 1100.0) if min(ends) < t < max(ends)]
    options: dict[str, Any] = {"points": breaks, "epsabs": 1e-9, "epsrel": 1e-12}
    heat, _ = quad(gas.heat_capacity, start, end, **options)
    entropy, _ = quad(lambda t: gas.heat_capacity(t) / t, start, end, **options)
    assert gas.enthalpy(end) - gas.enthalpy(start) == pytest.approx(heat, rel=1e-11)
    assert gas.entropy(start, end) == pytest.approx(entropy, rel=1e-11)


def test_a_table_of_one_row_is_a_constant() -> None:
    one = ThermallyPerfectGas(287.05, [[300.0, AIR.c_p]])
    for t in (200.0, 300.0, 900.0):
        assert one.enthalpy(t) == pytest.approx(AIR.enthalpy(t), rel=1e-14)
        assert one.entropy(250.0, t) == pytest.approx(AIR.entropy(250.0, t), rel=1e-12)


def test_a_mixture_keeps_its_energy_while_it_is_squeezed_and_back() -> None:
    """What comes in is in the gas; there and back, through many volumes, nothing is lost."""
    around = Surroundings(101_325.0, 293.15, Mixture([(AIR, 0.7), (CURVED, 0.3)]))
    chambers = Chambers(
        [Chamber("bag", around, inflators=[Inflator([[0, 1], [0.01, 1]], 900.0, TABLE)])]
    )
    (first,) = chambers.start(np.array([0.06]))
    (now,) = chambers.step([first], np.array([0.06]), [Exposed(0.0, np.zeros(0))], 0.01, 0.01)
    assert now.energy == pytest.approx(first.energy + 0.01 * TABLE.enthalpy(900.0), rel=1e-14)
    assert now.energy == pytest.approx(chambers._energy(now.masses, now.temperature))
    blown = now
    for k in range(1, 201):
        volume = 0.06 - 0.04 * math.sin(math.pi * k / 200)
        (now,) = chambers.step(
            [now], np.array([volume]), [Exposed(0.0, np.zeros(0))], 0.02 + 0.001 * k, 0.001
        )
        if k == 100:
            assert now.temperature > 1.3 * blown.temperature
    assert now.temperature == pytest.approx(blown.temperature, rel=1e-12)
    assert now.energy == pytest.approx(blown.energy, rel=1e-12)


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: ThermallyPerfectGas(287.0, [[300.0, 200.0]]), "above the gas constant"),
        (lambda: ThermallyPerfectGas(287.0, [1000.0, -1.0], between=(300, 900)), "above the gas"),
        (lambda: ThermallyPerfectGas(287.0, [1000.0]), "between two temperatures"),
        (lambda: ThermallyPerfectGas(287.0, [1000.0], between=(900, 300)), "between two"),
        (lambda: ThermallyPerfectGas(287.0, [[300, 1e3]], between=(3, 9)), "its own temperatures"),
        (lambda: ThermallyPerfectGas(287.0, [[0.0, 1000.0]]), "above 0 K"),
        (lambda: ThermallyPerfectGas(0.0, [[300.0, 1000.0]]), "constant"),
        (lambda: Mixture([]), "sum up to one"),
        (lambda: Mixture([(AIR, 0.4), (TABLE, 0.4)]), "sum up to one"),
        (lambda: Mixture([(AIR, 0.5), (AIR, 0.5)]), "same gas twice"),
        (lambda: Mixture([("air", 1.0)]), "must be a gas"),
    ],
)
def test_what_is_wrong_is_told(make: Any, said: str) -> None:
    with pytest.raises(InputError, match=said):
        make()
