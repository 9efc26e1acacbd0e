"""The `spring` tables of a case: springs and dampers between bodies, or to the ground."""

from __future__ import annotations

from typing import Any

import numpy as np

from contiga.case.curve_spec import ForceCurve, with_characteristics
from contiga.case.device_spec import (
    LimiterSpec,
    PretensionerSpec,
    ReleaseSpec,
    RetractorSpec,
)
from contiga.case.spec import MadeSpec, Name, NotNegative, Positive
from contiga.dynamics.springs import Spring


class SpringSpec(MadeSpec[Spring]):
    """A `[[spring]]`: `Spring`, with all its options."""

    makes = Spring
    name: Name | None = None
    """How results call it; "<first>-<second>" if omitted."""
    between: list[str]
    at: list[list[float]]
    curve: ForceCurve | None = None
    """Force over elongation, tension positive."""
    unloading: ForceCurve | None = None
    hysteresis_slope: Positive | None = None
    damping: NotNegative = 0.0
    length: NotNegative | None = None
    """At rest; the distance of the points at the start if omitted."""
    filter: str | None = None
    """Of the force that results tell."""

    retractor: RetractorSpec | None = None
    """Devices at its end: see `docs/belt-devices.md`."""
    limiter: LimiterSpec | None = None
    pretensioner: PretensionerSpec | None = None
    release: ReleaseSpec | None = None

    def arguments(self) -> dict[str, Any]:
        """As `Spring` takes them."""
        release = None if self.release is None else self.release.trigger
        own = {"name": self.name or "", "release": release}
        return with_characteristics(super().arguments()) | own

    def describe(self) -> str:
        """Say it in words."""
        given = [
            f"{name} {curve.describe()}"
            for name, curve in (("curve", self.curve), ("unloading", self.unloading))
            if curve is not None
        ]
        given += [f"damping {self.damping:g}"] if self.damping else []
        given += [] if self.length is None else [f"length {self.length:g} at rest"]
        given += [] if self.filter is None else [self.filter]
        if self.retractor is not None:
            given.append(f"retractor that {self.retractor.lock.describe()}")
        if self.limiter is not None:
            ends = np.unique(np.atleast_1d(self.limiter.force)[[0, -1]])
            given.append(f"load limiter {' to '.join(f'{force:g}' for force in ends)}")
        if self.pretensioner is not None:
            given.append(f"pretensioner fired by {self.pretensioner.trigger}")
        given += [] if self.release is None else [f"released by {self.release.trigger}"]
        return f"between {' and '.join(self.between)}: {'; '.join(given)}"
