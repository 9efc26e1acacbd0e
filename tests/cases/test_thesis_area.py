"""What the thesis says of areas, forces and clusters, on the scenes of the reproduction."""

from __future__ import annotations

import numpy as np
import pytest

from contiga.laws.normal import ForceLaw, StressLaw
from contiga_validation.thesis import chapter5_area as area
from contiga_validation.thesis import chapter5_force as force
from contiga_validation.thesis import chapter5_split, chapter7
from contiga_validation.thesis.variants import simulation_of


def test_table_5_1_has_the_counts_and_areas_of_the_thesis() -> None:
    """20, 60, 80, 100 … points; 0.08, 0.40 (seven times), 0.24: by rows, by strip, by method."""
    actual = area.area_table()
    assert actual.counts.tolist() == [20, 60, 80, 100, 100, 100, 100, 60, 40]
    truth = np.array([0.08] + 7 * [0.40] + [0.24])
    np.testing.assert_allclose(actual.strip, truth, rtol=0, atol=2e-7)
    np.testing.assert_allclose(actual.areas["hull, linear map"], truth, rtol=0, atol=1e-12)
    np.testing.assert_allclose(actual.areas["hull, exact map"], truth, rtol=0, atol=1e-12)
    np.testing.assert_allclose(actual.areas["facets, on the master"], truth, rtol=0, atol=2e-7)
    # The skin of the lower half, cut or not, is wider than its shadow.
    assert (actual.areas["facets, on the slave"] >= truth - 1e-12).all()
    np.testing.assert_allclose(actual.areas["constant 0.1"], 0.1 * actual.counts, rtol=1e-12)


def test_the_strip_of_a_cylinder_is_its_chord_and_then_its_width() -> None:
    """Chord 2√(R² − h²) above the plane, 2R from the axis down."""
    heights = np.array([0.2, 0.16, 0.0, -1.0])
    np.testing.assert_allclose(area.strip_area(heights), [0.0, 0.24, 0.4, 0.4], atol=1e-15)


def test_split_pieces_close_in_on_the_area_of_the_surface() -> None:
    """Base below, net above, both of second order in the pieces' size (Eq. 4.8, summed)."""
    (part,) = simulation_of("bumpy_master").bodies.values()
    (surface,) = part.body.patches
    steps, true = chapter5_split.split_data(surface, 4), surface.area()
    assert [step.pieces for step in steps] == [1, 4, 16, 64, 256]
    net = np.array([step.net - true for step in steps])
    base = np.array([true - step.base for step in steps])
    assert (net > 0.0).all()
    assert (base > 0.0).all()
    assert net[-2] / net[-1] > 3.5
    assert base[-2] / base[-1] > 3.5


def test_two_cylinders_are_two_regions_and_then_one() -> None:
    """Fig. 5.23: two while the gap is wider than the cloud's spacing, one from then on."""
    pair = area.two_cylinders()
    assert pair.auto.astype(int).tolist() == [0, 2, 2, 2, 2, 2, 2, 2, 1, 1, 1, 1, 1]
    np.testing.assert_allclose(pair.areas["auto"], pair.true, rtol=0, atol=1e-12)
    two, one = slice(1, 8), slice(8, None)
    np.testing.assert_allclose(pair.areas["k = 2"][two], pair.true[two], rtol=0, atol=1e-12)
    np.testing.assert_allclose(pair.areas["k = 1"][one], pair.true[one], rtol=0, atol=1e-12)
    # One hull over two cylinders covers the gap, two hulls over one region leave a gap out.
    assert (pair.areas["k = 1"][two] > pair.true[two] + 0.3).all()
    assert (pair.areas["k = 2"][one] < pair.true[one] - 0.1).all()


def test_the_force_model_is_linear_and_does_not_see_the_area() -> None:
    """F = 0.5 λ_max; nodal forces within 1e-12 for any area that all points share."""
    forces = force.forces(ForceLaw(force.COEFFICIENT, share="penetration"))
    reference = forces.nodal("analytic")[1]
    for name in forces.runs:
        np.testing.assert_allclose(forces.total(name), 0.5 * forces.depth(), rtol=0, atol=1e-14)
        np.testing.assert_allclose(forces.nodal(name)[1], reference, rtol=0, atol=1e-12)


def test_the_stress_model_sees_the_area() -> None:
    """F = A Σσ/n: the hull's force is the analytic one, the constant area's 15 to 25 times it."""
    forces = force.forces(StressLaw(force.MODULUS, force.THICKNESS))
    np.testing.assert_allclose(forces.total("approximated"), forces.total("analytic"), rtol=1e-9)
    ratio = forces.total("constant 0.1") / forces.total("analytic")
    counts, truth = np.array(area.COUNTS), np.array(area.TRUE)
    np.testing.assert_allclose(ratio, 0.1 * counts / truth, rtol=1e-9)
    # Eq. 3.4 by hand at step 9: 100 points, σ = 0.5 λ/t, the mean depth is that of the axis.
    assert forces.total("analytic")[3] == pytest.approx(0.4 * 0.5 * 0.25 / 0.1, rel=1e-12)


def test_contact_types_take_their_own_side_and_combined_both() -> None:
    """Layers of stiffness 5 and 7.5: 5, 7.5 and, in series, 3 times area and mean depth."""
    rows, refusal = force.contact_types()
    load = 0.4 * 0.32
    expected = [5.0 * load, 7.5 * load, 3.0 * load]
    np.testing.assert_allclose([row.force for row in rows], expected, rtol=1e-12)
    assert "ForceLaw" in refusal


def test_forty_points_are_two_clusters_by_every_method_that_is_told_enough() -> None:
    """Chapter 7: the thesis' 24 clusters lie a step of 0.01 beside 8, P_min 10 finds none first."""
    study = chapter7.cluster_data()
    assert len(study.uv) == 40
    counts = study.counts()
    assert counts == {"k-means, k = 2": 2, "mean shift": 2, "HDBSCAN": 2, "auto": 2}
    one = dict(zip(chapter7.EPS.tolist(), study.dbscan[1], strict=True))
    ten = dict(zip(chapter7.EPS.tolist(), study.dbscan[10], strict=True))
    assert [one[e] for e in (0.03, 0.07, 0.08, 0.1, 0.32)] == [40, 24, 8, 2, 1]
    assert [ten[e] for e in (0.1, 0.14, 0.2, 0.32)] == [0, 0, 2, 1]
    left = study.uv[:, 0] < 0.5
    for label in study.labels.values():
        assert len(np.unique(label[left])) == len(np.unique(label[~left])) == 1


def test_a_seam_splits_clusters_in_the_parameter_plane_only() -> None:
    """One region over the closing line of a cylinder."""
    counts = {name: int(label.max()) + 1 for name, label in chapter7.seam_data().labels.items()}
    assert counts == {"DBSCAN in (u, v)": 2, "HDBSCAN in (u, v)": 2, "auto, in space": 1}
    u = chapter7.seam_data().uv[:, 0]
    assert u.min() < 0.1
    assert u.max() > 0.9


@pytest.mark.parametrize(
    "experiment",
    [*chapter5_split.EXPERIMENTS, *area.EXPERIMENTS, *force.EXPERIMENTS, *chapter7.EXPERIMENTS],
    ids=lambda experiment: experiment.key,
)
def test_every_claim_holds(experiment) -> None:
    """And every row of every table has an entry for each column."""
    outcome = experiment.run()
    assert outcome.claims
    for claim in outcome.claims:
        assert claim.holds, f"{claim.text} {claim.measured}"
    for table in outcome.tables:
        assert table.rows
        assert all(len(row) == len(table.columns) for row in table.rows)
