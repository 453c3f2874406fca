"""What is realized, and at what cost: the cases of a folder, and surfaces of the gallery where K < 0.

    python benchmarks/realizations.py [--cases DIR --truth DIR] [--gallery N ...] [--paper [N]]
                                      [--limit SECONDS] [--command] [--json FILE]

Cases: in the one folder ID.npz or ID.json with faces, edges and lengths; in the other ID.npz with coords, the
vertices that the lengths were taken from, and ID.json with meta.kind, meta.group and meta.ambiguous.  Those
are measured that are to be realized on the given triangles.  Gallery: with so many vertices each, regular and
irregular.

Printed are the vertices, those with a negative deficit, whether the default method solved the case (to its
tolerance, 1e-10 of the mean edge length), its factorizations by the size of the matrix, N for vertices and E
for edges (waypoint N, polytope N, Newton's method E, guided pull-back 3N, whatever else a failure calls for,
and all of them), seconds, the largest residual, the distance to the discarded coordinates over the diameter
("aligned"; in brackets where another realization is as good), concave edges, inverted and partially inverted
vertices, rough edges, and how many other realizations were met.  With --paper the same beside it for
method="paper", asked for the same tolerance, on cases of at most so many vertices; it is ended after --limit
seconds.  Last come summaries by class, and every case that is not solved, not aligned, or above its limit of
factorizations.

--command times the command on the ellipsoid of 3,226 vertices, start-up included, against 15 factorizations
of its J J^T (with their solves) plus one second.
"""

import argparse
import json
import multiprocessing
import shutil
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from itertools import chain
from pathlib import Path

import numpy as np

from isoembed import NotEmbedded, PolyhedralMetric, embed
from isoembed.gallery import (
    Bean,
    BentTube,
    CassiniPeanut,
    Ellipsoid,
    Ergosphere,
    HarmonicSurface,
    Sphere,
    triangulate,
)
from isoembed.io import read_metric, write_metric
from isoembed.metric.curvature import negative_deficits
from stages import aligned, one_factorization

KINDS = (
    *("unique-convex", "unique-convex-flatfaces", "inscribed", "inscribed-nonconvex", "metric-only"),
    *("star-nonconvex", "nearly-convex", "nearly-convex-rough", "nonconvex"),
)
"""Of the cases that are to be realized on the given triangles; the second row has real shapes."""

SMOOTH = ("smooth-nonconvex", "ergosphere")
"""Groups of cases on smooth surfaces with K < 0 somewhere."""

GALLERY = {
    **{f"ergosphere {epsilon}": Ergosphere(epsilon=epsilon) for epsilon in (0.5, 0.3, 0.1, 0.05, 0.02)},
    "peanut": CassiniPeanut(),
    "saddle": HarmonicSurface(degree=2, order=2, amplitude=0.35),
    "trefoil": HarmonicSurface(degree=3, order=3, amplitude=0.3),
    "y43": HarmonicSurface(degree=4, order=3, amplitude=0.12178),
    "cell": HarmonicSurface(degree=2, order=2, amplitude=0.26),
    "bean": Bean(),
    "tube": BentTube(),
}

MATRICES = {
    "waypoint": ("waypoint",),
    "polytope": ("polytope",),
    "newton": ("pull back", "polish", "neighbors"),
    "guided": ("guided pull back",),
}
"""The stages of the default method that factor each kind of matrix."""

CONVEX, NEARLY, NEGATIVE, ROUGH = "convex", "nearly convex", "smooth, K < 0", "rough"
LIMITS = {CONVEX: 8, NEARLY: 30, NEGATIVE: 40, ROUGH: np.inf}
"""Most factorizations of a class: of those in N, or of those in E, where it is convex; else in all."""

SOLVED = 1e-9  # mean edge lengths
ALIGNED = 1e-6  # diameters
ELLIPSOID = 3226  # vertices, the paper's
ROUNDS = 8  # of which the least counts; the first may compile


@dataclass(frozen=True)
class Case:
    """A metric, and the coordinates that its lengths were taken from, if they were."""

    name: str
    metric: PolyhedralMetric
    true: np.ndarray | None
    ambiguous: bool
    of: str

    @property
    def vertices(self):
        return self.metric.triangulation.n_vertices


def from_folder(cases, truth):
    """The realizable cases of a folder, by class and size."""
    found = []
    for path in sorted(truth.glob("*.json")):
        meta = json.loads(path.read_text())["meta"]
        files = [file for file in (cases / f"{path.stem}{end}" for end in (".npz", ".json")) if file.exists()]
        if meta["kind"] not in KINDS or not files:
            continue
        metric = read_metric(files[0])
        true = None
        if meta["kind"] != "metric-only":
            with np.load(path.with_suffix(".npz")) as arrays:
                true = arrays["coords"]
        of = ROUGH
        if not negative_deficits(metric).any():
            of = CONVEX
        elif meta["kind"] == "inscribed":
            of = NEARLY
        elif meta["kind"] == "inscribed-nonconvex" and meta["group"] in SMOOTH:
            of = NEGATIVE
        found.append(Case(path.stem, metric, true, meta.get("ambiguous", False), of))
    return sorted(found, key=lambda case: (list(LIMITS).index(case.of), case.vertices))


