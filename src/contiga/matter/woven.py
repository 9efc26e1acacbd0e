"""Fabric and belts, in the units of the case: see `contiga.materials`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from contiga.arrays.layout import real
from contiga.curves.characteristic import Characteristic
from contiga.curves.curve_records import joined
from contiga.curves.hysteresis import Hysteresis, hysteresis_of
from contiga.errors import InputError
from contiga.matter.coefficients import Coefficients, Reach
from contiga.matter.curves import as_table, max_slope
from contiga.matter.kernels import bar_nb, membrane_fabric_nb
from contiga.matter.kernels.elements_stress_nb import BAR, FABRIC
from contiga.records import FloatArray


@dataclass(frozen=True, kw_only=True, eq=False)
class Fabric:
    """Woven fabric: warp, weft and shear have independent curves.

    Parameters
    ----------
    warp, weft : stress over Green's strain in tension, (n, 2) rows from [0, 0] or a modulus;
        `weft` is as `warp` if omitted
    shear : shear stress over the angle 2 E₁₂, the same in both senses
    direction : (3,) of the warp at rest, projected to each element, or (n, 3) one for each
    compression : stiffness in compression over the first slopes, 0 to 1
    warp_unloading, weft_unloading : curves below those of loading; as loading if omitted
    hysteresis_slope : slope of the lines between loading and unloading, not below any of theirs

    Raises
    ------
    InputError
        A curve that falls or does not begin at zero, an unloading above its loading, a slope below
        theirs or missing, a direction without length.

    Examples
    --------
    Nylon of airbags, in kN/mm²

    >>> import contiga as cg
    >>> cloth = cg.materials.Fabric(warp=0.38, shear=0.01, direction=[1, 0, 0])
    >>> cloth.weft.tolist()
    [[0.0, 0.0], [1.0, 0.38]]
    """

    kinds: ClassVar[tuple[str, ...]] = ("tri3",)

    warp: FloatArray
    shear: FloatArray
    direction: FloatArray
    weft: FloatArray | None = None
    compression: float = 0.0
    warp_unloading: FloatArray | None = None
    weft_unloading: FloatArray | None = None
    hysteresis_slope: float | None = None

    def __post_init__(self) -> None:
        put = object.__setattr__
        put(self, "warp", as_table(self.warp, "warp"))
        put(self, "weft", self.warp if self.weft is None else as_table(self.weft, "weft"))
        put(self, "shear", as_table(self.shear, "shear"))
        for name in ("warp", "weft"):
            curve = getattr(self, f"{name}_unloading")
            if curve is not None:
                put(self, f"{name}_unloading", as_table(curve, f"{name}_unloading"))
        if not 0.0 <= self.compression <= 1.0:
            raise InputError(
                "is a share", where="compression", found=self.compression, allowed="0 to 1"
            )
        direction = np.asarray(real(self.direction, "direction"), dtype=np.float64)
        if direction.shape[-1:] != (3,) or direction.ndim > 2:
            raise InputError(
                "is no direction",
                where="direction",
                found=direction.shape,
                allowed="(3,) or (n, 3)",
            )
        if not (np.isfinite(direction).all() and (direction != 0.0).any(axis=-1).all()):
            raise InputError("has no length or is not finite", where="direction")
        put(self, "direction", direction)
        for name in ("warp", "weft"):
            self._thread(name)

    def _thread(self, name: str) -> Hysteresis:
        """Return the hysteresis of "warp" or "weft"; raises as `_hysteresis` does."""
        loading: FloatArray = getattr(self, name)
        unloading: FloatArray | None = getattr(self, f"{name}_unloading")
        return _hysteresis(loading, unloading, self.hysteresis_slope, name)

    def coefficients(self, kind: str, across: float) -> Coefficients:
        """See `Material`."""
        assert self.weft is not None
        first = [float(table[1, 1] / table[1, 0]) for table in (self.warp, self.weft)]
        threads = [self._thread(name) for name in ("warp", "weft")]
        steepest = [thread.slope for thread in threads]
        compressive = [self.compression * slope for slope in first]
        curves = joined(*(thread.curves for thread in threads), Characteristic(self.shear).pieces)
        tangent = across * np.array([*steepest, 0.0, max_slope(self.shear)])
        bending = across * np.array([*first, 0.0, self.shear[1, 1] / self.shear[1, 0]])
        column = membrane_fabric_nb.REACHED
        return Coefficients(
            FABRIC,
            np.array([across, *compressive, *steepest]),
            max(first),
            max(steepest),
            tangent,
            bending,
            memory=membrane_fabric_nb.MEMORY,
            reaches=(
                *Reach.of("strain of the warp", self.warp, column),
                *Reach.of("strain of the weft", self.weft, column + 1),
                *Reach.of("angle of the shear", self.shear, column + 2),
            ),
            curves=curves,
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class Belt:
    """Webbing as bars, with a force over the strain ℓ/ℓ₀ − 1 in tension and none in compression.

    Parameters
    ----------
    loading : force over strain, (n, 2) rows from [0, 0], or a stiffness (force at the strain 1)
    unloading : the same, below `loading`; as loading if omitted
    hysteresis_slope : slope of the lines between both, not below any of theirs

    Raises
    ------
    InputError
        A curve that falls or does not begin at zero, an unloading above the loading, a slope below
        theirs or missing.

    Examples
    --------
    >>> import contiga as cg
    >>> webbing = cg.materials.Belt(
    ...     loading=[[0, 0], [0.03, 2.5], [0.12, 11]],
    ...     unloading=[[0, 0], [0.06, 0.5], [0.12, 5]],
    ...     hysteresis_slope=300,
    ... )
    >>> webbing.loading.shape
    (3, 2)
    """

    kinds: ClassVar[tuple[str, ...]] = ("bar2",)

    loading: FloatArray
    unloading: FloatArray | None = None
    hysteresis_slope: float | None = None

    def __post_init__(self) -> None:
        put = object.__setattr__
        put(self, "loading", as_table(self.loading, "loading"))
        if self.unloading is not None:
            put(self, "unloading", as_table(self.unloading, "unloading"))
        self._hysteresis()

    def _hysteresis(self) -> Hysteresis:
        return _hysteresis(self.loading, self.unloading, self.hysteresis_slope, "loading")

    def coefficients(self, kind: str, across: float) -> Coefficients:
        """See `Material`."""
        hysteresis = self._hysteresis()
        modulus = hysteresis.slope / across
        return Coefficients(
            BAR,
            np.array([0.0, 0.0, hysteresis.slope]),
            modulus,
            modulus,
            memory=bar_nb.MEMORY,
            reaches=Reach.of("strain", self.loading, bar_nb.REACHED),
            curves=hysteresis.curves,
        )


def _hysteresis(
    loading: FloatArray, unloading: FloatArray | None, slope: float | None, name: str
) -> Hysteresis:
    """Return the hysteresis between two tables; without `unloading` it loses no energy.

    Raises
    ------
    InputError
        Tables that cross below twice their last strain, a slope below theirs or missing.
    """
    curve = Characteristic(loading, name=name)
    if unloading is None:
        return Hysteresis(curve, curve, max_slope(loading))
    lower = Characteristic(unloading, name=f"{name}_unloading")
    end = 2.0 * float(max(loading[-1, 0], unloading[-1, 0]))
    hysteresis = hysteresis_of(curve, lower, slope, to=end)
    assert hysteresis is not None
    return hysteresis
