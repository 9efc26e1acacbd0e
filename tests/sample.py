"""Whether all of a test is asked for (``make stress``), or what each commit has time for."""

from __future__ import annotations

import os

FULL = bool(os.environ.get("CONTIGA_FULL"))
