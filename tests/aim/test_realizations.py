"""All realizations near a surface: counted where they are known, and exact pairs found from one of them."""

import itertools

import numpy as np
import pytest

import curved_bodies
import isoembed
import smooth_bodies
import zoo
from isoembed.aim.length_expansion import LengthExpansion
from isoembed.aim.nearby_motions import MOST_MOTIONS, SMOOTHER_MOTIONS, Motions, nearby_motions
from isoembed.aim.nearby_realizations import softest_motions
from isoembed.aim.realization_search import RealizationSearch
from isoembed.aim.start_points import start_points
from isoembed.embedding.embedding import Embedding
from isoembed.errors import InvalidParameter
from isoembed.gallery import HarmonicSurface, triangulate
from isoembed.metric.polyhedral import PolyhedralMetric
from isoembed.progress.stages import Log
from isoembed.space import Space
from isoembed.surface.alignment import aligned, distance
from isoembed.surface.rigidity import LengthSystem, edge_rows
from isoembed.surface.smoothness import QuinticResiduals

HEIGHT = 0.02


def embedding(vertices, faces, lengths_of=None):
    metric = PolyhedralMetric.from_mesh(vertices if lengths_of is None else lengths_of, faces)
    return Embedding(metric, vertices, method="given", tolerance=1e-10)


def capped(vertices, faces, which, heights):
    """A body with flat pyramids on some of its triangles, their apexes out or in."""
    corners = vertices[faces[which]]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    apexes = corners.mean(axis=1) + np.asarray(heights)[:, None] * normals
    n = len(vertices)
    sides = [
        [a, b, n + i]
        for i, f in enumerate(which)
        for a, b in zip(faces[f], np.roll(faces[f], -1), strict=True)
    ]
    return np.vstack([vertices, apexes]), np.vstack([np.delete(faces, which, axis=0), sides])


def contains(found, surface):
    return any(surface.distance(each) < 1e-9 for each in found.surfaces)


@pytest.mark.parametrize(
    ("which", "motions", "surfaces"),
    [([0, 7], 2, 4), ([0, 3, 7, 12], 4, 1), pytest.param([0, 3, 7, 12], 2, 8, marks=pytest.mark.slow)],
)
def test_every_apex_is_out_or_in(which, motions, surfaces):
    """The icosahedron is rigid, and nothing else moves: 2^n realizations, and all of them are found.

    With as many motions as apexes they are the roots of one system of equations; with two motions the search
    goes on from some that were found.
    """
    x, faces = capped(*zoo.icosahedron(), which, np.full(len(which), HEIGHT))
    about = embedding(x, faces)
    found = isoembed.realizations(about, distance=0.1, motions=motions, surfaces=surfaces)
    assert len(found.surfaces) == 2 ** len(which)
    assert found.searched.sum() == surfaces
    for signs in itertools.product((-1, 1), repeat=len(which)):
        other = capped(*zoo.icosahedron(), which, HEIGHT * np.array(signs))[0]
        assert contains(found, embedding(other, faces, lengths_of=x))
    assert found.apart[~np.eye(len(found.apart), dtype=np.bool_)].min() > 0.9 * HEIGHT


def test_mirror_images_are_one():
    """In a bipyramid of low apexes, both on one side, a large motion may turn the volume over."""
    angles = 2 * np.pi * np.arange(5) / 5
    x = np.vstack([np.column_stack([np.cos(angles), np.sin(angles), 0 * angles]), [[0, 0, 1], [0, 0, -0.6]]])
    faces = [face for i in range(5) for face in ([i, (i + 1) % 5, 5], [(i + 1) % 5, i, 6])]
    found = isoembed.realizations(embedding(x, faces), distance=2.0, motions=3, surfaces=2)
    assert len(found.surfaces) > 1
    assert found.apart[~np.eye(len(found.apart), dtype=np.bool_)].min() > 1e-3


def test_what_smooths_in_several_places_is_done_at_once():
    """Two of five apexes are moved together at most, yet one lead is to the body with all of them out."""
    x, faces = zoo.icosphere(1)
    which = [12, 27, 54, 42, 20]  # apart from each other
    (about, out) = (capped(x, faces, which, np.full(5, height)) for height in (-HEIGHT, HEIGHT))
    metric = PolyhedralMetric.from_mesh(*about)
    start, end = (vertices / metric.unit for vertices, _ in (about, out))
    system = LengthSystem(metric.triangulation)
    expansion = LengthExpansion(system, start, metric.normalized.lengths)
    found = start_points(expansion, 2, 0.1).points
    assert all(one.roughness <= other.roughness for one, other in itertools.pairwise(found))
    assert distance(found[0].vertices, end) < 1e-3 * distance(start, end)
    assert all(distance(lead.vertices, end) > 0.1 * distance(start, end) for lead in found[1:])


