"""Solids with rounded coordinates: their faces, folds, certificates, and nets folded back.

    python benchmarks/rounded_solids.py [--decimals N ...] [--families NAME ...]

Solids are turned at random, and their coordinates rounded.  A line for each family and number of decimals
counts the solids for which each result is right: the numbers of sides of the faces, the number of folds, the
certificate, and the number of faces and the volume of what the net is glued to.  The names of the others
follow.
"""

import argparse
import sys
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

import isoembed
from isoembed.gluing import unfold

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "support"))
import solids
from johnson_solids import johnson

DECIMALS = (6, 7, 8, 9, 12)
CHECKS = ("faces", "folds", "certificate", "net and back")


def zonohedron(seed):
    """The sum of four to eight random segments, of which every fourth has three segments in one plane."""
    rng = np.random.default_rng(seed)
    segments = rng.normal(size=(4 + seed % 5, 3))
    if seed % 4 == 0:
        segments[2] = segments[0] + segments[1]
    points = np.zeros((1, 3))
    for segment in segments:
        points = np.concatenate([points, points + segment])
    return _corners(points)


def _corners(points):
    """Points that are corners of their convex hull: sums of segments have others in its faces."""
    from scipy.spatial import ConvexHull

    hull = ConvexHull(points)
    planes = np.unique(np.round(hull.equations, 9), axis=0)
    on = np.abs(points @ planes[:, :3].T + planes[:, 3]) < 1e-8
    candidates = np.flatnonzero(on.sum(axis=1) >= 3)
    ranks = [np.linalg.matrix_rank(planes[on[v], :3], tol=1e-6) for v in candidates]
    return points[candidates[np.array(ranks) == 3]]


FAMILIES = {
    "uniform": (solids.uniform, (*solids.PLATONIC, *solids.ARCHIMEDEAN)),
    "catalan": (solids.catalan, solids.ARCHIMEDEAN),
    "johnson": (johnson, range(1, 93)),
    "zonohedra": (zonohedron, range(50)),
}


def checked(points, decimals, seed):
    """Which of the checks a rounded solid passes."""
    polygons = solids.polygons(points)
    turned = np.round(points @ Rotation.random(random_state=seed).as_matrix().T, decimals)
    metric = isoembed.PolyhedralMetric.from_mesh(turned, polygons)
    faces = len(polygons)
    try:
        solid = isoembed.embed(metric, method="alexandrov")
        net = unfold(solid)
    except (isoembed.InvalidMetric, isoembed.NotEmbedded) as error:
        return dict.fromkeys(CHECKS, False), str(error)
    edges = len(points) + faces - 2
    folds = sum(map(len, net.folds)) + len(net.sides)
    passed = {
        "faces": sorted(solid.surface.flat_faces.sides.tolist()) == sorted(map(len, polygons)),
        "folds": len(net.sheets) == 1 and folds == edges,
        "certificate": isoembed.certify(solid).certified,
    }
    try:
        back = isoembed.embed(net.net, method="alexandrov")
        passed["net and back"] = bool(
            int(back.surface.flat_faces.of_triangles.max()) + 1 == faces
            and abs(back.volume / solid.volume - 1) < 10.0 ** (1 - decimals)
        )
    except (isoembed.InvalidMetric, isoembed.NotEmbedded):
        passed["net and back"] = False
    return passed, isoembed.certify(solid).reason


def main():
    """Print the counts."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--decimals", nargs="+", type=int, default=DECIMALS, metavar="N")
    parser.add_argument("--families", nargs="+", choices=FAMILIES, default=FAMILIES, metavar="NAME")
    options = parser.parse_args()
    for decimals in options.decimals:
        for family in options.families:
            make, names = FAMILIES[family]
            right, wrong = dict.fromkeys(CHECKS, 0), []
            for seed, name in enumerate(names):
                passed, reason = checked(make(name), decimals, seed)
                for check in CHECKS:
                    right[check] += passed[check]
                failed = [check for check in CHECKS if not passed[check]]
                if failed:
                    wrong.append(f"    {name}: {', '.join(failed)} ({reason[:110]})")
            counts = ", ".join(f"{check} {count}" for check, count in right.items())
            print(f"{decimals} decimals, {len(names)} {family}: {counts}", *wrong, sep="\n", flush=True)


if __name__ == "__main__":
    main()
