"""Find stresses, thicknesses and weights that laws can hardly have."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from contiga.area.nodal import NodalArea
from contiga.contact.dry_run import spread
from contiga.laws.by_face import FaceLaws
from contiga.laws.friction import Coulomb
from contiga.laws.normal import PenaltyLaw
from contiga.laws.stress import StressLaw
from contiga.records import FloatArray
from contiga.simulation.checks.finding import Finding, Said
from contiga.simulation.checks.layers import layers_of, strength
from contiga.simulation.checks.scene import Pair, Scene

# A layer that gives way by that strain is foam, rubber or honeycomb; what those carry at half
# their thickness, in Pa.
_STRAIN = 0.3
_HALF = 0.5
_SOFT_LAYER = (500.0, 5e7)
# Of the most that a curve gives: what it is to give at its end.
_FALLEN = 0.25
# Strain that tables of what is pressed together stop before, with a margin.
PRESSED = 1.5
# Strain at which tables of layers go on.
_SHORT_TABLE = 0.02
# A layer's thickness over the size of the slave that has it.
_THICK = 10.0
# Of the share of the area that a point of a cloud stands for, by its neighbours' distance.
_ODD_AREA = 20.0
_MAX_POINTS = 2000
# Coefficients and ratios above which percents are meant.
_ROUGHEST = 2.0
_OVERDAMPED = 2.0


def check_laws(scene: Scene) -> Iterator[Finding]:
    """Report laws whose numbers are most likely in another unit or of another quantity."""
    for pair in scene.pairs:
        for layer in layers_of(pair.contact):
            x, y = layer.curve.x, layer.curve.y
            if not layer.curve.is_table:
                continue
            kind = "force" if layer.thickness is None else "stress"
            most = float(y.max())
            if not y[-1] > _FALLEN * most:
                how = (
                    "never pushes"
                    if most <= 0.0
                    else f"falls from {scene.said(most, kind)} at most"
                )
                yield Finding(
                    "curve",
                    pair.where,
                    f"its curve {how}: at its end it gives {scene.said(float(y[-1]), kind)}, and "
                    "contact only pushes",
                    "Give pressures as positive numbers, over penetrations or strains that are, "
                    "too",
                )
            elif layer.thickness is not None and len(x) > 2 and x[-1] < _SHORT_TABLE:
                yield Finding(
                    "curve",
                    pair.where,
                    f"its table ends at a strain of {x[-1]:.3g}, before a layer has begun to give "
                    "way",
                    "Give strains as shares of the thickness: 0.5 is half of it, and 50 %",
                )
            elif layer.thickness is not None and in_percent(x, PRESSED):
                yield Finding(
                    "curve",
                    pair.where,
                    f"its table has strains of {x[-2]:.4g} and {x[-1]:.4g}, and no layer is "
                    "pressed by more than its thickness",
                    "Give strains as shares of the thickness: 0.5 is half of it, and 50 %",
                )
        for layer in layers_of(pair.contact):
            curve, thickness = layer.curve, layer.thickness
            if thickness is None or pair.contact.contact_type == "combined":
                continue
            if scene.said.known and curve.is_table and len(curve.x) > 2:
                end, stress = float(curve.x[-1]), strength(curve, _HALF)
                yield from odd_strength(end, stress, pair.where, "its curve", scene.said)
            size = pair.slave_size if pair.contact.contact_type == "slave" else pair.body.size
            if size > 0.0 and thickness > _THICK * size:
                yield Finding(
                    "thickness",
                    pair.where,
                    f"its layer is {scene.said(thickness)} thick, and all of {pair.part.slave} "
                    f"{scene.said(size)} large",
                    f"Give the thickness in {scene.said.unit('length')}",
                )
        yield from _weights(pair, scene.said)
        friction, ratio = pair.contact.friction, getattr(pair.contact.law, "damping_ratio", 0.0)
        if isinstance(friction, Coulomb) and friction.static > _ROUGHEST:
            yield Finding(
                "friction",
                pair.where,
                f"its coefficient of friction is {friction.static:g}, and rubber on dry asphalt "
                "has about 1",
                "Give a coefficient, not percents",
            )
        if ratio > _OVERDAMPED:
            yield Finding(
                "damping",
                pair.where,
                f"its damping ratio is {ratio:g} times the critical damping",
                "Give a share, not percents: 0.1 is one tenth of the critical damping",
            )


def in_percent(strains: FloatArray, most: float) -> bool:
    """Return whether the strains of a table are most likely percents.

    More of them than the last have to be beyond `most`: the last row may stand far off to say
    how the table goes on.
    """
    return len(strains) > 2 and bool(strains[-2] > most)


def odd_strength(end: float, stress: float, where: str, what: str, said: Said) -> Iterator[Finding]:
    """Report a curve of a layer or foam that is too strong or too weak for any.

    `stress` is that at half the thickness, or at `end`, the strain at which the curve ends.
    """
    pascal = said.si(-1, 1, -2)
    if end >= _STRAIN and not _SOFT_LAYER[0] <= stress * pascal <= _SOFT_LAYER[1] and stress > 0.0:
        yield Finding(
            "stress",
            where,
            f"{what} gives {said(stress, 'stress')} at a strain of {min(_HALF, end):g}, and layers "
            f"that give way so far are hardly that {'stiff' if stress * pascal > 1e6 else 'soft'}: "
            f"with these units stresses are in {said.unit('stress')}",
            "Give the curve in that unit, or say which it is in",
        )


def _weights(pair: Pair, said: Said) -> Iterator[Finding]:
    """Report areas of a cloud's points that do not fit the distances between them."""
    contact, slave = pair.contact, pair.slave
    law, method = contact.law, contact.area
    by_area = isinstance(law, StressLaw | FaceLaws) or (
        isinstance(law, PenaltyLaw) and law.per_area
    )
    if slave.facets is not None or not by_area or contact.contact_type != "slave":
        return
    points = slave.points[slave.active]
    if not isinstance(method, NodalArea) or len(points) < 10:
        return
    if method.value is not None:
        area = float(method.value)
    elif slave.area is not None:
        area = float(np.median(slave.area[slave.active]))
    else:
        return
    from scipy.spatial import cKDTree  # which takes as long to load as numba

    tree = cKDTree(points)
    neighbours, _ = tree.query(spread(points, _MAX_POINTS), k=2)
    apart = float(np.median(neighbours[:, 1]))
    if not (apart > 0.0 and area > 0.0):
        return
    ratio = area / apart**2
    if ratio > _ODD_AREA or ratio < 1.0 / _ODD_AREA:
        yield Finding(
            "weights",
            pair.where,
            f"each point of {pair.part.slave} stands for {said(area, 'area')}, and its neighbours "
            f"are {said(apart)} away: some {said(apart * apart, 'area')} would be its own",
            'Give the points their share of the surface, or take areas by { kind = "cloud" }; a '
            "mesh with facets has them by itself",
        )