def test_nothing_beyond_the_region_is_told():
    x, faces = capped(*zoo.icosahedron(), [0, 7], [HEIGHT / 2, HEIGHT])
    near, far = (isoembed.realizations(embedding(x, faces), distance=d) for d in (0.7 * HEIGHT, HEIGHT / 2.5))
    assert len(near.surfaces) == 2
    assert len(far.surfaces) == 1


@pytest.mark.parametrize("curvature", [-1.0, 1.0])
def test_an_apex_in_curved_space_is_out_or_in(curvature):
    """Its mirror image in the plane of three vertices has the same distances from them."""
    space = Space(curvature)
    x, faces = curved_bodies.hull(space, 8, 0.8, 0)
    straight, flat = capped(x / space.heights(x)[:, None], faces, [0], [1e-2])
    x = straight / np.sqrt(1 + space.curvature * np.einsum("ij,ij->i", straight, straight))[:, None]
    metric = curved_bodies.metric_of(space, x, flat)
    about = Embedding(metric, x, method="given", tolerance=1e-10)
    found = isoembed.realizations(about, distance=0.1)
    assert len(found.surfaces) == 2
    assert contains(found, about)
    (other,) = (each for each in found.surfaces if each.distance(about) > 1e-9)
    assert other.residual < 1e-12
    apart = space.distances(aligned(other.vertices, about.vertices, space), about.vertices)
    assert apart.argmax() == len(x) - 1


@pytest.fixture(scope="module")
def saddle():
    """A surface with others near, as they are found."""
    vertices, faces = triangulate(HarmonicSurface(degree=2, order=2, amplitude=0.35), 150, irregular=1)
    return isoembed.realizations(embedding(vertices, faces), surfaces=2)


def test_those_that_are_found_are_realizations_and_apart(saddle):
    assert len(saddle.surfaces) >= 3
    assert contains(saddle, saddle.about)
    assert saddle.searched.sum() == 2
    assert (np.diff([each.surface.fine_roughness for each in saddle.surfaces]) >= 0).all()
    isolation = []
    for surface, away in zip(saddle.surfaces, saddle.distances, strict=True):
        assert surface.residual < 1e-11
        assert away <= saddle.distance
        assert isoembed.certify(surface).certified
        isolation.append(isoembed.certify(surface).isolation)
    apart = saddle.apart + np.diag(np.full(len(isolation), np.inf))
    assert (apart >= np.array(isolation)[:, None]).all()


@pytest.mark.parametrize("factor", [0.4, 1.5])
def test_exact_pairs_along_a_flex(saddle, factor):
    """x + d and x - d have the same lengths just if d is an infinitesimal flex of x.

    The mean x of two realizations has half of their difference for a flex d.  So have all x + s d and x - s d
    the same lengths, which are others than those the pair came from.
    """
    first, second = (each.vertices for each in saddle.surfaces[:2])
    x, d = (first + second) / 2, (first - second) / 2
    t = saddle.about.triangulation
    lengths = PolyhedralMetric.from_mesh(x, t.faces).lengths
    rates = np.einsum("ij,ij->i", edge_rows(t, x, lengths), d[t.edges[:, 0]] - d[t.edges[:, 1]])
    assert np.abs(rates).max() < 1e-13
    one, other = embedding(x + factor * d, t.faces), x - factor * d
    assert one.metric.lengths == pytest.approx(PolyhedralMetric.from_mesh(other, t.faces).lengths, abs=1e-14)
    found = isoembed.realizations(one, surfaces=1)
    assert contains(found, embedding(other, t.faces, lengths_of=one.vertices))


def test_two_that_are_close_are_found_from_farther(saddle):
    """Between them J is nearly singular, and Newton's method slow."""
    first, second = (each.vertices for each in saddle.surfaces[:2])
    faces = saddle.about.triangulation.faces
    second = aligned(second, first)
    x, d = (first + second) / 2, (first - second) / 2
    one, other = x + 0.02 * d, x - 0.02 * d
    metric = PolyhedralMetric.from_mesh(one, faces)
    with Log().stage("realizations") as recorder:
        system, start = LengthSystem(metric.triangulation), (x + 2 * d) / metric.unit
        search = RealizationSearch(metric.normalized, system, start, recorder, 5, 0.12)
        search.polish(search.vertices)
    assert len(search.found) == 2
    for each in (one, other):
        assert min(distance(found, each / metric.unit) for found in search.found) < 1e-9


def test_from_an_attempt_that_misses_the_lengths(saddle):
    first, second = saddle.surfaces[:2]
    between = 0.6 * first.vertices + 0.4 * aligned(second.vertices, first.vertices)
    attempt = Embedding(first.metric, between, method="given", tolerance=1e-10)
    assert attempt.residual > 1e-7
    found = isoembed.realizations(attempt, surfaces=1)
    assert contains(found, first)
    assert contains(found, second)
    assert found.distances.min() > 1e-4