def from_gallery(sizes):
    """Surfaces of the gallery with so many vertices, regular and irregular, one after the other."""
    for n in sizes:
        for name, surface in GALLERY.items():
            for irregular in (None, 0):
                vertices, faces = triangulate(surface, n, irregular=irregular)
                metric = PolyhedralMetric.from_mesh(vertices, faces)
                full = f"{name}, {n}{'' if irregular is None else ', irregular'}"
                yield Case(full, metric, vertices, False, NEGATIVE)


def measured(metric, true, method):
    """Embed a metric; what it took and what came of it."""
    start = time.perf_counter()
    try:
        surface = embed(metric, method=method)
    except NotEmbedded as failure:
        surface = failure.embedding
    seconds = time.perf_counter() - start
    counts = {
        kind: sum(stage.factorizations for stage in surface.stages if stage.name in names)
        for kind, names in MATRICES.items()
    }
    every = sum(stage.factorizations for stage in surface.stages)
    return {
        "status": surface.status,
        "factorizations": {**counts, "else": every - sum(counts.values()), "all": every},
        "seconds": seconds,
        "residual": surface.residual,
        "aligned": None if true is None else float(aligned(surface.vertices, true)),
        "concave": int(surface.surface.concave_edges.sum()),
        "inverted": int(surface.surface.inverted_vertices.sum()),
        "partially": int(surface.surface.partially_inverted_vertices.sum()),
        "rough": int(surface.surface.rough_edges.sum()),
        "others": len(surface.others),
        "stages": {stage.name: stage.seconds for stage in surface.stages},
    }


def warm_up():
    """Compile, or load what was compiled."""
    for surface in (Sphere(), HarmonicSurface(degree=2, order=2, amplitude=0.35)):
        metric = PolyhedralMetric.from_mesh(*triangulate(surface, 200))
        for method in ("aim", "paper"):
            measured(metric, None, method)


class Limited:
    """A process of its own that is ended, and started anew, where a measurement takes too long."""

    def __init__(self, limit):
        self._limit = limit
        self._pool = None

    def measured(self, *arguments):
        """As `measured`; None where the limit was hit."""
        if self._pool is None:
            self._pool = multiprocessing.get_context("spawn").Pool(1)
            self._pool.apply(warm_up)
        try:
            return self._pool.apply_async(measured, arguments).get(self._limit)
        except multiprocessing.TimeoutError:
            self.close()
            return None

    def close(self):
        if self._pool is not None:
            self._pool.terminate()
            self._pool = None


HEADER = (
    f"{'':36} {'N':>6} {'neg.':>5} {'':6} "
    f"{'way':>4} {'pol':>4} {'New':>4} {'gui':>4} {'else':>4} {'all':>4} "
    f"{'seconds':>8} {'residual':>8} {'aligned':>8} "
    f"{'conc.':>6} {'inv.':>5} {'part.':>5} {'rough':>5} {'others':>6}"
)
PAPER_HEADER = f"  | paper: {'all':>4} {'seconds':>8} {'residual':>8} {'aligned':>8} {'inv.':>5} {'part.':>5}"


def distance(value, case):
    """The distance to the discarded coordinates; in brackets, where they are not the only answer."""
    if value is None:
        return "-"
    return f"({value:.0e})" if case.ambiguous else f"{value:.0e}"


def line(case, row):
    """A line of the table."""
    solved = "solved" if row["status"] == "converged" else "NOT"
    counts = " ".join(f"{count:4d}" for count in row["factorizations"].values())
    return (
        f"{case.name:36} {case.vertices:6d} {row['negative']:5d} {solved:6} {counts} "
        f"{row['seconds']:8.2f} {row['residual']:8.0e} {distance(row['aligned'], case):>8} "
        f"{row['concave']:6d} {row['inverted']:5d} {row['partially']:5d} {row['rough']:5d} {row['others']:6d}"
    )


def paper_columns(case, row, limit):
    """What the table says of method="paper"."""
    if row is None:
        return f"  | paper: ended after {limit:g} s"
    return (
        f"  | {'' if row['status'] == 'converged' else 'NOT':>6} {row['factorizations']['all']:4d} "
        f"{row['seconds']:8.2f} {row['residual']:8.0e} {distance(row['aligned'], case):>8} "
        f"{row['inverted']:5d} {row['partially']:5d}"
    )


