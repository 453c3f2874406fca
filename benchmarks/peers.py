"""geometry-central's convex embedding and ours in one run: sizes, and inputs that are degenerate.

    python benchmarks/peers.py [--sizes N ...] [--seeds N] [--folder FOLDER] [--json FILE]

geometry-central (Crane, Gillespie and others, MIT) is in the source distribution of potpourri3d, which pip
downloads into the folder; the files of it that the embedding needs are compiled there, with SuiteSparse where
it is installed, and linked to ``peers_embed_convex.cpp``.  Where there is no compiler or no such source, the
reason is printed, and ours alone is measured.

Sizes: hulls of N Fibonacci points on the (3, 2, 1) ellipsoid, on their own triangles.  Seconds are of the
processor, without reading, and ours without compiling; the least of three up to 20,000 vertices.  Memory is
the peak of the process, ours with Python.  geometry-central runs with its own tolerances and with tight ones.

Degenerate inputs: a few bodies, and random ones of `convex_families`.  Both get the same triangles and
lengths.  An answer is right if no vertex is farther from the discarded coordinates than 1e-6 of the diameter
after the best rigid motion; a success that is not is *wrong*, *failed* is what is reported or refused, and
*ended* what crashes or takes more than LIMIT seconds.  Of geometry-central the best of three tolerances
counts.
"""

import argparse
import json
import os
import resource
import shutil
import subprocess
import sys
import tarfile
import tempfile
from pathlib import Path

import numpy as np

import convex_families
from alexandrov import ONE_THREAD, fibonacci, outward_hull
from convex_cases import Case, rounded_lengths, twins_of
from convex_check import distance
from convex_sweep import metric_of

SOURCE = "potpourri3d==1.4.0"
ROOT = "potpourri3d-1.4.0/deps"
SOURCES = {
    "surface": """embed_convex simple_idt surface_mesh manifold_surface_mesh base_geometry_interface
        intrinsic_geometry_interface surface_point edge_length_geometry mutation_manager normal_coordinates
        intrinsic_triangulation integer_coordinates_intrinsic_triangulation common_subdivision
        trace_geodesic intrinsic_mollification""",
    "numerical": "square_solvers linear_algebra_utilities suitesparse_utilities",
    "utilities": "utilities disjoint_sets elementary_geometry",
}
"""What the embedding needs; the linker leaves out the rest of them."""
FLAGS = ["-std=c++14", "-O3", "-DNDEBUG", "-DNOMINMAX", "-D_USE_MATH_DEFINES", "-ffunction-sections"]
SUITESPARSE = Path("/usr/include/suitesparse")

SIZES = (3226, 12800, 51200)
OWN, TIGHT = (0.0, 0.0), (1e-12, 1e-12)  # of angles about radii, and by which edges may be concave
TRIED = ((1e-8, 1e-3), (1e-8, 1e-8), OWN)  # on degenerate inputs: the best answer counts
RIGHT = 1e-6
LIMIT = 2  # seconds of the processor, of degenerate inputs
STATES = ("found", "failed", "wrong", "ended")
FAMILIES = (
    *("hulls", "flipped", "flat vertices", "polygons", "needles", "slabs", "caps", "near", "stacked"),
    "tetrahedra",
)


class NotBuilt(Exception):  # noqa: N818
    """geometry-central is not here; the message says why."""


def built(folder):
    """The program that runs geometry-central, downloaded and compiled if it is not there yet."""
    program = folder / "embed_convex"
    if program.exists():
        return program
    compiler = shutil.which("g++") or shutil.which("c++")
    if compiler is None:
        raise NotBuilt("there is no C++ compiler")
    folder.mkdir(parents=True, exist_ok=True)
    if not (folder / ROOT).exists():
        download = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps", "--no-binary", ":all:"]
        done = subprocess.run([*download, "-d", str(folder), SOURCE], capture_output=True, text=True)
        if done.returncode:
            raise NotBuilt(f"pip cannot download {SOURCE}: {done.stderr.strip().splitlines()[-1]}")
        with tarfile.open(next(folder.glob("potpourri3d*.tar.gz"))) as archive:
            archive.extractall(folder, filter="data")
    deps = folder / ROOT
    inner = ("geometry-central/include", "eigen", *(f"geometry-central/deps/{name}" for name in
             ("happly", "nanort/include", "nanoflann/include")))  # fmt: skip
    flags, libraries = [*FLAGS, *(f"-I{deps / name}" for name in inner)], []
    if SUITESPARSE.exists():
        flags += ["-DGC_HAVE_SUITESPARSE", f"-I{SUITESPARSE}"]
        libraries = ["-lumfpack", "-lcholmod", "-lspqr", "-lsuitesparseconfig"]
    sources = [
        deps / "geometry-central/src" / room / f"{name}.cpp"
        for room, names in SOURCES.items()
        for name in names.split()
    ]
    objects = []
    for source in (*sources, Path(__file__).with_name("peers_embed_convex.cpp")):
        objects.append(folder / f"{source.stem}.o")
        if not objects[-1].exists():
            run_compiler([compiler, *flags, "-c", str(source), "-o", str(objects[-1])])
    run_compiler([compiler, *map(str, objects), "-Wl,--gc-sections", *libraries, "-o", str(program)])
    return program


