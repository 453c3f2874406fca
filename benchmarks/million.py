"""The default method from 10,000 vertices to a million, through the command: files in, files out.

    python benchmarks/million.py [--sizes N ...] [--threads T ...] [--only PART ...] [--meshes DIR]
                                 [--json FILE]

Parts: "sizes", the paper's ellipsoid and drum in nearly equilateral, unstructured triangles; "poor", the
ellipsoid at 40,000 vertices in triangles whose least angle is a hundredth of a degree (vertices strewn at
random) and in triangles squeezed 10 : 1.

Every row is one run of ``isoembed embed`` in a process of its own, from a metric in a file to a surface and a
report in files: seconds of the processor and of the clock, start-up, input and output among them; the peak of
memory; what the stages took and their factorizations; the largest edge error, the distance to the discarded
coordinates over the diameter, and the inverted vertices.  "one" is the time of the processor for one numeric
factorization of J J^T, the edges x edges matrix of Newton's method on the lengths, at the surface (not above
--most edges).  After a row of "sizes" stand the seconds of one numeric factorization of ``-d kappa / d r``,
the vertices x vertices matrix of Newton's method on the radii, what the run takes over that, the least
seconds of runs that write no report, and which limits these miss: 1.2 s for the ellipsoid at 51,200 vertices,
45 s and 3 GB at a million, 45 s for the drum at 640,000, and edge errors of 1e-12.  Stages are in seconds of
the clock.  The exponent is that of the processor's seconds, from 40,000 to 640,000 vertices.  With --meshes,
meshes made once are kept in a folder.
Surfaces where K < 0 are those of ``bent.py``.
"""

import argparse
import json
import tempfile
from functools import partial
from pathlib import Path

import numpy as np

from command_runs import HEAD, exponent, kept_mesh, least_without_report, measure, one_in_own_process, show
from isoembed.gallery import Drum, Ellipsoid, triangulate

POOR = 40_000
SURFACES = {
    "ellipsoid": lambda n: triangulate(Ellipsoid((3, 2, 1)), n),
    "drum": lambda n: triangulate(Drum(), n),
    "random": lambda n: strewn(n),
    "squeezed": lambda n: squeezed(n),
}
PARTS = ("sizes", "poor")
LIMITS = {
    ("ellipsoid", 51_200): (1.2, None),
    ("ellipsoid", 1_000_000): (45, 3072),
    ("drum", 640_000): (45, None),
}
"""Seconds of the processor and MB."""
EXACT = 1e-12


def strewn(n):
    """Points of the ellipsoid that know nothing of one another, in the triangles of their sphere's hull."""
    from scipy.spatial import ConvexHull

    u = np.random.default_rng(0).normal(size=(n, 3))
    u /= np.linalg.norm(u, axis=1)[:, None]
    faces = ConvexHull(u).simplices.astype(np.int64)
    inward = np.linalg.det(u[faces]) < 0
    faces[inward] = faces[inward][:, ::-1]
    return u * [3.0, 2.0, 1.0], faces


def squeezed(n):
    """Good triangles of a long ellipsoid, pressed together along it."""
    vertices, faces = triangulate(Ellipsoid((3, 2, 10)), n)
    return vertices * [1.0, 1.0, 0.1], faces


def remark(name, row):
    """What one factorization on the vertices takes, and the limits that are missed."""
    seconds, memory = LIMITS.get((name, row["n"]), (None, None))
    said = f"  N x N {row['n_by_n']:.2f}, cpu / N x N {row['cpu'] / row['n_by_n']:.1f}"
    said += f", without report {row['bare']:.2f}"
    if seconds:
        said += f", asked {seconds:g} s" + (" (missed)" if row["bare"] > seconds else "")
    if memory:
        said += f", {memory} MB" + (" (missed)" if row["peak"] > memory else "")
    return said + (f", {EXACT:g} (missed)" if not row["residual"] <= EXACT else "")


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--sizes", type=int, nargs="+", default=(10_000, 40_000))
    parser.add_argument("--threads", type=int, nargs="+", default=(1,))
    parser.add_argument("--only", nargs="+", choices=PARTS, default=PARTS)
    parser.add_argument("--most", type=int, default=2_000_000, help="edges, for the column one")
    parser.add_argument("--meshes", type=Path, help="where to keep meshes")
    parser.add_argument("--json", type=Path, help="write the rows to this file")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        folder = arguments.meshes or Path(scratch)
        folder.mkdir(parents=True, exist_ok=True)
        wanted = [("sizes", name, arguments.sizes) for name in ("ellipsoid", "drum")]
        wanted += [("poor", name, (POOR,)) for name in ("random", "squeezed")]
        rows = []
        print(HEAD, flush=True)
        for part, name, sizes in wanted:
            if part not in arguments.only:
                continue
            for threads in arguments.threads:
                batch = []
                for n in sizes:
                    path = kept_mesh(folder / f"{name}_{n}.npz", partial(SURFACES[name], n))
                    batch.append({"name": name, **measure(path, arguments.most, threads)})
                    if part == "sizes" and "failed" not in batch[-1]:
                        batch[-1]["n_by_n"] = one_in_own_process(path, threads, "vertices")
                        batch[-1]["bare"] = least_without_report(path, threads)
                    show(name, batch[-1], remark(name, batch[-1]) if "n_by_n" in batch[-1] else "")
                if (slope := exponent(batch)) is not None:
                    print(f"{name}, {threads} thread(s): exponent {slope:.2f}", flush=True)
                rows += batch
    if arguments.json:
        arguments.json.write_text(json.dumps(rows, indent=1))


if __name__ == "__main__":
    main()
