"""The default method: coordinates come back from lengths; invariances, costs, refusals and diagnoses."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import isoembed
import smooth
import zoo
from isoembed.aim.adaptive import Aim, inscribed
from isoembed.errors import NotEmbedded
from isoembed.gallery import CassiniPeanut, Ellipsoid, KerrHorizon, triangulate
from isoembed.linalg import available_backends
from isoembed.metric.curvature import area
from isoembed.metric.polyhedral import PolyhedralMetric


def recovered(vertices, faces, **parameters):
    """The embedding of a surface's lengths, and how far from the surface it is."""
    surface = isoembed.embed(PolyhedralMetric.from_mesh(vertices, faces), method=Aim(**parameters))
    return surface, smooth.misfit(surface.vertices, vertices)


@pytest.mark.parametrize(
    ("mesh", "factorizations"),
    [
        (smooth.ellipsoid(), 25),
        (smooth.ellipsoid(800), 25),
        (smooth.drum(), 25),
        (triangulate(Ellipsoid((5, 2, 1)), 400), 70),
        (triangulate(Ellipsoid((1, 1, 4)), 300), 70),
    ],
    ids=["ellipsoid", "ellipsoid 800", "drum", "(5, 2, 1)", "(1, 1, 4)"],
)
def test_discarded_coordinates_come_back(mesh, factorizations):
    surface, error = recovered(*mesh)
    assert surface.residual < 1e-13  # the polish goes to the rounding floor, whatever the tolerance
    assert error < 1e-9
    assert not surface.inverted_vertices.any()
    assert not surface.partially_inverted_vertices.any()
    assert sum(stage.factorizations for stage in surface.stages) <= factorizations
    if factorizations == 25:  # long bodies may need the guided pull-back
        assert [stage.name for stage in surface.stages] == ["uniformize", "pull back", "polish"]


@pytest.mark.parametrize(
    "mesh",
    [zoo.tetrahedron(), zoo.octahedron(), zoo.cube(), zoo.icosahedron(), zoo.icosphere(2)],
    ids=["tetrahedron", "octahedron", "cube", "icosahedron", "icosphere"],
)
def test_bodies_inscribed_in_a_sphere(mesh):
    surface, error = recovered(*mesh)
    assert error < 1e-9
    assert surface.volume == pytest.approx(
        isoembed.Embedding(surface.metric, mesh[0], method="", tolerance=1).volume
    )


@pytest.mark.parametrize("n", [4, 5, 6, 8, 12, 20, 30, 50])
@pytest.mark.parametrize("seed", range(3))
def test_convex_hulls_of_random_points(n, seed):
    surface, error = recovered(*zoo.random_hull(n, 100 * n + seed))
    assert error < 1e-7
    assert not surface.concave_edges.any()


@pytest.mark.parametrize("surface", [CassiniPeanut(), KerrHorizon()])
def test_other_surfaces_of_the_gallery(surface):
    vertices, faces = triangulate(surface, 300)
    embedding, error = recovered(vertices, faces)
    assert embedding.residual < 1e-12
    assert error < 1e-7


@settings(max_examples=15)
@given(
    st.integers(0, 10**6),
    st.floats(-150, 12).map(lambda e: 10.0**e),
    st.booleans(),
    st.booleans(),
)
def test_unit_numbering_mirror_and_orientation_do_not_matter(seed, scale, mirrored, reversed_):
    vertices, faces = smooth.ellipsoid(100)
    moved, others, _ = zoo.relabeled(vertices, faces, seed)
    if mirrored:
        moved = moved * [1, 1, -1]
    if reversed_:
        others = others[:, ::-1]
    surface = isoembed.embed(PolyhedralMetric.from_mesh(scale * moved, others))
    assert smooth.misfit(surface.vertices / scale, moved) < 1e-9
    # Outward by the given triangles: the volume is positive whichever way round they are.
    x = surface.vertices / scale
    a, b, c = (x[others[:, k]] for k in range(3))
    assert np.einsum("ij,ij->", a, np.cross(b, c)) > 0


@pytest.mark.parametrize("scale", [1e-300, 1e-150, 1e12, 1e150, 1e300])
def test_extreme_units_change_not_one_digit(scale):
    vertices, faces = smooth.ellipsoid(100)
    power = 2.0 ** np.round(np.log2(scale))
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    plain = isoembed.embed(metric)
    scaled = isoembed.embed(metric.with_lengths(power * metric.lengths))
    assert (scaled.vertices / power == plain.vertices).all()
    assert scaled.residual == plain.residual


