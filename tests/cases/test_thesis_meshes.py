"""Chapter 6: what meshes of the master find, and miss."""

from __future__ import annotations

import numpy as np
import pytest

from contiga_validation.thesis import chapter6


@pytest.fixture(scope="module")
def found() -> chapter6.Rivals:
    return chapter6.rivals()


def test_the_exact_master_has_the_penetrations_of_table_6_2(found: chapter6.Rivals) -> None:
    """The travel was chosen for them."""
    depth = found.depth["IGA"]
    np.testing.assert_allclose(depth[5:14], chapter6.THESIS_DEPTH["IGA"], rtol=0, atol=1e-13)
    assert not depth[:5].any()
    assert depth[14] == 0.0


def test_a_coarse_mesh_misses_the_first_contact_and_a_fine_one_does_not(
    found: chapter6.Rivals,
) -> None:
    """Tolerance 0.5 has nobody in contact at steps 5 and 13, tolerance 0.01 has."""
    assert found.counts["tol 0.5"][[5, 13]].tolist() == [0, 0]
    assert (found.counts["tol 0.01"][5:14] > 0).all()
    assert (found.counts["IGA"][5:14] > 0).all()
    assert found.counts["tol 0.5"][6] > 0


def test_penetrations_on_a_mesh_are_off_by_its_distance_from_the_surface(
    found: chapter6.Rivals,
) -> None:
    """Distances to two surfaces differ by no more than the surfaces are apart."""
    uv = np.stack(np.meshgrid(*2 * [np.linspace(0.0, 1.0, 201)], indexing="ij"), -1)
    on = found.surface.evaluate(uv.reshape(-1, 2))
    worst = []
    for name, mesh in found.meshes.items():
        error = found.depth[name] - found.depth["IGA"]
        apart = np.abs(mesh.project(on).gap).max()
        worst.append(np.abs(error).max())
        assert worst[-1] <= 1.05 * apart
    assert worst[0] > 5.0 * worst[1] > 25.0 * worst[2]


def test_every_master_is_timed_at_every_step() -> None:
    """Times are positive; how long they are is told in the report, not judged here."""
    best = chapter6.step_times(repeats=1)
    assert list(best) == ["IGA", "tol 0.5", "tol 0.1", "tol 0.01"]
    for times in best.values():
        assert times.shape == (15,)
        assert np.isfinite(times).all()
        assert (times > 0.0).all()


@pytest.mark.parametrize("experiment", chapter6.EXPERIMENTS, ids=lambda e: e.key)
def test_every_claim_holds(experiment) -> None:
    """And every row of every table has an entry for each column."""
    outcome = experiment.run()
    for claim in outcome.claims:
        assert claim.holds, f"{claim.text} {claim.measured}"
    for table in outcome.tables:
        assert all(len(row) == len(table.columns) for row in table.rows)
