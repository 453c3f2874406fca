"""Several starts of sheets with K < 0: buckling modes, which of them bend least, and others beside it."""

from dataclasses import replace

import numpy as np
import pytest

import discs
import isoembed
from isoembed import PolyhedralMetric, embed
from isoembed.progress.stages import Log
from isoembed.sheets.bending import BendingEnergy
from isoembed.sheets.buckling import buckled
from isoembed.sheets.length_constraints import LengthConstraints
from isoembed.sheets.multidimensional_scaling import scaled_distances
from isoembed.smooth import AngleMetric, triangulate_metric


def hyperbolic(mesh, radius):
    points, faces = mesh
    edges = PolyhedralMetric.from_mesh(discs.round_cap(points, 1.0), faces).edges
    return PolyhedralMetric(faces, discs.hyperbolic_lengths(points, radius, edges), edges).normalized


def modes_of(metric):
    with Log().stage("buckling") as recorder:
        return buckled(BendingEnergy(metric), LengthConstraints(metric), recorder)


def waves(points, heights):
    """The strongest harmonic of heights along the rim of a disc."""
    rim = np.flatnonzero(np.linalg.norm(points, axis=1) > 1 - 1e-9)
    order = rim[np.argsort(np.arctan2(points[rim, 1], points[rim, 0]))]
    return 1 + int(np.abs(np.fft.rfft(heights[order]))[1:8].argmax())


@pytest.mark.parametrize("mesh", [discs.hexagonal(6), discs.irregular(150)], ids=["hexagonal", "irregular"])
def test_a_round_disc_buckles_into_two_three_and_four_waves(mesh):
    metric = hyperbolic(mesh, 1.0)
    starts, _ = modes_of(metric)
    assert [waves(mesh[0], x[:, 2]) for x in starts] == [2, 3, 4]


def test_a_weakly_curved_disc_is_thin_before_it_buckles():
    """The strain of a flat disc is of the order of the square of its radius."""
    thick, thin = (modes_of(hyperbolic(discs.hexagonal(5), radius))[1][0] for radius in (0.5, 0.05))
    assert thin < 0.1 * thick


def test_a_flat_disc_and_a_tube_have_no_modes():
    points, faces = discs.irregular(100)
    flat = PolyhedralMetric.from_mesh(np.column_stack([points, 0 * points[:, 0]]), faces).normalized
    tube = PolyhedralMetric.from_mesh(*discs.band(24, 9, lambda t: (1.0, 3 * t))).normalized
    assert modes_of(flat)[0] == modes_of(tube)[0] == []


def test_several_starts_lead_to_less_bending_than_scaling_alone():
    metric = AngleMetric(lambda r, phi: (1.0, 0.0, (r + 0.3 * r**3) ** 2))
    band = triangulate_metric(metric, 80, zone=(0.3, 1.0)).metric
    found = embed(band, boundary="free")
    alone = embed(band, boundary="free", start=scaled_distances(band))
    assert found.second_form_energy < 0.98 * alone.second_form_energy
    assert "found from 4 starts: other surfaces may bend less" in found.message
    assert "found from one start: other surfaces may bend less" in alone.message
    assert found.uniqueness.kind == "searched"


def test_another_surface_is_kept_beside_the_one_that_bends_less():
    found = embed(hyperbolic(discs.irregular(60), 1.5).scaled(3.0), boundary="free")
    [other] = found.others
    energies = other.second_form_energy, found.second_form_energy
    assert 1.01 < energies[0] / energies[1] < 1.2
    assert "whose int k1^2 + k2^2 dA is {:.6g} instead of {:.6g}".format(*energies) in found.message
    assert other.imbalance < 1e-6 and "stalled" not in found.message
    assert np.abs(lengths_of(other) - found.metric.lengths).max() < 1e-12
    [entry] = isoembed.report(found)["other_realizations"]
    assert entry["distance"] == pytest.approx(found.distance(other))
    assert (
        entry["sheet"]["second_form_energy"] == energies[0] and entry["sheet"]["imbalance"] == other.imbalance
    )
    stalled = replace(found, others=(replace(other, imbalance=2e-4),))
    assert "but its search stalled (imbalance 2e-04)" in stalled._sentence()


def lengths_of(surface):
    a, b = surface.metric.edges.T
    return np.linalg.norm(surface.vertices[a] - surface.vertices[b], axis=1)
