"""Find densities, moduli, curves and rates that no material has."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from contiga.dynamics.deforming_nodes import DeformingNodes
from contiga.matter.foam import Foam
from contiga.matter.materials import Elastic, NeoHooke
from contiga.matter.parts import DIMENSION, Part
from contiga.matter.woven import Belt, Fabric
from contiga.records import FloatArray
from contiga.simulation.checks.finding import Finding, Said
from contiga.simulation.checks.law_checks import PRESSED, in_percent, odd_strength
from contiga.simulation.checks.mass_checks import DENSITIES
from contiga.simulation.checks.scene import Scene

# m/s, √(M/ρ) of pressure waves: from soft gel to more than diamond has; of what is lighter than
# balsa no more than that has along its grain, of what is heavier than stone no less than rubber
# that is full of tungsten.
_WAVES = (0.2, 2e4)
_LIGHT, _OF_LIGHT = 300.0, 7e3
_HEAVY, _OF_HEAVY = 3000.0, 20.0
# Pa, M of pressure waves: from foam that is shaved with to more than diamond has.
_MODULI = (50.0, 2e12)
# 1/s: slower than any test at rest, faster than a split Hopkinson bar.
_RATES = (1e-3, 1e4)
# Strains that threads of webbing and cloth reach: those of rubber bands.
_STRETCHED = 3.0
# Poisson's ratio at which a block of tetrahedra resists a punch by twice as much too much as the
# same mesh does at 0: by 19 for 9 %, eight of them over its height, by 38 for 16 %, four of them.
_LOCKS = 0.47


def check_materials(scene: Scene) -> Iterator[Finding]:
    """Report numbers of materials that are most likely in another unit."""
    for name, nodes in scene.model.mechanism.nodes.items():
        if not isinstance(nodes, DeformingNodes):
            continue
        where = f"slave {name}"
        for part in nodes.parts:
            what = elements_of(part.name, nodes.parts)
            if scene.said.known:
                odd = [*_units(where, what, part, scene.said)]
                yield from odd
                if not odd and isinstance(part.material, Foam):  # which carries what no foam does
                    strain, stress = part.material.loading.T
                    half = float(np.interp(0.5, strain, stress))
                    of_it = f"the curve of {what}"
                    yield from odd_strength(float(strain[-1]), half, where, of_it, scene.said)
            yield from _rates(where, what, part, scene)
            material, tables = part.material, dict[str, FloatArray]()
            if isinstance(material, Foam | Belt):
                tables = {"curve": material.loading}
            elif isinstance(material, Fabric):
                assert material.weft is not None
                tables = {"warp": material.warp, "weft": material.weft}
            most = PRESSED if isinstance(material, Foam) else _STRETCHED
            for curve, table in tables.items():
                if in_percent(table[:, 0], most):
                    yield Finding(
                        "curve",
                        where,
                        f"the {curve} of {what} has strains of {table[-2, 0]:.4g} and "
                        f"{table[-1, 0]:.4g}, and no such matter is "
                        f"{'pressed' if most == PRESSED else 'pulled'} so far",
                        "Give strains as shares of the length: 0.5 is 50 %",
                    )
            if part.kind != "tet4" or not isinstance(material, Elastic | NeoHooke):
                continue
            averaged = isinstance(material, NeoHooke) and material.volume == "nodes"
            if not averaged and material.poisson >= _LOCKS:
                yield Finding(
                    "locking",
                    where,
                    f"{what}, tetrahedra, lock at a Poisson's ratio of {material.poisson:g}: each "
                    "keeps its volume, which leaves nodes few ways to go, and all is too stiff",
                    'Take NeoHooke with volume = "nodes", or hexahedra',
                )


def elements_of(name: str, parts: Sequence[Part]) -> str:
    """Return the words for the elements of a part, with its name where a slave has several."""
    return "its elements" if len(parts) == 1 else f"the elements of {name.rsplit(': ', 1)[-1]}"


def _units(where: str, what: str, part: Part, said: Said) -> Iterator[Finding]:
    """Report densities, moduli and wave speeds that no material has."""
    own = part.material.coefficients(part.kind, part.across).wave_modulus
    density, modulus = part.density * said.si(-3, 1, 0), own * said.si(-1, 1, -2)
    # A thickness or a section of one makes it a mass by area or by length.
    by_volume = DIMENSION[part.kind] == 3 or part.across != 1.0
    if by_volume and not DENSITIES[0] <= density <= DENSITIES[1]:
        water = 1000.0 / said.si(-3, 1, 0)
        yield Finding(
            "density",
            where,
            f"the density of {what} is {part.density:.4g}, which is {density:.4g} kg/m³",
            f"Give it in {said.unit('mass')} per {said.unit('length')}³: water has {water:.4g}",
        )
        return
    slowest, fastest = _WAVES
    if by_volume:
        slowest = _OF_HEAVY if density > _HEAVY else slowest
        fastest = _OF_LIGHT if density < _LIGHT else fastest
    speed = float(np.sqrt(modulus / density))
    if not (slowest <= speed <= fastest and _MODULI[0] <= modulus <= _MODULI[1]):
        yield Finding(
            "modulus",
            where,
            f"with a density of {density:.4g} kg/m³ and a modulus of {said(own, 'stress')} waves "
            f"go through {what} at {speed:.4g} m/s: no matter is that "
            f"{'soft' if speed < slowest or modulus < _MODULI[0] else 'stiff'}",
            f"Look at both: with these units stresses are in {said.unit('stress')}, densities in "
            f"{said.unit('mass')} per {said.unit('length')}³",
        )


def _rates(where: str, what: str, part: Part, scene: Scene) -> Iterator[Finding]:
    """Report rates that nothing reaches or everything exceeds, or that are smoothed away."""
    if not (isinstance(part.material, Foam) and part.material.rates):
        return
    said, stepping = scene.said, scene.model.stepping
    largest = part.material.rates[-1][0]
    metric = largest * said.si(0, 0, -1)
    if said.known and not _RATES[0] <= metric <= _RATES[1]:
        yield Finding(
            "rates",
            where,
            f"the curves of {what} go up to a rate of {largest:.4g}, which is {metric:.4g} 1/s",
            f"Give rates in 1/{said.unit('time')}: 100/s is {100.0 / said.si(0, 0, -1):.4g}",
        )
    smoothed, span = part.material.filter, stepping.end - stepping.start
    assert smoothed is not None
    if smoothed > span:
        yield Finding(
            "rates",
            where,
            f"rates of {what} are smoothed over {said(smoothed, 'time')}, and the run "
            f"takes {said(span, 'time')}: they hardly rise",
            f"Give filter in {said.unit('time')}, some steps long",
        )
