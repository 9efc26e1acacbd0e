"""Find stresses, thicknesses and weights of laws that are unlikely."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from contiga.area.nodal import NodalArea
from contiga.contact.dry_run import spread
from contiga.laws.by_face import FaceLaws
from contiga.laws.normal import PenaltyLaw
from contiga.laws.stress import StressLaw
from contiga.records import FloatArray
from contiga.simulation.checks.finding import Finding, Quantities
from contiga.simulation.checks.layers import layers_of, strength
from contiga.simulation.checks.scene import Pair, Scene

# Strain from which a layer is foam, rubber or honeycomb, and the range of its stress at half the
# thickness, Pa.
_SOFT_STRAIN = 0.3
_HALF = 0.5
_STRESS_RANGE = (500.0, 5e7)
# Smallest value at the end of a curve, as a share of its maximum.
_MIN_END_SHARE = 0.25
# Largest strain of tables of compression, with a margin.
MAX_STRAIN = 1.5
# Smallest last strain of a table.
_MIN_TABLE_END = 0.02
# Largest thickness of a layer over the size of its slave.
_MAX_THICKNESS = 10.0
# Largest ratio between the area of a point of a cloud and the square of the spacing.
_MAX_AREA_RATIO = 20.0
_MAX_POINTS = 2000
# Coefficients and ratios above which a percentage is likely.
_MAX_FRICTION = 2.0
_MAX_DAMPING_RATIO = 2.0


def check_laws(scene: Scene) -> Iterator[Finding]:
    """Report laws whose numbers are most likely in another unit or of another quantity.

    These are curves that fall at their end, strains in percent, stresses and thicknesses that no
    layer has, areas of points, and coefficients of friction and damping.
    """
    for pair in scene.pairs:
        for layer in layers_of(pair.contact):
            x, y = layer.curve.x, layer.curve.y
            if not layer.curve.is_table:
                continue
            kind = "force" if layer.thickness is None else "stress"
            largest = float(y.max())
            if not y[-1] > _MIN_END_SHARE * largest:
                fault = (
                    "never pushes"
                    if largest <= 0.0
                    else f"falls from {scene.fmt(largest, kind)} at most"
                )
                yield Finding(
                    "curve",
                    pair.where,
                    f"its curve {fault}: at its end it gives {scene.fmt(float(y[-1]), kind)}, and "
                    "contact only pushes",
                    "Give pressures as positive numbers, over penetrations or strains that are, "
                    "too",
                )
            elif layer.thickness is not None and len(x) > 2 and x[-1] < _MIN_TABLE_END:
                yield Finding(
                    "curve",
                    pair.where,
                    f"its table ends at a strain of {x[-1]:.3g}, before a layer has begun to give "
                    "way",
                    "Give strains as shares of the thickness: 0.5 is half of it, and 50 %",
                )
            elif layer.thickness is not None and in_percent(x, MAX_STRAIN):
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
            if scene.fmt.known and curve.is_table and len(curve.x) > 2:
                end, stress = float(curve.x[-1]), strength(curve, _HALF)
                yield from odd_strength(end, stress, pair.where, "its curve", scene.fmt)
            size = pair.slave_size if pair.contact.contact_type == "slave" else pair.body.size
            if size > 0.0 and thickness > _MAX_THICKNESS * size:
                yield Finding(
                    "thickness",
                    pair.where,
                    f"its layer is {scene.fmt(thickness)} thick, and all of {pair.part.slave} "
                    f"{scene.fmt(size)} large",
                    f"Give the thickness in {scene.fmt.unit('length')}",
                )
        yield from _check_weights(pair, scene.fmt)
        coefficient = getattr(pair.contact.friction, "largest_coefficient", 0.0)
        ratio = getattr(pair.contact.law, "damping_ratio", 0.0)
        if coefficient > _MAX_FRICTION:
            yield Finding(
                "friction",
                pair.where,
                f"its coefficient of friction is {coefficient:g}, and rubber on dry asphalt "
                "has about 1",
                "Give a coefficient, not percents",
            )
        if ratio > _MAX_DAMPING_RATIO:
            yield Finding(
                "damping",
                pair.where,
                f"its damping ratio is {ratio:g} times the critical damping",
                "Give a share, not percents: 0.1 is one tenth of the critical damping",
            )


def in_percent(strains: FloatArray, max_strain: float) -> bool:
    """Return whether the strains of a table are most likely percentages.

    More rows than the last must be beyond `max_strain`: the last row may be far off to define the
    continuation of the table.
    """
    return len(strains) > 2 and bool(strains[-2] > max_strain)


def odd_strength(
    end: float, stress: float, where: str, subject: str, fmt: Quantities
) -> Iterator[Finding]:
    """Report a curve of a layer or foam that is too strong or too weak.

    `stress` is its value at half the thickness, or at `end`, the last strain of the curve. Curves
    that end before `_SOFT_STRAIN` are not judged.
    """
    pascal = fmt.si(-1, 1, -2)
    if (
        end >= _SOFT_STRAIN
        and not _STRESS_RANGE[0] <= stress * pascal <= _STRESS_RANGE[1]
        and stress > 0.0
    ):
        yield Finding(
            "stress",
            where,
            f"{subject} gives {fmt(stress, 'stress')} at a strain of {min(_HALF, end):g}, and "
            f"layers that give way so far are hardly that "
            f"{'stiff' if stress * pascal > 1e6 else 'soft'}: "
            f"with these units stresses are in {fmt.unit('stress')}",
            "Give the curve in that unit, or say which it is in",
        )


def _check_weights(pair: Pair, fmt: Quantities) -> Iterator[Finding]:
    """Report areas of points of a cloud that do not fit their spacing.

    The median area may differ from the square of the median spacing, of up to `_MAX_POINTS` points,
    by a factor of `_MAX_AREA_RATIO`. Clouds of fewer than ten points, and laws that need no area,
    are left out.
    """
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
    from scipy.spatial import cKDTree  # its import takes as long as that of numba

    tree = cKDTree(points)
    neighbours, _ = tree.query(spread(points, _MAX_POINTS), k=2)
    spacing = float(np.median(neighbours[:, 1]))
    if not (spacing > 0.0 and area > 0.0):
        return
    ratio = area / spacing**2
    if ratio > _MAX_AREA_RATIO or ratio < 1.0 / _MAX_AREA_RATIO:
        yield Finding(
            "weights",
            pair.where,
            f"each point of {pair.part.slave} stands for {fmt(area, 'area')}, and its neighbours "
            f"are {fmt(spacing)} away: some {fmt(spacing * spacing, 'area')} would be its own",
            'Give the points their share of the surface, or take areas by { kind = "cloud" }; a '
            "mesh with facets has them by itself",
        )
