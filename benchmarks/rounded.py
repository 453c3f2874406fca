"""Surfaces from lengths that are rounded, or measured with errors.

    python benchmarks/rounded.py [--families NAME ...] [--digits N ...] [--seeds N]
                                 [--questions NAME ...] [--most N] [--each]

Lengths are those of surfaces about 300 units across, rounded to a unit of the largest one's N-th digit, or
with Gaussian errors of the same standard deviation, the unit over sqrt(12).  The questions are

    rounded    embed(metric): the digits show the errors,
    given      embed(metric, length_errors=sigma) of the same lengths,
    gaussian   embed(metric, length_errors=sigma).

Rocks are ellipsoids of semiaxes 150, 120 and 100 whose vertices have independent Gaussian displacements
of 1.5, 3 and 6 units in each coordinate; scans and horizons are smooth. Printed for each family: how
many there are of each status; the farthest vertex of the answer from the true ones over that of the
floor (`rounded_truth`), median and 95 % quantile; how many answers are crumpled, with a `fine_roughness`
more than twice that of the true surface or of the floor; how many more than three times as far as the
floor are other surfaces, which agree with the lengths and are as smooth as the true one to 5 %, so that
nothing tells them from it; and the percentage of areas, volumes and integrals of the mean curvature
within two stated standard deviations, of the answers that state some, volumes that are not determined
aside. A refusal counts as infinitely far, crumpled, and outside.

Percentages are judged where 30 answers or more state deviations: at least 90, and at most 99 of Gaussian
errors.  Where all edges have one length, its rounding error is always within sqrt(3) deviations.

By default one seed and 700 vertices at most, a quarter of an hour of one core or so; in full
``--seeds 3 --most 2000``.
"""

import argparse
import sys
import time
from collections import Counter
from pathlib import Path

import numpy as np
from scipy.spatial import ConvexHull

import isoembed
from isoembed import Embedding, NotEmbedded, PolyhedralMetric, embed
from isoembed.errors import InvalidMetric, InvalidParameter
from isoembed.gallery import HarmonicSurface, KerrHorizon, triangulate
from rounded_truth import farthest, integrals, least_squares_surface

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "support"))
import solids
from domes import dome
from johnson_solids import johnson

SIZE = 150.0  # the largest distance from the center
ROUGHNESSES = (1.5, 3.0, 6.0)
ROCKS, SCANS = (40, 80, 200), (300, 700, 2000)
MEDIAN, MOST = 1.5, 3.0  # ratios asked of half and of 95 % of the answers
STATED = 30  # answers with deviations, of which percentages are judged


def hull(points, directions):
    """Triangles of the hull of some directions, outward."""
    faces = ConvexHull(directions).simplices
    a, b, c = directions[faces].transpose(1, 0, 2)
    inward = np.einsum("ij,ij->i", np.cross(b - a, c - a), a + b + c) < 0
    faces[inward] = faces[inward][:, ::-1]
    return points, faces


def rock(n, roughness, seed):
    """An ellipsoid on a Fibonacci lattice, with white noise."""
    z = 1 - (2 * np.arange(n) + 1) / n
    turn = np.pi * (1 + 5**0.5) * np.arange(n)
    u = np.stack([np.sqrt(1 - z**2) * np.cos(turn), np.sqrt(1 - z**2) * np.sin(turn), z], axis=1)
    points = u * (150.0, 120.0, 100.0)
    noise = np.random.default_rng([seed, n]).standard_normal(points.shape)
    return hull(points + roughness * noise, points)


def solid(points):
    """A convex solid on triangles of its faces."""
    return points, solids.triangles(solids.polygons(points))


def bodies(family, seed):
    """The name, true vertices and triangles of each body of a family."""
    if family.startswith("rocks"):
        for n in ROCKS:
            yield f"{n} vertices, seed {seed}", *rock(n, float(family.split()[1]), seed)
    elif family == "Johnson solids":
        yield from ((f"J{k}", *solid(johnson(k))) for k in range(1 + seed, 93, 8))
    elif family == "Archimedean solids":
        yield from ((name, *solid(solids.uniform(name))) for name in solids.ARCHIMEDEAN[seed % 3 :: 3])
    elif family == "domes":
        yield from ((f"{f}V", *dome(f)) for f in range(2, 9))
    elif family == "scans":
        for n in SCANS:
            surface = HarmonicSurface(degree=4, order=2, amplitude=0.15)
            yield f"scan, {n} vertices", *triangulate(surface, n, irregular=seed)
    else:
        for surface in (KerrHorizon(spin=0.8), HarmonicSurface(degree=3, order=2, amplitude=0.08)):
            yield f"{surface.name}, seed {seed}", *triangulate(surface, 400, irregular=seed)


FAMILIES = (
    *(f"rocks {roughness}" for roughness in ROUGHNESSES),
    *("Johnson solids", "Archimedean solids", "domes", "scans", "horizons"),
)


