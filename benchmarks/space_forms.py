"""Convex polyhedra in hyperbolic space and on the 3-sphere: is each found, at what cost, and continuously?

    python benchmarks/space_forms.py [--seeds N] [--first SEED] [--sizes N ...] [--certify]

Random bodies, 8 to 200 vertices, aspects to 30 : 1, radii of 0.01 to 3 in hyperbolic space and diameters of
0.01 to 3 on the sphere, in radii of curvature.  They are convex hulls in projective coordinates, of points
in a box, on an ellipsoid or near it.  Lengths are those of the hull's triangles after random flips, so the
solver gets a gluing of triangles.  A body is *found* if no two vertices are at a distance that is wrong by
more than 1e-9 of the largest, if every given edge has its length along the surface to 1e-9 of the mean, and
if the surface is the hull, *refused* if the solver says that it found nothing, and *wrong* otherwise.  The
same body is found from its Euclidean lengths in projective coordinates, for comparison: factorizations and
seconds, which are those of the processor.

Then ellipsoids 3 : 2 : 1 of more and more vertices, in the three spaces; and one body of fixed lengths in
spaces whose curvature tends to zero, from both sides.
"""

import argparse
import time

import numpy as np
from scipy.spatial import ConvexHull
from threadpoolctl import threadpool_limits

import isoembed
from alexandrov import fibonacci, outward_hull
from isoembed.intrinsic.halfedges import HalfEdges
from isoembed.intrinsic.loops import flip
from isoembed.mesh.triangulation import Triangulation
from isoembed.space import Space
from isoembed.space.models import from_model, to_model

EXACT = 1e-9
THINNEST = 1e-3
WARM = 30
SIZES = (0.01, 3.0)
CURVATURES = (1e-2, 1e-3, 1e-4, 1e-5)


def points_of(rng):
    """Points in a unit ball, and the largest aspect of what they fill."""
    n = int(np.exp(rng.uniform(np.log(8), np.log(200))))
    x = rng.normal(size=(n, 3))
    x /= np.linalg.norm(x, axis=1)[:, None]
    kind = rng.integers(3)
    if kind == 1:
        x = rng.uniform(-1, 1, (n, 3))
    elif kind == 2:
        x *= rng.uniform(0.5, 1, n)[:, None] ** 0.3
    aspects = np.sort(30 ** rng.uniform(0, 1, 2))
    x /= [1, *aspects]
    return x / np.linalg.norm(x, axis=1).max(), float(aspects[1])


def body(seed, sign):
    """Projective coordinates of a body in the space of curvature `sign`, its triangles, size and aspect."""
    rng = np.random.default_rng(seed)
    x, aspect = points_of(rng)
    size = float(SIZES[0] * (SIZES[1] / SIZES[0]) ** rng.random())
    r = np.linalg.norm(x, axis=1)
    y = x / r[:, None] * (np.tanh(r * size) if sign < 0 else np.tan(r * size / 2))[:, None]
    y, faces = outward_hull(y)
    return y, faces, size, aspect


def metric_of(x, faces, space, seed):
    """The lengths of a surface, on triangles that come of random flips."""
    lengths = space.distances(x[faces], x[np.roll(faces, -1, axis=1)])
    tables = HalfEdges.of(faces, Triangulation(faces).twins, lengths, space.curvature)
    for h in np.random.default_rng(seed).integers(0, faces.size, 10 * len(x)):
        flip(int(h), tables.views, THINNEST)
    return isoembed.GluedMetric(tables.faces, tables.twins, tables.face_lengths, curvature=space.curvature)


def solved(metric):
    """The polyhedron or the refusal; seconds and factorizations."""
    start = time.process_time()
    try:
        found = isoembed.embed(metric, method="alexandrov")
    except (isoembed.NotEmbedded, isoembed.InvalidMetric) as refusal:
        return refusal, time.process_time() - start, 0
    seconds = time.process_time() - start
    return found, seconds, sum(stage.factorizations for stage in found.stages)


def wrong_by(found, x, space):
    """Largest error of a distance between two vertices over the largest; excess of the hull's faces."""
    i, j = np.triu_indices(len(x), 1)
    expected = space.distances(x[i], x[j])
    off = float(
        np.abs(space.distances(found.vertices[i], found.vertices[j]) - expected).max() / expected.max()
    )
    y = to_model(space, found.vertices, "projective")
    a, b, c = y[found.faces.T]
    normals = np.cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    outside = float(((y @ normals.T) - np.einsum("ij,ij->i", normals, a)).max() / np.abs(y).max())
    return off, outside, len(ConvexHull(y).vertices) == len(y)


