"""Outlines of the regions of contact on disk: of all contacts of a run, step by step."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from contiga.area.method import Outlines
from contiga.io.out.outlines import Loops, OutlinesWriter


class OutlinesFile:
    """Writes the outlines of all contacts of a run, step by step.

    Parameters
    ----------
    path : of the file
    written : steps already in it, which are kept; None starts a new file
    """

    def __init__(self, path: Path, written: int | None) -> None:
        self._writer = (
            OutlinesWriter(path) if written is None else OutlinesWriter.reopen(path, written)
        )

    def append(self, time: float, found: list[Outlines | None]) -> None:
        """Write one step: the outlines of each contact, None of those that have none."""
        points, counts = [np.zeros((0, 3))], [np.zeros(0, np.int64)]
        clusters, contacts = [np.zeros(0, np.int32)], [np.zeros(0, np.int32)]
        for k, lines in enumerate(found):
            if lines is not None:
                points.append(lines.points)
                counts.append(np.diff(lines.first))
                clusters.append(lines.clusters)
                contacts.append(np.full(len(lines.clusters), k, np.int32))
        first = np.concatenate(([0], np.cumsum(np.concatenate(counts)))).astype(np.int64)
        loops = Loops(
            np.concatenate(points), first, np.concatenate(clusters), np.concatenate(contacts)
        )
        self._writer.append(time, loops)

    def close(self) -> None:
        """End writing."""
        self._writer.close()
