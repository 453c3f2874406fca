"""Shallow caps: whether the default method comes to the convex polyhedron where its triangles are given.

    python benchmarks/shallow_caps.py [--count N]

A cap is the convex hull of 10 to 60 random points on a paraboloid over the unit disk, 1e-1, 1e-2, ... 1e-5
high, and of a point below.  Its lengths have many realizations on the triangles of the hull, with vertices
pushed in by as little as 1e-6 of the diameter.  Printed are, by height, the caps that the default method and
Alexandrov's refused; those where the default method found the hull to 1e-3 of its height; where the two agree
or each is among the `others`; those with a vertex pushed in; and the median seconds of either.
"""

import argparse
import time

import numpy as np

from alexandrov import outward_hull
from isoembed import Embedding, NotEmbedded, PolyhedralMetric, embed

HEIGHTS = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5)
AGREE = 1e-3  # of the height: a dent is about a hundredth


def cap(height, seed):
    """The hull's vertices and faces."""
    rng = np.random.default_rng(seed)
    n = 10 + seed % 51
    r, angle = np.sqrt(rng.uniform(size=n)), rng.uniform(0, 2 * np.pi, n)
    top = np.stack([r * np.cos(angle), r * np.sin(angle), height * (1 - r * r)], axis=1)
    return outward_hull(np.vstack([top, [[0.0, 0.0, -1.0]]]))


def found(metric, method):
    """The surface, or None, and the seconds that it took."""
    start = time.perf_counter()
    try:
        surface = embed(metric, method=method)
    except NotEmbedded:
        surface = None
    return surface, time.perf_counter() - start


def measured(height, seed):
    """What came of a cap, by name."""
    vertices, faces = cap(height, seed)
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    aim, seconds = found(metric, "aim")
    polyhedron, seconds_of_polyhedron = found(metric, "alexandrov")

    def near(surface, points):
        same = Embedding(metric, points, method="", tolerance=1.0)
        return surface.distance(same) * metric.mean_length < AGREE * height

    return {
        "aim refused": aim is None,
        "alexandrov refused": polyhedron is None,
        "found": aim is not None and near(aim, vertices),
        "agree": aim is not None
        and polyhedron is not None
        and any(near(surface, polyhedron.vertices) for surface in (aim, *aim.others)),
        "pushed in": aim is not None and aim.surface.concave_edges.any(),
        "aim, s": seconds,
        "alexandrov, s": seconds_of_polyhedron,
    }


def main():
    """Run what is asked."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--count", type=int, default=200, metavar="N", help="caps of each height")
    options = parser.parse_args()
    measured(1e-1, 0)  # compiles
    names = list(measured(1e-1, 0))
    print("height  " + " ".join(f"{name:>18}" for name in names))
    for height in HEIGHTS:
        rows = [measured(height, seed) for seed in range(options.count)]
        columns = [np.array([row[name] for row in rows]) for name in names]
        cells = [f"{np.median(c):.2f}" if c.dtype == float else f"{c.sum()}" for c in columns]
        print(f"{height:<8.0e}" + " ".join(f"{cell:>18}" for cell in cells), flush=True)


if __name__ == "__main__":
    main()