def answer(metric, sigma, told):
    """What the package says, and its error."""
    try:
        return embed(metric, length_errors=sigma) if told else embed(metric)
    except NotEmbedded as failure:
        return failure.embedding


def measured(true, faces, digits, question, seed):
    """One surface: its status, ratio, distance, whether it is crumpled, and what is inside two sigma."""
    true = true * (SIZE / np.linalg.norm(true - true.mean(axis=0), axis=1).max())
    exact = PolyhedralMetric.from_mesh(true, faces)
    unit = 10.0 ** (np.floor(np.log10(exact.lengths.max())) - digits + 1)
    sigma = unit / np.sqrt(12)
    if question == "gaussian":
        lengths = exact.lengths + sigma * np.random.default_rng(seed).standard_normal(exact.lengths.shape)
    else:
        lengths = np.round(np.rint(exact.lengths / unit) * unit, max(digits, 12))
    fallen = {"ratio": np.inf, "off": np.inf, "crumpled": True, "other": False, "inside": [False] * 3}
    try:
        metric = PolyhedralMetric(exact.faces, lengths, exact.edges)
        found = answer(metric, sigma, question != "rounded")
    except (InvalidMetric, InvalidParameter) as failure:
        return {"status": type(failure).__name__, **fallen}
    best = least_squares_surface(exact.edges, lengths, true, sigma)
    off, floor = farthest(found.vertices, true), farthest(best, true)
    as_true, as_best = (
        Embedding(exact, x, method="aim", tolerance=1.0).surface.fine_roughness for x in (true, best)
    )
    roughness = found.surface.fine_roughness
    inside = None
    if found.length_errors is not None:
        stated = isoembed.Sensitivity(found).integral_deviation(found.length_errors)
        now, then = integrals(faces, found.vertices), integrals(faces, true)
        inside = [abs(abs(now[name]) - abs(then[name])) <= 2 * getattr(stated, name) for name in then]
        if not stated.volume_is_determined:
            inside[1] = np.nan
    return {
        "status": found.status,
        "ratio": off / floor,
        "off": off,
        "crumpled": bool(roughness > 2 * max(as_true, as_best) + 1e-9),
        "other": bool(off > MOST * floor and found.converged and roughness <= 1.05 * as_true),
        "inside": inside,
    }


def table(family, options):
    """Measure a family, and print its line for each question and number of digits."""
    wrong = 0
    for digits in options.digits:
        for question in options.questions:
            rows = []
            for seed in range(options.seeds):
                for name, true, faces in bodies(family, seed):
                    if len(true) > options.most:
                        continue
                    row = measured(true, faces, digits, question, seed)
                    rows.append(row)
                    if options.each:
                        print(
                            f"  {name:28} {row['status']:16} {row['off']:8.2g} {row['ratio']:8.2f}",
                            flush=True,
                        )
            if not rows:  # all are larger than asked for
                continue
            ratios = np.array([row["ratio"] for row in rows])
            median, most = np.median(ratios), np.quantile(ratios, 0.95, method="higher")
            crumpled, other = (sum(row[name] for row in rows) for name in ("crumpled", "other"))
            stated = [row["inside"] for row in rows if row["inside"] is not None]
            known = np.ma.masked_invalid(stated or [[np.nan] * 3])
            inside = 100 * known.mean(axis=0).filled(np.nan)
            statuses = ", ".join(f"{n} {name}" for name, n in Counter(r["status"] for r in rows).items())
            print(
                f"{family:18} {digits} digits {question:9} {len(rows):3d}: median {median:8.2f}, "
                f"95 % {most:8.2f}, crumpled {crumpled:2d}, other {other:2d}; inside "
                f"{inside[0]:3.0f} {inside[1]:3.0f} {inside[2]:3.0f} %; {statuses}",
                flush=True,
            )
            wrong += (median > MEDIAN) + (most > MOST) + (crumpled > 0)
            if len(stated) >= STATED:
                most_inside = 99 if question == "gaussian" else 100
                wrong += sum(not 90 <= share <= most_inside for share in inside)
    return wrong


def main():
    """Run what is asked."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--families", nargs="+", choices=FAMILIES, default=FAMILIES, metavar="NAME")
    parser.add_argument("--digits", nargs="+", type=int, default=list(range(2, 10)), metavar="N")
    parser.add_argument("--questions", nargs="+", default=["rounded", "given", "gaussian"], metavar="NAME")
    parser.add_argument("--seeds", type=int, default=1, metavar="N")
    parser.add_argument("--most", type=int, default=700, metavar="N", help="vertices at most")
    parser.add_argument("--each", action="store_true", help="print a line for each surface")
    options = parser.parse_args()
    start = time.process_time()
    wrong = sum(table(family, options) for family in options.families)
    print(f"{time.process_time() - start:.0f} s; {wrong} numbers are not as they should be")


if __name__ == "__main__":
    main()