def run_compiler(command):
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        told = done.stderr.splitlines() or ["without a word"]
        raise NotBuilt(f"it does not compile: {next((line for line in told if 'error' in line), told[-1])}")


def limited(command, seconds):
    """Run a command with a limit of processor time: its output, None if it ended badly, and its peak, MB."""

    def limit():
        if seconds:
            resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + 1))

    with tempfile.TemporaryFile("w+") as output:
        process = subprocess.Popen(
            command, stdout=output, stderr=subprocess.DEVNULL, env=ONE_THREAD, preexec_fn=limit
        )
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        output.seek(0)
        text = output.read()
    return (text if process.returncode == 0 else None), usage.ru_maxrss / 1024


def theirs(program, case, tolerances, seconds=0):
    """Run geometry-central: a row."""
    with tempfile.TemporaryDirectory() as folder:
        given, found = Path(folder, "given"), Path(folder, "found")
        tables = (np.array([len(case.faces)]), case.faces, twins_of(case))
        given.write_bytes(
            b"".join(table.astype(np.int64).tobytes() for table in tables) + case.lengths.tobytes()
        )
        text, peak = limited([str(program), str(given), str(found), *map(str, tolerances)], seconds)
        if text is None:
            return {"status": "ended", "mb": peak}
        success, taken = text.split("\n")[-2].split()
        row = {"status": "failed", "seconds": float(taken), "mb": peak}
        return row | judged(case, np.fromfile(found).reshape(-1, 3)) if int(success) else row


