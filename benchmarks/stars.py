"""Coarse stars: of how many bodies of 12 to 120 vertices is a surface found on their own triangles?

    python benchmarks/stars.py [--count N] [--first SEED] [--effort TIMES]

Half of the bodies have smooth radii, random harmonics of degree 2 to 5, half a random one at each vertex; the
spread of the radii is .1 to 70 %.  A body is resolved if its own `roughness` is below .05: the vertices stand
where cubics through their neighbors expect them, to a twentieth of an edge.

Printed are those that miss the tolerance, then by kind how many were found exactly, how many of these are the
body that the lengths came from, and how many another one that is smoother by `fine_roughness`; the seconds of
the processor of all and of those not found.  The same by roughness comes last, for those who draw the line of
what is resolved elsewhere.  Every answer's lengths are measured here: "wrong" counts answers
that claim a tolerance which they miss.
"""

import argparse
import time
from itertools import pairwise

import numpy as np
from scipy.special import sph_harm_y

from alexandrov import outward_hull
from convex_bodies import log_uniform, sphere
from isoembed import InvalidMetric, NotEmbedded, PolyhedralMetric, embed
from isoembed.aim.adaptive import Aim
from isoembed.embedding.embedding import Embedding
from stages import aligned

RESOLVED = 0.05  # of an edge
ROUGHNESSES = (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, np.inf)  # of an edge
SAME = 1e-6  # diameters
TOLERANCE = 1e-10  # mean edge lengths
KINDS = ("a radius at each vertex", "smooth radii")


def body(seed):
    """A star: vertices, faces, and which kind."""
    rng = np.random.default_rng([seed, 77])
    directions, faces = outward_hull(sphere(rng, int(rng.integers(12, 121))))
    kind = seed % 2
    spread = log_uniform(rng, 1e-2 if kind else 1e-3, 0.7)
    values = smooth_values(rng, directions) if kind else rng.normal(size=len(directions))
    return directions * np.exp(spread * values[:, None]), faces, kind


def smooth_values(rng, directions):
    """A random function of unit standard deviation."""
    polar = np.arccos(np.clip(directions[:, 2], -1, 1))
    azimuth = np.arctan2(directions[:, 1], directions[:, 0])
    values = np.zeros(len(directions))
    for degree in range(1, int(rng.integers(2, 6)) + 1):
        for order in range(-degree, degree + 1):
            harmonic = sph_harm_y(degree, abs(order), polar, azimuth)
            values += rng.normal() * (harmonic.real if order >= 0 else harmonic.imag)
    return values / values.std()


def measured(seed, effort):
    """What came of one star; None if its triangles are none."""
    vertices, faces, kind = body(seed)
    try:
        metric = PolyhedralMetric.from_mesh(vertices, faces)
    except InvalidMetric:
        return None
    true = Embedding(metric, vertices, method="true", tolerance=TOLERANCE)
    start = time.process_time()
    try:
        found = embed(metric, method=Aim(effort=effort), tolerance=TOLERANCE)
    except NotEmbedded as failure:
        found = failure.embedding
    seconds = time.process_time() - start
    ends = found.vertices[metric.edges]
    missed = np.abs(np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1) - metric.lengths).max()
    missed /= metric.lengths.mean()
    same = aligned(found.vertices, vertices) <= SAME
    if not found.converged:
        print(
            f"{seed:6d} {len(vertices):4d} vertices, roughness {true.surface.roughness:.3f}: "
            f"missed by {missed:.0e}"
        )
    return {
        "kind": kind,
        "roughness": true.surface.roughness,
        "resolved": true.surface.roughness < RESOLVED,
        "exact": found.converged and missed <= 2 * TOLERANCE,
        "wrong": found.converged and missed > 2 * TOLERANCE,
        "same": same,
        "smoother": found.converged
        and not same
        and found.surface.fine_roughness < true.surface.fine_roughness,
        "seconds": seconds,
    }


def line(label, rows):
    """A line of the summary."""
    lost = [row["seconds"] for row in rows if not row["exact"]]
    counts = {key: sum(row[key] for row in rows) for key in ("exact", "wrong", "same", "smoother")}
    seconds = np.mean([row["seconds"] for row in rows]) if rows else 0.0
    return (
        f"{label:36} {counts['exact']:4d} of {len(rows):4d} exact, {counts['wrong']} wrong, "
        f"{counts['same']:4d} the same body, {counts['smoother']:3d} smoother; "
        f"{seconds:.2f} s each, {np.mean(lost) if lost else 0.0:.2f} s where not found"
    )


def main():
    """Run what is asked."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--count", type=int, default=240, metavar="N")
    parser.add_argument("--first", type=int, default=1000, metavar="SEED")
    parser.add_argument("--effort", type=float, default=1.0, metavar="TIMES")
    options = parser.parse_args()
    seeds = range(options.first, options.first + options.count)
    rows = [row for seed in seeds if (row := measured(seed, options.effort)) is not None]
    for resolved in (True, False):
        for kind, name in enumerate(KINDS):
            these = [row for row in rows if row["resolved"] == resolved and row["kind"] == kind]
            print(line(f"{'resolved' if resolved else 'unresolved'}, {name}", these))
    print(line("resolved", [row for row in rows if row["resolved"]]))
    print(line("all", rows))
    for least, most in pairwise((0.0, *ROUGHNESSES)):
        these = [row for row in rows if least <= row["roughness"] < most]
        print(line(f"roughness from {least:g} to {most:g}", these))


if __name__ == "__main__":
    main()
