"""Fingerprints: a checkpoint goes on from the same computation alone."""

from dataclasses import replace

import numpy as np
import pytest

import isoembed
import zoo
from counting import STAGE, Counting
from isoembed import Checkpoint, GluedMetric, InvalidParameter, PolyhedralMetric
from isoembed.aim.adaptive import Aim
from isoembed.alexandrov.method import Alexandrov
from isoembed.progress.fingerprint import Fingerprint

VERTICES, FACES = zoo.icosphere(1)


@pytest.fixture
def metric():
    return PolyhedralMetric.from_mesh(VERTICES, FACES)


def fingerprint(metric, method, tolerance):
    return Fingerprint.of(metric.tables, method, tolerance)


def test_digests_are_those_of_checkpoints_in_files():
    faces, lengths = [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]], [3.0, 3.5, 4.0, 4.5, 5.0, 5.5]
    tetrahedron = PolyhedralMetric(faces, lengths)
    assert fingerprint(tetrahedron, Counting(), 1e-10).metric == (
        "525255691544e471380fff3b629413cc7149a2f3dc8a1fc0ce6dd6b193ceaf46"
    )
    assert fingerprint(GluedMetric.of(tetrahedron), Counting(), 1e-10).metric == (
        "95b3879a498fdf5f2e872a591ac89191ced2325ee3c33bc7716fda92fff25ef9"
    )


def test_of_a_metric_its_unit_does_not_matter_but_all_else_does(metric):
    there = fingerprint(metric, Counting(), 1e-10)
    assert fingerprint(metric.with_lengths(2.0**40 * metric.lengths), Counting(), 1e-10) == there
    assert fingerprint(PolyhedralMetric(metric.faces, metric.lengths), Counting(), 1e-10) == there
    longer = metric.lengths.copy()
    longer[7] = np.nextafter(longer[7], 2)
    turned = np.roll(FACES, 1, axis=1)
    others = (
        metric.with_lengths(longer),
        PolyhedralMetric(turned, metric.lengths),
        PolyhedralMetric(metric.faces[::-1], metric.lengths),
        GluedMetric.of(metric),
    )
    digests = {fingerprint(other, Counting(), 1e-10).metric for other in (metric, *others)}
    assert len(digests) == 5


def test_methods_are_described_by_their_parameters():
    metric = PolyhedralMetric.from_mesh(*zoo.tetrahedron())
    there = fingerprint(metric, Aim(), 1e-10)
    assert there.method == "Aim(best_fit=False, effort=1.0, which=None)"
    assert there.version == isoembed.__version__
    assert fingerprint(metric, Alexandrov(repair=1e-3), 1e-10).method == "Alexandrov(repair=0.001)"


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"metric": "0"}, "the checkpoint belongs to another metric: its triangles or lengths"),
        ({"method": "Paper()"}, r"written by another method: Paper\(\), not Counting\(steps=5, "),
        ({"tolerance": 1e-8}, "written with another tolerance: 1e-08, not 1e-10"),
        ({"version": "0.0"}, f"written by another version: isoembed 0.0, not {isoembed.__version__}"),
    ],
    ids=lambda value: next(iter(value)) if isinstance(value, dict) else "",
)
def test_that_of_another_computation_is_refused(metric, change, sentence):
    here = fingerprint(metric, Counting(), 1e-10)
    foreign = Checkpoint("", {}, fingerprint=replace(here, **change))
    here.check(here)
    with pytest.raises(InvalidParameter, match=sentence):
        isoembed.embed(metric, method=Counting(), resume=foreign)


def test_what_is_no_checkpoint_is_refused(metric):
    with pytest.raises(
        InvalidParameter, match=r"resume is a str, not a Checkpoint: isoembed\.io\.read_checkp"
    ):
        isoembed.embed(metric, method=Counting(), resume="run.npz")
    with pytest.raises(InvalidParameter, match="does not say which computation it belongs to"):
        isoembed.embed(metric, method=Counting(), resume=Checkpoint(STAGE, {}))


def test_a_method_of_ones_own_is_known_by_what_it_says_of_itself(metric):
    class Own:
        name = "own"

        def __repr__(self):
            return "Own(3)"

    assert fingerprint(metric, Own(), 1e-10).method == "Own(3)"
