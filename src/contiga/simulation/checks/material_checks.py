"""Find densities, moduli, curves and rates that are impossible for a material."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from contiga.dynamics.deforming_nodes import DeformingNodes
from contiga.matter.foam import Foam
from contiga.matter.materials import Elastic, NeoHooke
from contiga.matter.parts import DIMENSION, Part
from contiga.matter.woven import Belt, Fabric
from contiga.records import FloatArray
from contiga.simulation.checks.finding import Finding, Quantities
from contiga.simulation.checks.law_checks import MAX_STRAIN, in_percent, odd_strength
from contiga.simulation.checks.mass_checks import DENSITY_RANGE
from contiga.simulation.checks.scene import Scene

# Speed of pressure waves √(M/ρ), m/s: from soft gel to above diamond. Light materials have at most
# the speed of balsa along its grain, heavy ones at least that of rubber filled with tungsten.
_WAVE_SPEED_RANGE = (0.2, 2e4)
_LIGHT_DENSITY, _MAX_LIGHT_SPEED = 300.0, 7e3
_HEAVY_DENSITY, _MIN_HEAVY_SPEED = 3000.0, 20.0
# Wave modulus M, Pa: from shaving foam to above diamond.
_MODULUS_RANGE = (50.0, 2e12)
# Strain rates, 1/s: from below any quasi-static test to above a split Hopkinson bar.
_RATE_RANGE = (1e-3, 1e4)
# Largest strain of webbing and cloth: that of rubber bands.
_MAX_STRETCH = 3.0
# Poisson's ratio from which tetrahedra lock: the error of a block under a punch is twice that of
# the same mesh at 0 (19 instead of 9 % with eight elements over its height, 38 instead of 16 % with
# four).
_LOCKING_POISSON = 0.47


def check_materials(scene: Scene) -> Iterator[Finding]:
    """Report numbers of materials that are most likely in another unit, and meshes that lock.

    Densities, moduli and strengths are judged only if the case has units.
    """
    for name, nodes in scene.model.mechanism.nodes.items():
        if not isinstance(nodes, DeformingNodes):
            continue
        where = f"slave {name}"
        for part in nodes.parts:
            elements = elements_of(part.name, nodes.parts)
            if scene.fmt.known:
                odd = [*_check_units(where, elements, part, scene.fmt)]
                yield from odd
                if not odd and isinstance(part.material, Foam):  # which carries what no foam does
                    strain, stress = part.material.loading.T
                    half = float(np.interp(0.5, strain, stress))
                    subject = f"the curve of {elements}"
                    yield from odd_strength(float(strain[-1]), half, where, subject, scene.fmt)
            yield from _check_rates(where, elements, part, scene)
            material, tables = part.material, dict[str, FloatArray]()
            if isinstance(material, Foam | Belt):
                tables = {"curve": material.loading}
            elif isinstance(material, Fabric):
                assert material.weft is not None
                tables = {"warp": material.warp, "weft": material.weft}
            max_strain = MAX_STRAIN if isinstance(material, Foam) else _MAX_STRETCH
            for curve, table in tables.items():
                if in_percent(table[:, 0], max_strain):
                    yield Finding(
                        "curve",
                        where,
                        f"the {curve} of {elements} has strains of {table[-2, 0]:.4g} and "
                        f"{table[-1, 0]:.4g}, and no such matter is "
                        f"{'pressed' if max_strain == MAX_STRAIN else 'pulled'} so far",
                        "Give strains as shares of the length: 0.5 is 50 %",
                    )
            if part.kind != "tet4" or not isinstance(material, Elastic | NeoHooke):
                continue
            averaged = isinstance(material, NeoHooke) and material.volume == "nodes"
            if not averaged and material.poisson >= _LOCKING_POISSON:
                yield Finding(
                    "locking",
                    where,
                    f"{elements}, tetrahedra, lock at a Poisson's ratio of {material.poisson:g}: "
                    "each keeps its volume, which leaves nodes few ways to go, and "
                    "all is too stiff",
                    'Take NeoHooke with volume = "nodes", or hexahedra',
                )


def elements_of(name: str, parts: Sequence[Part]) -> str:
    """Return the words for the elements of a part, with its name where a slave has several."""
    return "its elements" if len(parts) == 1 else f"the elements of {name.rsplit(': ', 1)[-1]}"


def _check_units(where: str, elements: str, part: Part, fmt: Quantities) -> Iterator[Finding]:
    """Report an impossible density, or else an impossible modulus or wave speed."""
    wave_modulus = part.material.coefficients(part.kind, part.across).wave_modulus
    density, modulus = part.density * fmt.si(-3, 1, 0), wave_modulus * fmt.si(-1, 1, -2)
    # With a thickness or section of one the density is a mass per area or per length.
    by_volume = DIMENSION[part.kind] == 3 or part.across != 1.0
    if by_volume and not DENSITY_RANGE[0] <= density <= DENSITY_RANGE[1]:
        water = 1000.0 / fmt.si(-3, 1, 0)
        yield Finding(
            "density",
            where,
            f"the density of {elements} is {part.density:.4g}, which is {density:.4g} kg/m³",
            f"Give it in {fmt.unit('mass')} per {fmt.unit('length')}³: water has {water:.4g}",
        )
        return
    slowest, fastest = _WAVE_SPEED_RANGE
    if by_volume:
        slowest = _MIN_HEAVY_SPEED if density > _HEAVY_DENSITY else slowest
        fastest = _MAX_LIGHT_SPEED if density < _LIGHT_DENSITY else fastest
    speed = float(np.sqrt(modulus / density))
    if not (slowest <= speed <= fastest and _MODULUS_RANGE[0] <= modulus <= _MODULUS_RANGE[1]):
        yield Finding(
            "modulus",
            where,
            f"with a density of {density:.4g} kg/m³ and a modulus of {fmt(wave_modulus, 'stress')} "
            f"waves go through {elements} at {speed:.4g} m/s: no matter is that "
            f"{'soft' if speed < slowest or modulus < _MODULUS_RANGE[0] else 'stiff'}",
            f"Look at both: with these units stresses are in {fmt.unit('stress')}, densities in "
            f"{fmt.unit('mass')} per {fmt.unit('length')}³",
        )


def _check_rates(where: str, elements: str, part: Part, scene: Scene) -> Iterator[Finding]:
    """Report the largest rate of a foam outside `_RATE_RANGE`, and smoothing longer than the run.

    The range is tested only if the case has units.
    """
    if not (isinstance(part.material, Foam) and part.material.rates):
        return
    fmt, stepping = scene.fmt, scene.model.stepping
    largest = part.material.rates[-1][0]
    metric = largest * fmt.si(0, 0, -1)
    if fmt.known and not _RATE_RANGE[0] <= metric <= _RATE_RANGE[1]:
        yield Finding(
            "rates",
            where,
            f"the curves of {elements} go up to a rate of {largest:.4g}, which is {metric:.4g} 1/s",
            f"Give rates in 1/{fmt.unit('time')}: 100/s is {100.0 / fmt.si(0, 0, -1):.4g}",
        )
    smoothed, span = part.material.filter, stepping.end - stepping.start
    assert smoothed is not None
    if smoothed > span:
        yield Finding(
            "rates",
            where,
            f"rates of {elements} are smoothed over {fmt(smoothed, 'time')}, and the run "
            f"takes {fmt(span, 'time')}: they hardly rise",
            f"Give filter in {fmt.unit('time')}, some steps long",
        )
