"""Find bodies that count as open because of a flaw."""

from __future__ import annotations

from collections.abc import Iterator

from contiga.search.borders.openings import openings_of
from contiga.simulation.checks.finding import Finding
from contiga.simulation.checks.scene import Scene

OPEN = "open"
"""The rule of what is found here: such a model runs, but not as it is meant."""
# Flaws told of one body.
_SOME = 3


def check_surfaces(scene: Scene) -> Iterator[Finding]:
    """Report bodies in contact that a flaw makes open; sheets, which end, are no flaw."""
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
            more = f"; and {len(flaws) - _SOME} more" if len(flaws) > _SOME else ""
            yield Finding(
                OPEN,
                f"body {name}",
                "contact takes it for an open surface, which has no inside, because of "
                f"{'; '.join(flaws[:_SOME])}{more}",
                "Mend it in the program that wrote the file, or choose parts or faces that are "
                "sound (parts, solids)",
            )
