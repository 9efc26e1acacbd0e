"""Define how a simulation comes to rest before a run, and the outcome."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

from contiga.arrays.layout import positive
from contiga.errors import InputError


@dataclass(frozen=True, init=False)
class Settle:
    """A request that deforming parts come to rest under gravity, loads and contacts before the run.

    Parameters
    ----------
    tolerance : residual at rest: the sum of the magnitudes of unbalanced nodal forces, over that
        of the loads, or of the reactions if there are no loads
    steps : largest number of steps
    bodies : names of free bodies that come to rest as well; others stay where they start

    Raises
    ------
    InputError
        A tolerance or a number of steps that is not positive.

    Examples
    --------
    >>> import contiga as cg
    >>> cg.Settle(tolerance=1e-4)
    Settle(tolerance=0.0001, steps=20000, bodies=())
    """

    tolerance: float
    steps: int
    bodies: tuple[str, ...]

    def __init__(
        self, *, tolerance: float = 1e-3, steps: int = 20_000, bodies: Iterable[str] = ()
    ) -> None:
        if isinstance(steps, bool) or not isinstance(steps, int) or steps < 1:
            raise InputError("must be a whole number", where="steps", found=steps, allowed=">= 1")
        put = object.__setattr__
        put(self, "tolerance", positive(tolerance, "tolerance"))
        put(self, "steps", steps)
        put(self, "bodies", (bodies,) if isinstance(bodies, str) else tuple(bodies))


class Rest(NamedTuple):
    """The outcome of coming to rest."""

    steps: int
    """Number of steps."""
    residual: float
    """Residual at the end, see `Settle.tolerance`."""