def random_bodies(sign, seeds, certify):
    """Rows of one space; prints what is not found."""
    space, rows = Space(float(sign)), []
    for seed in seeds:
        y, faces, size, aspect = body(seed, sign)
        x = from_model(space, y, "projective")
        found, seconds, factorizations = solved(metric_of(x, faces, space, seed))
        flat = solved(metric_of(y, faces, Space(), seed))
        row = {"n": len(y), "size": size, "aspect": aspect, "seconds": seconds, "factors": factorizations}
        row |= {"flat seconds": flat[1], "flat factors": flat[2], "certified": None}
        if isinstance(found, Exception):
            row |= {"status": "refused", "off": np.nan, "lengths": np.nan, "why": str(found)}
        else:
            off, outside, whole = wrong_by(found, x, space)
            fine = off <= EXACT and found.residual <= EXACT and outside <= EXACT and whole
            row |= {"status": "found" if fine else "wrong", "off": off, "lengths": found.residual}
            row["why"] = f"distances {off:.1e}, lengths {found.residual:.1e}, outside {outside:.1e}"
            if certify:
                row["certified"] = bool(isoembed.certify(found).certified)
        if row["status"] != "found":
            print(f"  seed {seed}: {row['status']}, {len(y)} vertices, size {size:.3g}, aspect {aspect:.3g}")
            print(f"    {row['why']}", flush=True)
        rows.append(row)
    return rows


def print_bodies(name, rows):
    """One line of the table, and one on the cost."""
    count = {status: sum(row["status"] == status for row in rows) for status in ("found", "refused", "wrong")}
    found = [row for row in rows if row["status"] == "found"]
    off, lengths = (max(row[key] for row in found) for key in ("off", "lengths"))
    print(
        f"{name}: {count['found']} of {len(rows)} found ({100 * count['found'] / len(rows):.2f} %), "
        f"{count['refused']} refused, {count['wrong']} wrong; "
        f"distances to {off:.1e}, lengths to {lengths:.1e}"
    )
    ours, flat = (sum(row[key] for row in rows) for key in ("seconds", "flat seconds"))
    middle, flat_middle = (np.median([row[key] for row in rows]) for key in ("factors", "flat factors"))
    print(
        f"  {ours:.1f} s, {flat:.1f} s for the bodies in Euclidean space: ratio {ours / flat:.2f}; "
        f"median of the ratios {np.median([row['seconds'] / row['flat seconds'] for row in rows]):.2f}; "
        f"factorizations {middle:.0f}, and {flat_middle:.0f}, in the median"
    )
    if found and found[0]["certified"] is not None:
        print(f"  certified: {sum(row['certified'] for row in found)} of {len(found)}")


def print_round(sizes):
    """Ellipsoids of more and more vertices."""
    print("ellipsoids 3 : 2 : 1")
    print(
        f"{'vertices':>9} {'space':>10} {'size':>5} {'factors':>8} {'seconds':>8} {'ratio':>6} {'lengths':>8}"
    )
    spaces = ((-1, 0.1), (-1, 1.0), (-1, 2.0), (1, 0.1), (1, 0.5), (1, 1.0), (0, 1.0))
    for n in sizes:
        rows = []
        for sign, size in spaces:  # what is compiled on the way is so before the last
            space = Space(float(sign))
            y, faces = outward_hull(fibonacci(n) / 3 * float(space.sn(size) / space.cs(size)))
            x = from_model(space, y, "projective")
            a, b = Triangulation(faces).edges.T
            metric = isoembed.PolyhedralMetric(faces, space.distances(x[a], x[b]), curvature=float(sign))
            rows.append(
                (space, size, len(x), *min((solved(metric) for _ in range(4)), key=lambda run: run[1]))
            )
        euclidean = rows[-1][4]
        for space, size, count, found, seconds, factorizations in rows:
            residual = "refused" if isinstance(found, Exception) else f"{found.residual:.0e}"
            print(
                f"{count:9d} {space.name:>10} {size:5.2g} {factorizations:8d} {seconds:8.2f} "
                f"{seconds / euclidean:6.2f} {residual:>8}",
                flush=True,
            )


def print_limit():
    """How far the distances between vertices are from those of the Euclidean body of the same lengths."""
    flat = isoembed.PolyhedralMetric.from_mesh(*outward_hull(fibonacci(150) / 3))
    base = isoembed.embed(flat, method="alexandrov").vertices
    i, j = np.triu_indices(len(base), 1)
    expected = Space().distances(base[i], base[j])
    print(f"{'curvature':>10} {'difference':>11} {'over curvature':>15}")
    for k in [sign * k for sign in (-1, 1) for k in CURVATURES]:
        metric = isoembed.PolyhedralMetric.on(flat.triangulation, flat.lengths.copy(), Space(k))
        found = isoembed.embed(metric, method="alexandrov").vertices
        difference = Space(k).distances(found[i], found[j]) - expected
        print(f"{k:10.0e} {np.abs(difference).max():11.3e} {np.abs(difference).max() / abs(k):15.6f}")


def main():
    """Run what is asked."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seeds", type=int, default=500, metavar="N", help="bodies in each space")
    parser.add_argument("--first", type=int, default=0, metavar="SEED")
    parser.add_argument("--sizes", type=int, nargs="*", default=[600, 2500, 10000], metavar="N")
    parser.add_argument("--certify", action="store_true", help="ask for certificates, too")
    options = parser.parse_args()
    with threadpool_limits(1):
        seeds = range(options.first, options.first + options.seeds)
        for sign in (-1, 1):  # what is compiled on the way is so before it counts
            random_bodies(sign, seeds[:WARM], False)
        for sign, name in ((-1, "hyperbolic"), (1, "spherical")) if seeds else ():
            print_bodies(name, random_bodies(sign, seeds, options.certify))
        print_round(options.sizes)
        print_limit()


if __name__ == "__main__":
    main()
