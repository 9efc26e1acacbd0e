"""The `spring` tables of a case, and the keys they share with the webbing of belt ends."""

from __future__ import annotations

from typing import Any, Generic

import numpy as np

from contiga.case.curve_spec import ForceCurve, with_characteristics
from contiga.case.device_spec import (
    LimiterSpec,
    PretensionerSpec,
    ReleaseSpec,
    RetractorSpec,
)
from contiga.case.spec import InstanceSpec, InstanceT, Name, NotNegative, Positive
from contiga.dynamics.springs import Spring


class WebbingSpec(InstanceSpec[InstanceT], Generic[InstanceT]):
    """A table of a force over elongation, and the devices at an end."""

    curve: ForceCurve | None = None
    """Force over elongation, tension positive."""
    unloading: ForceCurve | None = None
    hysteresis_slope: Positive | None = None
    filter: str | None = None
    """Filter of the force in the results."""

    retractor: RetractorSpec | None = None
    """Devices at its end: see `docs/belt-devices.md`."""
    limiter: LimiterSpec | None = None
    pretensioner: PretensionerSpec | None = None
    release: ReleaseSpec | None = None

    def arguments(self) -> dict[str, Any]:
        """Return the arguments with curves as characteristics, and the release by its trigger."""
        release = None if self.release is None else self.release.trigger
        return with_characteristics(super().arguments()) | {"release": release}

    def facts(self) -> list[str]:
        """Return a text for each given curve, filter and device."""
        facts = [
            f"{name} {curve.describe()}"
            for name, curve in (("curve", self.curve), ("unloading", self.unloading))
            if curve is not None
        ]
        facts += [] if self.filter is None else [self.filter]
        if self.retractor is not None:
            facts.append(f"retractor that {self.retractor.lock.describe()}")
        if self.limiter is not None:
            ends = np.unique(np.atleast_1d(self.limiter.force)[[0, -1]])
            facts.append(f"load limiter {' to '.join(f'{force:g}' for force in ends)}")
        if self.pretensioner is not None:
            facts.append(f"pretensioner fired by {self.pretensioner.trigger}")
        facts += [] if self.release is None else [f"released by {self.release.trigger}"]
        return facts


class SpringSpec(WebbingSpec[Spring]):
    """A `[[spring]]`: `Spring`, with all its options."""

    makes = Spring
    name: Name | None = None
    """Name in results; "<first>-<second>" if omitted."""
    between: list[str]
    at: list[list[float]]
    damping: NotNegative = 0.0
    length: NotNegative | None = None
    """Length at rest; the distance of the points at the start if omitted."""

    def arguments(self) -> dict[str, Any]:
        """Return the arguments that `Spring` takes."""
        return super().arguments() | {"name": self.name or ""}

    def describe(self) -> str:
        """Describe the table in words."""
        facts = self.facts()
        facts += [f"damping {self.damping:g}"] if self.damping else []
        facts += [] if self.length is None else [f"length {self.length:g} at rest"]
        return f"between {' and '.join(self.between)}: {'; '.join(facts)}"