def test_the_inscribed_start_has_the_area_and_lies_on_a_sphere():
    metric = PolyhedralMetric.from_mesh(*smooth.ellipsoid()).normalized
    start = inscribed(metric, smooth.tally())
    radii = np.linalg.norm(start, axis=1)
    assert radii == pytest.approx(radii[0], rel=1e-13)
    assert area(PolyhedralMetric.from_mesh(start, metric.faces)) == pytest.approx(area(metric), rel=1e-13)
    a, b, c = (start[metric.faces[:, k]] for k in range(3))
    assert np.einsum("ij,ij->", a, np.cross(b, c)) > 0


def test_steps_of_any_size_end_at_the_same_surface():
    vertices, faces = smooth.ellipsoid()
    for first_step, largest_change in ((0.5, 0.5), (0.02, 0.05), (0.25, 2.0)):
        parameters = {"first_step": first_step, "smallest_step": 0.01, "largest_change": largest_change}
        assert recovered(vertices, faces, **parameters)[1] < 1e-9


def test_steps_grow_where_little_changes():
    surface, _ = recovered(*smooth.ellipsoid(), first_step=0.02, smallest_step=0.01)
    assert surface.stages[1].iterations < 30  # 50 steps of 0.02 would take more


def test_a_step_that_changes_too_much_is_halved():
    vertices, faces = smooth.ellipsoid(100)
    seen = []
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    method = Aim(first_step=0.5, smallest_step=1 / 64, largest_change=0.02)
    surface = isoembed.embed(metric, method=method, progress=seen.append)
    times = [p.t for p in seen if p.t is not None]
    assert times[0] > 0.5  # the first try was refused
    assert times[-1] == 0
    assert times == sorted(times, reverse=True)
    assert smooth.misfit(surface.vertices, vertices) < 1e-9


@pytest.mark.parametrize("backend", available_backends())
def test_every_backend(backend):
    vertices, faces = smooth.ellipsoid(100)
    assert recovered(vertices, faces, backend=backend)[1] < 1e-9


def noisy(amount):
    metric = PolyhedralMetric.from_mesh(*smooth.ellipsoid(100))
    return metric.with_lengths(
        metric.lengths * (1 + amount * np.random.default_rng(0).normal(size=len(metric.lengths)))
    )


def test_small_noise_is_embedded():
    surface = isoembed.embed(noisy(1e-4))
    assert surface.residual < 1e-12
    assert smooth.misfit(surface.vertices, smooth.ellipsoid(100)[0]) < 1e-2


def test_the_diagnosis_names_the_place_where_the_surface_is_lost():
    with pytest.raises(
        NotEmbedded, match=r"Newton's method lost the surface at t = 0\.\d+ \(1 is the uniform"
    ) as caught:
        isoembed.embed(noisy(0.05))
    attempt = caught.value.embedding
    assert attempt.residual < 0.5  # in fair shape
    assert not attempt.converged
    assert [stage.name for stage in attempt.stages] == [
        "uniformize",
        "pull back",
        "guided pull back",
        "polish",
    ]


def test_lengths_of_no_surface():
    metric = PolyhedralMetric.from_mesh(*smooth.ellipsoid(100))
    with pytest.raises(NotEmbedded):
        isoembed.embed(metric.with_lengths(np.ones(len(metric.lengths))))


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"first_step": 0}, r"first_step is 0, not in \(0, 1\]"),
        ({"first_step": 1.5}, r"first_step is 1.5, not in \(0, 1\]"),
        ({"first_step": float("nan")}, "first_step is nan"),
        ({"smallest_step": 0}, r"smallest_step is 0, not in \(0, first_step\]"),
        ({"first_step": 0.1, "smallest_step": 0.2}, r"smallest_step is 0.2, not in \(0, first_step\]"),
        ({"largest_change": 0.0}, "largest_change is 0.0, not positive"),
        ({"backend": "umfpack"}, "unknown backend 'umfpack'"),
    ],
    ids=str,
)
def test_parameters_are_refused(parameters, message):
    with pytest.raises(ValueError, match=message):
        Aim(**parameters)
