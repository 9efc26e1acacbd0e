"""A row of the history says of a contact what its state says, to the last bit."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg
from contiga.simulation.history import contact_columns


def states() -> list[cg.State]:
    """Of a ball over a sheet: apart, pressed in and drawn aside, and the last one made by hand."""
    ball = cg.Body([cg.shapes.sphere(radius=1.0)])
    sheet = cg.clouds.sample(cg.shapes.plane(width=2.0, length=2.0), 20, 20)
    contact = cg.Contact(
        ball,
        cg.Slave(sheet),
        law=cg.PenaltyLaw(3.0),
        area=cg.NodalArea(0.01),
        friction=cg.Coulomb(0.4),
    )
    found = [contact.start(sheet, cg.motion.pose.translation([0.0, 0.0, 1.01]))]
    for x, z in ((0.0, 0.96), (0.03, 0.95)):
        pose = cg.motion.pose.translation([x, 0.0, z])
        found.append(contact.step(found[-1], sheet, pose))
    return [*found, cg.State(**found[-1].arrays, of=contact)]


@pytest.mark.parametrize("measured", [True, False])
def test_columns_are_those_of_whole_arrays(measured: bool) -> None:
    for state in states():
        row = contact_columns(state, None, 0.5, measured=measured)
        sums = state.force.sum(axis=0), state.friction.sum(axis=0), state.centre_of_pressure
        for name, values in zip(("force", "friction", "centre"), sums, strict=True):
            own = [row[f"{name}_{axis}"] for axis in "xyz"]
            np.testing.assert_array_equal(own, values)
        assert row["n_contact"] == state.n_contact
        assert row["n_unproved"] == state.n_unproved
        assert row["n_new"] == np.sum(state.status == cg.ContactStatus.NEW)
        assert np.isfinite(row["area"]) == measured
    assert state.n_contact > 5
    assert state.friction.any()