def ours(case):
    """Embed: a row."""
    import isoembed

    start = resource.getrusage(resource.RUSAGE_SELF).ru_utime
    row = {"status": "failed"}
    try:
        found = isoembed.embed(metric_of(case), method="alexandrov")
    except (isoembed.NotEmbedded, isoembed.InvalidMetric) as error:
        row["message"] = str(error)
    row["seconds"] = resource.getrusage(resource.RUSAGE_SELF).ru_utime - start
    row["mb"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    return row if "message" in row else row | judged(case, found.vertices)


def judged(case, vertices):
    """How far a success is from the truth: vertices over the diameter, true edges over their mean."""
    off = distance(vertices, case.points) if np.isfinite(vertices).all() else np.inf
    row = {"status": "found" if off <= RIGHT else "wrong", "off": off}
    if case.core is not None:
        ends = np.concatenate([case.core[1][:, [k, k - 2]] for k in range(3)])
        true, own = (np.linalg.norm(p[ends[:, 0]] - p[ends[:, 1]], axis=1) for p in (case.points, vertices))
        row["edges"] = float(np.abs(own - true).max() / true.mean())
    return row


def on_own_triangles(points, faces, core=None):
    """A body as a case."""
    return Case(faces, None, rounded_lengths(points, faces), points, core or (points, faces))


def sized(n):
    return on_own_triangles(*outward_hull(fibonacci(n)))


def gridded(n, height):
    """A box whose faces are n x n squares, each cut in two, and its triangles; flat if it has no height."""
    steps = np.linspace(0.0, 1.0, n + 1)
    sides = []
    for axis in range(3):
        for level in (0.0, 1.0):
            u, v = np.meshgrid(steps, steps, indexing="ij")
            square = np.insert(np.stack([u.ravel(), v.ravel()], axis=1), axis, level, axis=1)
            place = np.arange((n + 1) ** 2).reshape(n + 1, n + 1)
            a, b, c, d = place[:-1, :-1], place[1:, :-1], place[1:, 1:], place[:-1, 1:]
            faces = np.concatenate([np.stack([x.ravel() for x in t], axis=1) for t in ((a, b, c), (a, c, d))])
            sides.append((square, faces if (level > 0) == (axis != 1) else faces[:, ::-1]))
    points = np.concatenate([square for square, _ in sides])
    faces = np.concatenate([f + k * (n + 1) ** 2 for k, (_, f) in enumerate(sides)])
    unique, place = np.unique(np.round(points, 9), axis=0, return_inverse=True)
    return unique * [1.0, 1.0, height], place.ravel()[faces]


def bodies():
    """Degenerate inputs by their names."""
    yield "cube, its faces of 10 x 10 squares", on_own_triangles(*gridded(10, 1.0))
    yield "slab 100 : 100 : 1, likewise", on_own_triangles(*gridded(10, 0.01))
    yield (
        "needle 100 : 1 : 1, 1,000 vertices",
        on_own_triangles(*outward_hull(fibonacci(1000, (100.0, 1.0, 1.0)))),
    )
    small, faces = outward_hull(fibonacci(1000))
    for unit in (1e-3, 1e-6):
        yield f"(3, 2, 1) ellipsoid in a unit of {unit:.0e}", on_own_triangles(small * unit, faces)


def sizes_table(program, sizes):
    """Measure and print the table of sizes."""
    rows = []
    print(f"{'':>8} {'':24} {'':8} {'CPU s':>8} {'edges':>8} {'vertices':>8} {'peak MB':>8}")
    for n in sizes:
        case, times = sized(n), 3 if n <= 20_000 else 1
        runs = {"ours": [ours_alone(n) for _ in range(times)]}
        if program:
            for name, tolerances in (("geometry-central", OWN), ("geometry-central, tight", TIGHT)):
                runs[name] = [theirs(program, case, tolerances) for _ in range(times)]
        for name, tried in runs.items():
            row = min(tried, key=lambda row: row.get("seconds", np.inf))
            rows.append({"vertices": n, "who": name, **row})
            numbers = [row.get(key, np.nan) for key in ("seconds", "edges", "off", "mb")]
            print(f"{n:8d} {name:24} {row['status']:8}", "{:8.2f} {:8.0e} {:8.0e} {:8.0f}".format(*numbers))
    return rows


def ours_alone(n):
    """Our row of this size, from a process of its own."""
    done = subprocess.run(
        [sys.executable, __file__, "--row", str(n)],
        check=True,
        capture_output=True,
        text=True,
        env=ONE_THREAD,
    )
    return json.loads(done.stdout)


def best_of_theirs(program, case):
    """What geometry-central comes to with the tolerances that suit it best."""
    answers = []
    for tolerances in TRIED:
        answers.append(theirs(program, case, tolerances, LIMIT)["status"])
        if answers[-1] == "found":
            break
    return min(answers, key=("found", "wrong", "failed", "ended").index)


def degenerate_table(program, seeds):
    """Run and print the degenerate inputs."""
    rows = []
    cases = [(name, [case]) for name, case in bodies()]
    cases += [(name, [convex_families.make(name, seed) for seed in range(seeds)]) for name in FAMILIES]
    heading = " ".join(f"{state:>7}" for state in STATES)
    print(f"\n{'':42} {'ours':^31}   {'geometry-central':^31}")
    print(f"{'':36} inputs {heading}   {heading}")
    for name, some in cases:
        found = {"ours": [ours(case)["status"] for case in some]}
        found["theirs"] = [best_of_theirs(program, case) for case in some] if program else []
        rows.append({"inputs": name, "count": len(some), **found})
        counts = "   ".join(" ".join(f"{found[who].count(s):7d}" for s in STATES) for who in found)
        print(f"{name:36} {len(some):6d} {counts}", flush=True)
    return rows


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--sizes", type=int, nargs="*", default=SIZES)
    parser.add_argument("--seeds", type=int, default=10, help="random bodies of each family")
    parser.add_argument(
        "--folder", type=Path, default=Path("build/peers"), help="where geometry-central is built"
    )
    parser.add_argument("--json", type=Path)
    parser.add_argument("--row", type=int, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.row:
        ours(sized(200))  # compiles
        ours(sized(options.row))
        print(json.dumps(ours(sized(options.row))))
        return
    try:
        program = built(options.folder.resolve())
        print(f"geometry-central from {SOURCE}, {'with' if SUITESPARSE.exists() else 'without'} SuiteSparse")
    except NotBuilt as why:
        program = None
        print(f"geometry-central is NOT MEASURED: {why}")
    rows = sizes_table(program, options.sizes) + degenerate_table(program, options.seeds)
    if options.json:
        options.json.write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
