"""Number the events of points as kernels write them: `ContactStatus`."""

from __future__ import annotations

from contiga.records import ContactStatus

FREE = int(ContactStatus.FREE)
OLD = int(ContactStatus.OLD)
RELEASED = int(ContactStatus.RELEASED)
HELD = int(ContactStatus.HELD)
LOST = int(ContactStatus.LOST)
NOT_FINITE = int(ContactStatus.NOT_FINITE)
REACQUIRED = int(ContactStatus.REACQUIRED)
