"""Surfaces with boundary and of higher genus: accuracy, rates, success and cost.

    python benchmarks/sheets.py [--only caps bending saddles curves tori] [--count N] [--sizes N ...]

Caps: distance from the true round cap.  Bending: int H^2 of round caps of least bending against
2 pi (1 - cos R), factorizations and seconds, and the exponent of the time.  Saddles: int k1^2 + k2^2 of
Enneper's surface, with chords and with lengths of geodesics, against 8 pi r^2 / (1 + r^2), and of hyperbolic
discs.  Curves: random discs, bumpy
graphs with K of both signs, round caps and halves of gallery bodies, whose boundary is given; found to 1e-9
of the diameter, or refused.  Tori: with bumps, from multidimensional scaling and from a torus of other radii.
"""

import argparse
import sys
import time
from pathlib import Path

import numpy as np

from isoembed import NotEmbedded, PolyhedralMetric, embed
from isoembed.surface.alignment import distance

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "support"))
import discs


def apart(found, true):
    """The largest distance of a vertex from its true place, or of the mirror image, over the diameter."""
    size = 2 * np.linalg.norm(true - true.mean(axis=0), axis=1).max()
    return min(distance(found * sign, true) for sign in ([1, 1, 1], [1, 1, -1])) / size


def caps(options):
    """Convex caps on the given triangles."""
    for n in options.sizes:
        points, faces = discs.irregular(n)
        x = discs.round_cap(points, 1.0)
        start = time.process_time()
        found = embed(PolyhedralMetric.from_mesh(x, faces), boundary="plane")
        seconds = time.process_time() - start
        flat = np.ptp(found.vertices[found.triangulation.boundaries[0], 2])
        print(
            f"cap      {len(x):6d} vertices: residual {found.residual:.1e}, planar to {flat:.1e}, "
            f"off {apart(found.vertices, x):.1e}, {seconds:.1f} s",
            flush=True,
        )


def bending(options):
    """Round caps of least bending."""
    exact, times = 2 * np.pi * (1 - np.cos(1)), []
    for n in options.sizes:
        points, faces = discs.irregular(n)
        metric = PolyhedralMetric.from_mesh(discs.round_cap(points, 1.0), faces)
        start = time.process_time()
        found = embed(metric, boundary="free")
        times.append(time.process_time() - start)
        spent = sum(stage.factorizations for stage in found.stages)
        print(
            f"bending  {len(points):6d} vertices: residual {found.residual:.1e}, int H^2 over the exact "
            f"{found.surface.bending_energy / exact:.5f}, imbalance {found.imbalance:.0e}, "
            f"{spent} factorizations, {times[-1]:.1f} s",
            flush=True,
        )
    if len(times) > 1:
        exponent = np.polyfit(np.log(options.sizes), np.log(times), 1)[0]
        print(f"bending  time grows as V^{exponent:.2f}")


ENNEPER = 0.8  # radius


def enneper(points, faces, geodesic):
    """Enneper's surface with chords for lengths, or with those of geodesics up to the fourth order."""
    u, v = ENNEPER * points.T
    x = np.stack([u - u**3 / 3 + u * v * v, -v + v**3 / 3 - v * u * u, u * u - v * v], axis=1)
    metric = PolyhedralMetric.from_mesh(x, faces)
    a, b = metric.edges.T
    along, across = ENNEPER * (points[b] - points[a]).T
    bend = 2 * (along**2 - across**2) / metric.lengths**2  # normal curvature, of II = 2 du^2 - 2 dv^2
    return metric.with_lengths(metric.lengths * (1 + geodesic * (bend * metric.lengths) ** 2 / 24))


def hyperbolic(points, faces, radius):
    """A disc of the hyperbolic plane."""
    edges = PolyhedralMetric.from_mesh(discs.round_cap(points, 1.0), faces).edges
    return PolyhedralMetric(faces, discs.hyperbolic_lengths(points, radius, edges), edges)


def saddles(options):
    """Sheets of least bending with K < 0."""
    exact = 8 * np.pi * ENNEPER**2 / (1 + ENNEPER**2)
    for n in options.sizes[:2]:
        for mesh, (points, faces) in (
            ("structured", discs.hexagonal(round(np.sqrt(n / 3)))),
            ("irregular", discs.irregular(n)),
        ):
            for name, metric, least in (
                ("Enneper, chords", enneper(points, faces, False), exact),
                ("Enneper, geodesics", enneper(points, faces, True), exact),
                ("hyperbolic disc, .5", hyperbolic(points, faces, 0.5), 4 * np.pi * (np.cosh(0.5) - 1)),
                ("hyperbolic disc, 1", hyperbolic(points, faces, 1.0), 4 * np.pi * (np.cosh(1.0) - 1)),
            ):
                start = time.process_time()
                found = embed(metric, boundary="free")
                share = found.second_form_energy / least
                print(
                    f"saddles  {len(points):6d} vertices, {mesh}: {name}: {share:.4f} of the exact or least "
                    f"energy, imbalance {found.imbalance:.0e}, {len(found.others)} others, "
                    f"{time.process_time() - start:.1f} s",
                    flush=True,
                )


def curves(options):
    """Random discs with a given boundary."""
    for name in ("bumpy", "cap", "half"):
        found, wrong, spent = 0, 0, []
        for seed in range(options.count):
            x, faces = discs.random_disc(name, seed)
            metric = PolyhedralMetric.from_mesh(x, faces)
            start = time.process_time()
            try:
                surface = embed(metric, boundary=x[metric.triangulation.boundaries[0]])
                right = apart(surface.vertices, x) < 1e-9
                found, wrong = found + right, wrong + (not right)
            except NotEmbedded:
                pass
            spent.append(time.process_time() - start)
        print(
            f"curves   {name}: {found} of {options.count} found, {wrong} converged elsewhere, "
            f"{options.count - found - wrong} refused; {np.median(spent):.1f} s in the median, "
            f"{max(spent):.1f} at most",
            flush=True,
        )


def tori(options):
    """Tori from their lengths."""
    for bump in (0.0, 0.1):
        x, faces = discs.torus(24, 12, bump)
        metric = PolyhedralMetric.from_mesh(x, faces)
        for name, start in (("scaling", None), ("round torus", 0.7 * discs.torus(24, 12)[0])):
            began = time.process_time()
            found = embed(metric, boundary="free", start=start)
            print(
                f"torus    bumps {bump}, from {name}: residual {found.residual:.1e}, off "
                f"{apart(found.vertices, x):.1e}, {time.process_time() - began:.1f} s",
                flush=True,
            )


KINDS = {"caps": caps, "bending": bending, "saddles": saddles, "curves": curves, "tori": tori}


def main():
    """Run what is asked."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--only", nargs="+", choices=KINDS, default=list(KINDS))
    parser.add_argument("--count", type=int, default=50, help="random discs of each kind")
    parser.add_argument("--sizes", type=int, nargs="+", default=[250, 1000, 3000])
    options = parser.parse_args()
    for kind in options.only:
        KINDS[kind](options)


if __name__ == "__main__":
    main()