def test_from_an_attempt_that_newtons_method_does_not_lead_from():
    """Relaxed, as smooth as can be, an attempt with noise comes to the surface."""
    metric, vertices, attempt = smooth_bodies.attempt_with_noise()
    with Log().stage("realizations") as recorder:
        search = RealizationSearch(metric, LengthSystem(metric.triangulation), attempt, recorder, 5, 0.12)
        search.polish(attempt)
        assert not search.found
        next(search.steps(1))
    assert min(distance(found, vertices) for found in search.found) < 1e-9


def test_of_the_far_motions_those_that_smooth_are_kept():
    """Pushed in by more than any other vertex can be moved: the farthest motion of all puts it back."""
    x, faces = zoo.icosphere(1)
    pushed = x.copy()
    pushed[20] *= 0.9
    charts = QuinticResiduals.of(PolyhedralMetric.from_mesh(x, faces).triangulation, pushed)
    motions = np.zeros((MOST_MOTIONS + 2 * SMOOTHER_MOTIONS, *x.shape))
    vertex = np.arange(len(motions)) % 20
    motions[range(len(motions)), vertex] = np.linspace(0.01, 0.05, len(motions))[:, None] * x[vertex]
    motions[-1] = x - pushed
    reach = np.linalg.norm(motions, axis=2).max(axis=1)
    kept = Motions(motions, reach, np.zeros(len(motions))).chosen(charts, pushed)
    assert len(kept.motions) == MOST_MOTIONS + SMOOTHER_MOTIONS
    assert np.array_equal(kept.reach[:MOST_MOTIONS], np.sort(reach)[:MOST_MOTIONS])
    assert np.array_equal(kept.motions[MOST_MOTIONS], motions[-1])


def test_motions_end_where_realizations_are(saddle):
    """To the second surface leads a motion that is predicted, from each of two: not the softest."""
    first, second = saddle.surfaces[:2]
    normalized = first.metric.normalized
    x, y = (each.vertices / first.metric.unit for each in (first, second))
    about = LengthExpansion(LengthSystem(first.triangulation), x, normalized.lengths)
    charts = QuinticResiduals.of(first.triangulation, x)
    found = nearby_motions(about, softest_motions(about, 4), 0.1 * normalized.mean_length, charts)
    assert (np.diff(found.reach) >= 0).all()
    misses = [distance(x + motion, y) for motion in found.motions]
    assert min(misses) < 0.1 * distance(x, y)


@pytest.mark.parametrize("mesh", [zoo.tetrahedron(), zoo.icosahedron(), zoo.random_hull(30, 0)])
def test_alone(mesh):
    found = isoembed.realizations(embedding(*mesh), distance=0.05)
    assert len(found.surfaces) == 1
    assert found.searched.all()
    assert found.message.startswith("1 realization of these lengths found within 0.05 mean edge lengths")


def test_a_surface_that_flexes_is_not_searched_from():
    vertices, faces = zoo.icosphere(1)
    found = isoembed.realizations(embedding(vertices * [1, 1, 0], faces, lengths_of=vertices))
    assert found.surfaces == ()
    assert found.unsolved == 1
    assert found.message.startswith("no realization of these lengths was found within 0.12 mean edge lengths")
    assert "1 cases of a flexible surface" in found.message


def test_the_unit_does_not_matter():
    x, faces = capped(*zoo.icosahedron(), [0, 7], [HEIGHT, HEIGHT])
    small, large = (isoembed.realizations(embedding(s * x, faces), motions=2) for s in (1e-150, 1e12))
    assert len(small.surfaces) == 4
    assert np.sort(small.distances) == pytest.approx(np.sort(large.distances), rel=1e-6, abs=1e-12)


def test_the_report(saddle):
    report = saddle.report
    assert report["message"] == saddle.message
    assert "Not searched: farther surfaces" in report["message"]
    assert report["region"] == {"distance": 0.12, "motions": 5, "unsolved": 0}
    assert np.array(report["apart"]) == pytest.approx(saddle.apart)
    assert [each["searched"] for each in report["realizations"]] == saddle.searched.tolist()
    assert all(each["certificate"]["certified"] for each in report["realizations"])


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"distance": 0.0}, "the distance is 0.0, not a positive number of mean edge lengths"),
        ({"distance": np.nan}, "the distance is nan, not a positive number"),
        ({"motions": 9}, "the number of motions is 9, not an integer from 2 to 8"),
        ({"motions": 2.0}, "the number of motions is 2.0, not an integer from 2 to 8"),
        ({"surfaces": 0}, "the number of surfaces is 0, not an integer of at least 1"),
    ],
)
def test_parameters_out_of_range(options, sentence):
    with pytest.raises(InvalidParameter, match=sentence):
        isoembed.realizations(embedding(*zoo.icosahedron()), **options)
