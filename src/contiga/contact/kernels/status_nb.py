"""Define the numbers of `ContactStatus` for kernels."""

from __future__ import annotations

from contiga.records import ContactStatus

FREE = int(ContactStatus.FREE)
OLD = int(ContactStatus.OLD)
RELEASED = int(ContactStatus.RELEASED)
HELD = int(ContactStatus.HELD)
LOST = int(ContactStatus.LOST)
NOT_FINITE = int(ContactStatus.NOT_FINITE)
REACQUIRED = int(ContactStatus.REACQUIRED)
