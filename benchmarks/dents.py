"""Which surfaces with dents are found: spheres and ellipsoids with dimples, and dimples like one case.

    python benchmarks/dents.py [--vertices N ...] [--dimples COUNT] [--every K [--first I]] [--seed SEED]
                               [--json FILE]

Dimples: spheres and ellipsoids of axes 1.5, 1.2 and 1 with 1 to 5 dimples of three depths, for each number of
vertices.  A dimple at the direction c takes ``d exp((u . c - 1) / w^2)`` of the distance of the points at u
from the center; w is .3, the depth d is .5, .75 and 1 times w, and centers are 4 w apart or more.  Every
other mesh is irregular.

Like one case: COUNT spheres of 700 vertices, irregular, with a dimple in a random place, w from .3 to .5 and
d from .5 to 1.1 times w.  With --every only each K-th of either family is tried, from the I-th.

Printed are, for each surface, the dimples, the vertices, those with a negative deficit, what was found, the
residual, the distance to the surface that the lengths were taken from over the diameter ("aligned"), and the
same outside of the dimples, factorizations, seconds of the processor, and the other realizations.  What was
found is

    same      the surface,
    neighbor  one within a thousandth of the diameter,
    mirrored  one that is as near outside of the dimples, with some of these reflected,
    other     another surface with these lengths,
    NONE      no surface with these lengths, to 1e-9 of the mean edge length.
"""

import argparse
import json
import time
from collections import Counter
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

import numpy as np

from isoembed import NotEmbedded, PolyhedralMetric, embed
from isoembed.gallery import triangulate
from isoembed.gallery.mapped import MappedSurface
from isoembed.metric.curvature import negative_deficits
from stages import aligned

BODIES = {"sphere": (1.0, 1.0, 1.0), "ellipsoid": (1.5, 1.2, 1.0)}
WIDTH = 0.3
DEPTHS = (0.5, 0.75, 1.0)  # widths
APART = 4.0  # widths
REACH = 3.0  # widths, of a dimple: beyond, less than a hundredth of its depth is left
EXACT, SAME, NEAR = 1e-9, 1e-6, 1e-3


@dataclass(frozen=True)
class Dimpled(MappedSurface):
    """An ellipsoid with dimples: x = f(u) A u with f = 1 - sum d exp((u . c - 1) / w^2)."""

    axes: tuple
    centers: tuple
    depth: float
    width: float
    name = "dimpled"

    def __post_init__(self):
        pass  # no options that are to be checked

    @property
    def _unit(self):
        return 1.0

    def _factor(self, u):
        """F, its gradient and its second derivatives."""
        c, w2 = np.array(self.centers), self.width**2
        e = self.depth * np.exp((u @ c.T - 1) / w2)
        return 1 - e.sum(axis=1), -(e / w2) @ c, -np.einsum("nk,ki,kj->nij", e / w2**2, c, c)

    def _points(self, u):
        return self._factor(u)[0][:, None] * u * self.axes

    def _differential(self, u):
        f, gradient, _ = self._factor(u)
        return np.array(self.axes)[:, None] * (
            f[:, None, None] * np.eye(3) + u[:, :, None] * gradient[:, None, :]
        )

    def _second_differential(self, u, normals):
        _, gradient, hessian = self._factor(u)
        m = normals * self.axes
        mixed = m[:, :, None] * gradient[:, None, :]
        return mixed + mixed.transpose(0, 2, 1) + np.einsum("ni,ni->n", m, u)[:, None, None] * hessian

    def beyond_dimples(self, vertices):
        """Which points are farther from all centers than the dimples reach."""
        u = vertices / self.axes
        u /= np.linalg.norm(u, axis=1)[:, None]
        return (u @ np.array(self.centers).T < np.cos(REACH * self.width)).all(axis=1)


def directions(rng, count, apart):
    """Random directions with these angles between them at least."""
    while True:
        found = []
        for _ in range(100):
            u = rng.standard_normal(3)
            u /= np.linalg.norm(u)
            if all(u @ other < np.cos(apart) for other in found):
                found.append(tuple(u))
            if len(found) == count:
                return tuple(found)


