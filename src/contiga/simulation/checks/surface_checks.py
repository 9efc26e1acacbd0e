"""Find bodies that are open because of a flaw."""

from __future__ import annotations

from collections.abc import Iterator

from contiga.search.borders.openings import openings_of
from contiga.simulation.checks.finding import Finding
from contiga.simulation.checks.scene import Scene

OPEN = "open"
"""Name of the rule: such a model runs, but most likely not as intended."""
# Largest number of flaws reported for a body.
_MAX_FLAWS = 3


def check_surfaces(scene: Scene) -> Iterator[Finding]:
    """Report bodies in contact that are open because of a flaw; intended sheets are none.

    Only exact geometry is examined; up to `_MAX_FLAWS` flaws of a body are named.
    """
    for name in dict.fromkeys(pair.part.master for pair in scene.pairs):
        body = scene.model.bodies[name].body
        if body.faces is None or body.closed:
            continue
        openings = openings_of(body.faces)
        if (
            openings.gaping_edges
            or openings.crowded_edges
            or openings.one_sided
            or openings.turned_faces
            or openings.meetings
            or openings.crossing is not None
        ):
            flaws = body.flaws
            more = f"; and {len(flaws) - _MAX_FLAWS} more" if len(flaws) > _MAX_FLAWS else ""
            yield Finding(
                OPEN,
                f"body {name}",
                "contact takes it for an open surface, which has no inside, because of "
                f"{'; '.join(flaws[:_MAX_FLAWS])}{more}",
                "Mend it in the program that wrote the file, or choose parts or faces that are "
                "sound (parts, solids)",
            )