def table(cases, paper, limit):
    """Measure and print, case by case."""
    rows, limited, of = [], Limited(limit), None
    for case in cases:
        if case.of != of:
            of = case.of
            print(f"\n{of}\n{HEADER}{PAPER_HEADER if paper else ''}")
        row = {
            "case": case.name,
            "class": case.of,
            "vertices": case.vertices,
            "negative": int(negative_deficits(case.metric).sum()),
            "ambiguous": case.ambiguous,
            **measured(case.metric, case.true, "aim"),
        }
        print(line(case, row), end="", flush=True)
        if case.vertices <= paper:
            row["paper"] = limited.measured(case.metric, case.true, "paper")
            print(paper_columns(case, row["paper"], limit), end="")
        print(flush=True)
        rows.append(row)
    limited.close()
    return rows


def same_size(row):
    """Factorizations of the kind that is counted most: in N, in E, in 3N."""
    counts = row["factorizations"]
    return max(counts["waypoint"] + counts["polytope"], counts["newton"], counts["guided"])


def counted(row):
    """The factorizations that the limit of the row's class is on."""
    return same_size(row) if row["class"] == CONVEX else row["factorizations"]["all"]


def comparable(row):
    """Whether the discarded coordinates are known, and the only answer."""
    return row["aligned"] is not None and not row["ambiguous"]


def outcome(label, rows, ended):
    """A line of the summary: of these rows, those that ended by themselves."""
    solved = sum(row["residual"] <= SOLVED for row in ended)
    near = sum(comparable(row) and row["aligned"] <= ALIGNED for row in ended)
    every = [row["factorizations"]["all"] for row in ended]
    return (
        f"{label:16} {f'{solved} of {len(rows)}':>18} {f'{near} of {sum(map(comparable, rows))}':>18} "
        f"{max(every, default=0):21d} {np.median(every) if every else 0:7.0f}"
    )


def summary(rows):
    """Print what came of each class, and the exceptions."""
    print(f"\n{'':16} {f'residual < {SOLVED:.0e}':>18} {f'aligned < {ALIGNED:.0e}':>18} "
          f"{'factorizations: most':>21} {'median':>7} {'most of one size':>17}")  # fmt: skip
    for of in LIMITS:
        these = [row for row in rows if row["class"] == of]
        if not these:
            continue
        print(f"{outcome(of, these, these)} {max(map(same_size, these)):17d}")
        tried = [row for row in these if "paper" in row]
        ended = [{**row, **row["paper"]} for row in tried if row["paper"]]
        if tried:
            print(f"{outcome('  paper', tried, ended)} {'':17} {len(tried) - len(ended)} ended by the limit")
    print("\nexceptions:")
    for row in rows:
        faults = []
        if row["residual"] > SOLVED:
            faults.append(f"residual {row['residual']:.1e}")
        if comparable(row) and row["aligned"] > ALIGNED:
            faults.append(f"off by {row['aligned']:.1e}")
        if counted(row) > LIMITS[row["class"]]:
            faults.append(f"{counted(row)} factorizations, more than {LIMITS[row['class']]}")
        if faults:
            print(f"{row['class']:14} {row['case']:36} {', '.join(faults)}")


def command():
    """Time the command against factorizations of the same matrix, and print both."""
    metric = PolyhedralMetric.from_mesh(*triangulate(Ellipsoid(), ELLIPSOID))
    program = shutil.which("isoembed", path=str(Path(sys.executable).parent)) or "isoembed"
    surface = embed(metric)
    seconds, ones = [], []
    with tempfile.TemporaryDirectory() as folder:
        given, found = Path(folder, "metric.npz"), Path(folder, "surface.npz")
        write_metric(given, metric)
        for _ in range(ROUNDS):  # in turn, for other work on the machine to slow both or neither
            start = time.perf_counter()
            subprocess.run([program, "embed", given, "--output", found, "--quiet"], check=True)
            seconds.append(time.perf_counter() - start)
            ones.append(one_factorization(metric, surface.vertices))
    one = min(ones)
    print(f"\nthe ellipsoid at {ELLIPSOID} vertices through the command: {min(seconds):.2f} s; "
          f"15 factorizations of {one:.3f} s each and a second: {15 * one + 1:.2f} s")  # fmt: skip
    return {"command": min(seconds), "one": one}


def main():
    """Run what is asked."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--cases", type=Path, metavar="DIR")
    parser.add_argument("--truth", type=Path, metavar="DIR")
    parser.add_argument("--gallery", type=int, nargs="*", default=[700], metavar="N")
    parser.add_argument("--paper", type=int, nargs="?", const=1600, default=0, metavar="N")
    parser.add_argument("--limit", type=float, default=60.0, metavar="SECONDS")
    parser.add_argument("--command", action="store_true")
    parser.add_argument("--json", type=Path, metavar="FILE")
    options = parser.parse_args()
    if (options.cases is None) != (options.truth is None):
        parser.error("--cases and --truth belong together")
    result = {}
    if options.command:
        result |= command()
    warm_up()
    cases = from_folder(options.cases, options.truth) if options.cases else []
    rows = table(chain(cases, from_gallery(options.gallery)), options.paper, options.limit)
    if rows:
        summary(rows)
    if options.json:
        options.json.write_text(json.dumps({**result, "rows": rows}, indent=1))


if __name__ == "__main__":
    main()
