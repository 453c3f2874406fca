"""Certificates of what the default method finds: what they prove, and what they cost.

    python benchmarks/certificates.py [--sizes N ...] [--bodies NAME ...] [--exact]

A row for every body and size: seconds of the processor for the surface and for its certificate; how near an
exact one is, how far any other (both in mean edge lengths), and how far the nearest other one that was met.
A vertex moved by a millionth of the mean edge length must be refused.  With --exact the vertices of the body
itself are certified, not embedded.
"""

import argparse
import time

import numpy as np

from isoembed import PolyhedralMetric, embed
from isoembed.gallery import Ergosphere, triangulate
from isoembed.proof.certificate import certify
from realizations import GALLERY

BODIES = {
    **{f"ergosphere {epsilon}": Ergosphere(epsilon) for epsilon in (0.05, 0.1, 0.3)},
    **{name: GALLERY[name] for name in ("peanut", "saddle", "trefoil")},
}
HEAD = (
    f"{'body':15} {'vertices':>8} {'embed':>8} {'certify':>8}  {'radius':>7} {'isolation':>9} {'nearest':>8}"
)


def row(name, vertices, faces, exact):
    """Embed and certify one; print its line, and return what is wrong."""
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    start, nearest = time.process_time(), np.inf
    if not exact:
        surface = embed(metric)
        vertices = surface.vertices
        nearest = min((surface.distance(other) for other in surface.others), default=np.inf)
    found = time.process_time()
    proof = certify(metric, vertices)
    end = time.process_time()
    line = f"{name:15} {len(vertices):8d} {found - start:8.2f} {end - found:8.2f}  "
    if not proof.certified:
        print(line + proof.reason, flush=True)
        return ["not certified"]
    print(line + f"{proof.radius:7.1e} {proof.isolation:9.1e} {nearest:8.1e}", flush=True)
    moved = vertices.copy()
    moved[len(moved) // 2] += 1e-6 * metric.mean_length * np.array([0.6, 0.48, 0.64])
    return [
        said
        for said, wrong in (
            ("the faces may cross", not proof.embedded),
            ("another is nearer than the isolation", nearest < proof.isolation),
            ("the isolation is small", proof.isolation < 1e4 * proof.radius),
            ("a moved vertex is certified", certify(metric, moved).certified),
            (
                "it took more than twice as long as the surface",
                not exact and end - found > 2 * (found - start),
            ),
        )
        if wrong
    ]


def main():
    """Run what is asked."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--sizes", type=int, nargs="+", default=(1000, 10_000, 100_000), metavar="N")
    parser.add_argument("--bodies", nargs="+", choices=BODIES, default=BODIES, metavar="NAME")
    parser.add_argument("--exact", action="store_true", help="certify the body itself")
    options = parser.parse_args()
    embed(PolyhedralMetric.from_mesh(*triangulate(BODIES["peanut"], 300)))  # compiles what it needs
    print(HEAD, flush=True)
    wrong = {}
    for n in options.sizes:
        for name in options.bodies:
            wrong[name, n] = row(name, *triangulate(BODIES[name], n), options.exact)
    for (name, n), said in wrong.items():
        for each in said:
            print(f"** {name}, {n} vertices: {each}")
    print(f"{sum(not said for said in wrong.values())} of {len(wrong)} as they should be")


if __name__ == "__main__":
    main()