def dimples(sizes, seed):
    """Bodies with 1 to 5 dimples of three depths; name, surface, vertices, seed of an irregular mesh."""
    rng = np.random.default_rng(seed)
    number = 0
    for n in sizes:
        for body, axes in BODIES.items():
            for count in range(1, 6):
                for depth in DEPTHS:
                    centers = directions(rng, count, APART * WIDTH)
                    surface = Dimpled(axes, centers, depth * WIDTH, WIDTH)
                    yield f"{body}, {count} x {depth:g}", surface, n, number if number % 2 else None
                    number += 1


def like_the_case(count, seed):
    """Spheres with one dimple."""
    rng = np.random.default_rng(seed + 1)
    for number in range(count):
        width = rng.uniform(0.3, 0.5)
        depth = rng.uniform(0.5, 1.1)
        surface = Dimpled(BODIES["sphere"], directions(rng, 1, 0.0), depth * width, width)
        yield f"case, w {width:.2f}, {depth:.2f}", surface, 700, number


def measured(surface, n, irregular):
    """Embed the lengths of a mesh; what it took and what came of it."""
    true, faces = triangulate(surface, n, irregular=irregular)
    metric = PolyhedralMetric.from_mesh(true, faces)
    start = time.process_time()
    try:
        found = embed(metric)
    except NotEmbedded as failure:
        found = failure.embedding
    seconds = time.process_time() - start
    off, beyond = float(aligned(found.vertices, true)), surface.beyond_dimples(true)
    outside = float(aligned(found.vertices[beyond], true[beyond]))
    verdict = "other"
    if found.residual > EXACT:
        verdict = "NONE"
    elif off < SAME:
        verdict = "same"
    elif off < NEAR:
        verdict = "neighbor"
    elif outside < NEAR:
        verdict = "mirrored"
    return {
        "negative": int(negative_deficits(metric).sum()),
        "found": verdict,
        "residual": found.residual,
        "aligned": off,
        "outside": outside,
        "factorizations": sum(stage.factorizations for stage in found.stages),
        "seconds": seconds,
        "others": len(found.others),
        "stages": {stage.name: (stage.factorizations, stage.seconds) for stage in found.stages},
    }


HEADER = (
    f"{'':22} {'N':>5} {'neg.':>5} {'found':8} {'residual':>8} {'aligned':>8} {'outside':>8} "
    f"{'fact.':>5} {'seconds':>8} {'others':>6}"
)


def table(cases):
    """Measure and print, surface by surface, with a line of counts at the end."""
    print(f"\n{HEADER}")
    rows = []
    for name, surface, n, irregular in cases:
        row = {"name": name, "vertices": n, "irregular": irregular, **measured(surface, n, irregular)}
        rows.append(row)
        print(
            f"{name:22} {n:5d} {row['negative']:5d} {row['found']:8} {row['residual']:8.0e} "
            f"{row['aligned']:8.0e} {row['outside']:8.0e} {row['factorizations']:5d} {row['seconds']:8.1f} "
            f"{row['others']:6d}",
            flush=True,
        )
    found = Counter(row["found"] for row in rows)
    good = found["same"] + found["neighbor"] + found["mirrored"]
    times = {
        kind: [row["seconds"] for row in rows if (row["found"] == "NONE") == (kind == "failures")]
        for kind in ("successes", "failures")
    }
    medians = ", ".join(f"{kind} {np.median(t):.1f} s" for kind, t in times.items() if t)
    print(f"{good} of {len(rows)}: {dict(found)}; median of {medians}")
    return rows


def main():
    """Run what is asked."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--vertices", type=int, nargs="*", default=[1000, 2000, 3000], metavar="N")
    parser.add_argument("--dimples", type=int, default=200, metavar="COUNT")
    parser.add_argument("--every", type=int, default=1, metavar="K")
    parser.add_argument("--first", type=int, default=0, metavar="I")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--json", type=Path, metavar="FILE")
    options = parser.parse_args()
    rows = []
    for n in options.vertices:
        rows += table(islice(dimples([n], options.seed), options.first, None, options.every))
    if options.dimples:
        alike = like_the_case(options.dimples, options.seed)
        rows += table(islice(alike, options.first, None, options.every))
    if options.json:
        options.json.write_text(json.dumps(rows, indent=1))


if __name__ == "__main__":
    main()
