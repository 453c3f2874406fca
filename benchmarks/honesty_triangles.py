"""Inputs of honesty.py that are triangles and lengths of edges, with k and p at the vertices."""

from functools import cache

import numpy as np

from honesty_grids import Case, truth
from honesty_truth import Ellipsoid, Placing, kerr_sphere, peaked, wave
from isoembed import PolyhedralMetric, embed
from isoembed.meshing.sphere import fibonacci_directions, hull_faces
from isoembed.relativity import KerrNewmanSphere, mesh_energies
from isoembed.smooth import triangulate_metric

MESHES = ("isotropic", "irregular", "graded", "geodesic", "Kerr")
SIZES = (12, 20, 60, 150, 400, 1000)
NOISE = (1e-10, 1e-8, 1e-6, 1e-4, 1e-2, 0.1)
OF_LENGTHS = (1e-10, 1e-8, 1e-6, 1e-5, 1e-4, 1e-3)
AXES = (2.0, 2.3, 2.6)  # of the chords' ellipsoid
ROUND = (2.0, 2.0, 2.0)  # of the sphere with geodesic lengths


def smooth_k(u):
    return 1.0 + 0.2 * u[:, 0] * u[:, 1] + 0.1 * u[:, 2]


def smooth_p(u):
    return 0.4 + 0.2 * u[:, 2]


@cache
def mesh(kind, n):
    """Directions of n vertices, faces, and lengths of the edges of a `PolyhedralMetric`, which is third."""
    rng = np.random.default_rng(n)
    u = fibonacci_directions(n)
    if kind == "Kerr":
        triangles = triangulate_metric(KerrNewmanSphere(3.0, 1.0, 0.8), n)
        return triangles.directions, triangles.metric
    if kind == "irregular":
        u = u + 0.9 / np.sqrt(n) * rng.uniform(-1.0, 1.0, size=u.shape)
    if kind == "graded":
        u = u * [0.5, 1.0, 1.0] + [0.25, 0.0, 0.0]
    u /= np.linalg.norm(u, axis=1)[:, None]
    faces = hull_faces(u)
    metric = PolyhedralMetric.from_mesh(u * AXES, faces)
    if kind == "geodesic":
        i, j = metric.edges.T
        metric = metric.with_lengths(2.0 * ROUND[0] * np.arcsin(0.5 * np.linalg.norm(u[i] - u[j], axis=1)))
    return u, metric


@cache
def embedded(kind, n, noise=0.0, unit=1.0, order=0):
    """Directions of the vertices and the embedding, of lengths with noise, relabelled by a seed."""
    u, metric = mesh(kind, n)
    rng = np.random.default_rng(17)
    if order:
        old = np.random.default_rng(order).permutation(n)
        label = np.argsort(old)
        faces = label[metric.faces]
        i, j = metric.edges.T
        lengths = {
            frozenset(pair): length
            for pair, length in zip(
                zip(label[i].tolist(), label[j].tolist(), strict=True), metric.lengths, strict=True
            )
        }
        u = u[old]
        new = PolyhedralMetric.from_mesh(u, faces)
        metric = new.with_lengths(np.array([lengths[frozenset(e)] for e in new.edges.tolist()]))
    lengths = unit * metric.lengths * (1.0 + noise * rng.normal(size=len(metric.lengths)))
    return u, embed(metric.with_lengths(lengths))


def known(kind, k=smooth_k, p=smooth_p, name=""):
    """The body of a mesh: k and p are those of Kerr's surface on its mesh."""
    if kind == "Kerr":
        return kerr_sphere(3.0, 0.8)
    return Ellipsoid(name, ROUND if kind == "geodesic" else AXES, k, p)


bodies = cache(known)


def case(kind, n, name, body, disturbed=None, said=True, **options):
    """Energies of a body on a mesh; `disturbed` changes k and p."""
    unit = options.get("unit", 1.0)
    lengths = "geodesic" if kind in ("geodesic", "Kerr") else "chord"

    def solve():
        u, embedding = embedded(kind, n, **options)
        k, p = (body.values(f, u) / unit for f in (body.k, body.p))
        if disturbed:
            k, p = disturbed(k, p)
        return mesh_energies(embedding, k, p, lengths=lengths if said else None)

    return Case("triangles", f"{kind} {n}: {name}", Placing(unit).scaled(truth(body)), solve)


def noise(level, which, seed=0):
    def disturbed(k, p):
        rng = np.random.default_rng([5, seed])
        size = level * np.abs(k).max()
        k = k + size * rng.normal(size=len(k)) * ("k" in which)
        return k, p + size * rng.normal(size=len(k)) * ("p" in which)

    return disturbed


def outlier(size, of_p=False):
    def disturbed(k, p):
        k, p = k.copy(), p.copy()
        changed = p if of_p else k
        changed[11] *= 1.0 + size
        return k, p

    return disturbed


def rough():
    """k that a mesh resolves badly: peaks, waves and kinks."""
    for width in (0.1, 0.3):
        yield f"peak {width}", peaked(width)
    for fold in (8, 16):
        yield f"wave {fold}", lambda u, f=fold: 1.0 + 0.2 * wave(u, f)
    yield "kink", lambda u: 1.0 + 0.3 * np.abs(u @ [0.6, 0.0, 0.8])


def nearly_null(least):
    """p that comes as near to k."""
    return lambda u: smooth_k(u) * (1.0 - least - 0.3 * u[:, 2] ** 2)


def cases(seeds):
    """All of them."""
    for kind in MESHES:
        for n in SIZES:
            yield case(kind, n, "exact", bodies(kind))
        yield case(kind, 400, "kind of lengths not said", bodies(kind), said=False)
        for level in NOISE:
            for which in ("k", "kp") if kind != "Kerr" else ("k",):
                for seed in range(seeds):
                    name = f"{level:g} in {which}, draw {seed}"
                    yield case(kind, 400, name, bodies(kind), noise(level, which, seed))
        yield case(kind, 60, "0.001 in k", bodies(kind), noise(1e-3, "k"))
        yield case(kind, 1000, "0.001 in k", bodies(kind), noise(1e-3, "k"))
        for level in OF_LENGTHS:
            yield case(kind, 400, f"{level:g} in lengths", bodies(kind), noise=level)
        yield case(kind, 150, "0.0001 in lengths", bodies(kind), noise=1e-4)
        yield case(kind, 1000, "0.0001 in lengths", bodies(kind), noise=1e-4)
        for size in (0.01, 0.2, 3.0):
            yield case(kind, 400, f"k off by {size:g} at a vertex", bodies(kind), outlier(size))
    for kind in ("isotropic", "irregular", "geodesic"):
        for unit in (1e-3, 1e6):
            yield case(kind, 150, f"unit {unit:g}", bodies(kind), noise(1e-3, "k"), unit=unit)
        yield case(kind, 150, "relabelled", bodies(kind), noise(1e-3, "k"), order=3)
        yield case(kind, 400, "p off by 0.2 at a vertex", bodies(kind), outlier(0.2, of_p=True))
        for name, k in rough():
            body = known(kind, k, lambda u: 0.0 * u[:, 0], name)
            for n in (150, 400, 1000):
                yield case(kind, n, name, body)
        for least in (1e-1, 1e-2, 1e-3):
            body = known(kind, smooth_k, nearly_null(least), "null")
            yield case(kind, 400, f"k^2 - p^2 down to {2 * least:g}", body)
            yield case(kind, 400, f"k^2 - p^2 down to {2 * least:g}, 1e-4 in k", body, noise(1e-4, "k"))
