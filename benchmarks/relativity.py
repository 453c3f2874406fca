"""Quasi-local energies against what is known of them, and at what cost.

    python benchmarks/relativity.py [--only PART ...] [--sizes N ...] [--shared DIR] [--json FILE]

Parts.  "smooth": Kerr horizons, ergospheres, surfaces r = const and charged ones by spherical harmonics.  The
references are quadratures in more digits (REFERENCE, "table"), closed forms, and else the surface of
revolution ("revolution", another computation); that of the Brown-York energy on r = const takes int k dA
from the change of the area with r.  Each number stands beside its relative error and the relative error that
was estimated (absolute ones where the reference is 0); "within" says whether the one is at most the other.
"degree": the same with harmonics up to one degree, the factor by which a degree lowers the error of int H dA,
and the power of the degree that this would be.  "mesh": polyhedra, from geodesic lengths and from chords of
the exact embedding, bare and corrected, with the orders in the edge length h (h^2 ~ 1/N), and what the two
finest sizes extrapolate to; the paper's ergosphere against its figure; and which lengths there is a
polyhedron for where K < 0.  "slices": Painleve-Gullstrand spheres, and the horizon of Dunajski and Tod in two
slices.  "files", with --shared: metrics on grids, and a numerical horizon whose distance from the exact one
accounts for its area and its int H dA.  Seconds are those of the processor.
"""

import argparse
import json
import time
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np

from isoembed import NotEmbedded, PolyhedralMetric, embed
from isoembed.meshing.sphere import gauss_rule
from isoembed.relativity import (
    KerrNewmanErgosphere,
    KerrNewmanHorizon,
    KerrNewmanSphere,
    KerrSchild,
    PainleveGullstrand,
    StarSurface,
    SurfaceData,
    embed_surface,
    read_horizon,
    read_metric_grid,
)
from isoembed.smooth import Harmonics, SmoothEmbedding, triangulate_metric
from isoembed.smooth.gauss_newton import gauss_newton
from isoembed.smooth.transforms import resized
from isoembed.smooth.two_metric import area_density, orthonormal_frame
from isoembed.surface.chords import chord_lengths
from isoembed.surface.smooth_integrals import SmoothIntegrals

PARTS = ("smooth", "degree", "mesh", "slices", "files")
SIZES = (500, 1000, 2000, 4000)
DEGREES = (4, 6, 8, 10, 12, 16, 20, 24, 32, 48, 64, 96)
PLAIN = ("seconds", "bare order", "corrected order", "as a power", "falls by, per degree")
SMALL = 0.2  # numbers that are written as errors
ROUNDING = 1e-13
GRADING = 1.0  # of the meshes of ergospheres
PAPER = 0.0062  # relative error of int H dA on the ergosphere, section 3.2 of the paper
ASKED = 1e-4  # of the extrapolated one
EXTREME = np.sqrt(3.0) / 2.0
DUNAJSKI_TOD = 1.76569  # over the mass

REFERENCE = {
    "horizon a=0": (50.265482457436691, 25.132741228718345),
    "horizon a=0.3": (49.107848325860670, 24.844371648046456),
    "horizon a=0.5": (46.898333599528960, 24.300446945608874),
    "horizon a=0.6": (45.238934211693022, 23.898597646410372),
    "horizon a=0.8": (40.212385965949353, 22.730557214111993),
    "horizon a=0.866": (37.699111843077518, 22.188336555767362),
    "ergosphere 0.05": (67.980900896869771, 32.349200545475379),
    "ergosphere 0.1": (68.778813182860604, 31.525077013543588),
    "ergosphere 0.3": (75.306862525500272, 31.554888653253705),
    "ergosphere 0.5": (84.498458825124000, 33.021720529589184),
    "ergosphere 1": (114.17680840964232, 38.104671061790772),
    "ergosphere 1.5": (151.33152478382481, 43.789269646631185),
    "a=0.5 r=3": (115.87029226967145, 38.161871704273792),
    "a=0.5 r=6": (454.82974804253785, 75.601540033348012),
    "a=0.8 r=3": (120.12242026143980, 38.873468325120506),
}
"""Area and int H dA by quadrature in long double, and for ergospheres in fifty digits."""

TILTED = KerrSchild(1.0, (0.0, -0.6 * np.sin(0.4), 0.6 * np.cos(0.4)))
TILTED_FILE = Path("real", "einsteintoolkit", "EinsteinExact_KS-tilted-EE.h.t0.ah1.gp")
TILTED_AREA = 45.12053438  # by AHFinderDirect, in the diagnostics beside that file
GRIDS = {0.5: "kerr_horizon_a0.5_metric_grid.npz", 0.8: "kerr_horizon_a0.8_metric_grid.npz"}


def surfaces():
    """The surfaces of the tables, by name."""
    found = {f"horizon a={a:.3g}": KerrNewmanHorizon(1.0, a) for a in (0.0, 0.3, 0.5, 0.6, 0.8, EXTREME)}
    for epsilon in (0.05, 0.1, 0.3, 0.5, 1.0, 1.5):
        found[f"ergosphere {epsilon:g}"] = KerrNewmanErgosphere(epsilon)
    for a, radii in ((0.0, (3, 4, 6, 10, 100)), (0.5, (3, 6, 10, 100)), (0.8, (3, 6, 10, 100))):
        found |= {f"a={a:g} r={r}": KerrNewmanSphere(float(r), 1.0, a) for r in radii}
    found["horizon a=0.5 Q=0.5"] = KerrNewmanHorizon(1.0, 0.5, 0.5)
    found["a=0.5 Q=0.5 r=3"] = KerrNewmanSphere(3.0, 1.0, 0.5, 0.5)
    return found


def show(title, rows, digits=2):
    """Print dictionaries as a table, with so many digits of small numbers."""
    heads = list(dict.fromkeys(head for row in rows for head in row))
    cells = [[written(head, row.get(head), digits) for head in heads] for row in rows]
    widths = [max(map(len, column)) for column in zip(heads, *cells, strict=True)]
    print(f"\n{title}\n")
    for line in (heads, ["-" * width for width in widths], *cells):
        print("| " + " | ".join(f"{cell:>{width}}" for cell, width in zip(line, widths, strict=True)) + " |")


def written(head, value, digits):
    """A cell: small numbers are errors, and get few digits."""
    if value is None:
        return "-"
    if isinstance(value, bool | np.bool_):
        return "yes" if value else "NO"
    if not isinstance(value, float):
        return str(value)
    if value == 0.0 or head in PLAIN:
        return f"{value + 0.0:g}"
    return f"{value:.{digits - 1}e}" if abs(value) < SMALL else f"{value:.13g}"


def relative(value, reference):
    """The relative error, or the error where the reference is zero."""
    return float(abs(value - reference) / (abs(reference) or 1.0))


def seconds_of(function, *arguments, **options):
    """Seconds of the processor, and the result."""
    start = time.process_time()
    result = function(*arguments, **options)
    return time.process_time() - start, result


def area_change(surface):
    """int k dA on r = const: the derivative of the area element by r, over sqrt(g_rr), by a complex step."""
    x, weights = np.polynomial.legendre.leggauss(200)
    s, a, Q = 1.0 - x * x, surface.spin, surface.charge
    h = 1e-30
    r = surface.r + 1j * h
    sigma = r * r + a * a * x * x
    element = np.sqrt(sigma * (r * r + a * a + a * a * s * (2.0 * surface.mass * r - Q * Q) / sigma))
    delta = r * r - 2.0 * surface.mass * r + a * a + Q * Q
    return 2.0 * np.pi * float(weights @ (element.imag / h * np.sqrt(delta / sigma).real))


def brown_york(surface, imc):
    """The Brown-York energy from int H dA; None where int k dA is not known otherwise."""
    if isinstance(surface, KerrNewmanSphere):
        return (2.0 * imc - area_change(surface)) / (8.0 * np.pi)
    return imc / (4.0 * np.pi) if isinstance(surface, KerrNewmanHorizon) else None


def compared(row, name, estimate, reference):
    """Enter a number, its errors and whether the estimate holds."""
    row[name] = estimate.value
    if reference is None:
        row |= {f"{name} error": None, f"{name} estimated": estimate.error / abs(estimate.value)}
        return
    error, scale = relative(estimate.value, reference), abs(reference) or 1.0
    row |= {f"{name} error": error, f"{name} estimated": float(estimate.error / scale)}
    row["within"] = row.pop("within", True) and bool(abs(estimate.value - reference) <= estimate.error)


def smooth():
    """The smooth route."""
    embed_surface(surfaces()["horizon a=0.3"].data())  # compiles, or loads what was compiled
    shapes, energies = [], []
    for name, surface in surfaces().items():
        seconds, embedded = seconds_of(embed_surface, surface.data())
        found = embedded.energies
        profile = surface.profile()
        area, imc = REFERENCE.get(name, (profile.area, profile.integrated_mean_curvature))
        row = {"surface": name, "against": "table" if name in REFERENCE else "revolution"}
        compared(row, "int H", found.integrated_mean_curvature, imc)
        compared(row, "area", found.area, area)
        row |= {
            "degree": embedded.embedding.harmonics.degree,
            "residual": embedded.embedding.residual,
            "seconds": round(seconds, 1),
        }
        shapes.append(row)
        row = {"surface": name}
        reference = brown_york(surface, imc)
        if surface.spin == 0.0 and isinstance(surface, KerrNewmanSphere):
            reference = surface.r * (1.0 - np.sqrt(1.0 - 2.0 / surface.r))
        compared(row, "Brown-York", found.brown_york, reference)
        if found.liu_yau is not None:
            compared(row, "Liu-Yau", found.liu_yau, reference)
        energies.append(row)
    show("Area and int H dA, by spherical harmonics (mass 1; relative errors)", shapes)
    show("Energies of the same (relative errors; p = 0: Liu-Yau is Brown-York)", energies)
    return {"shapes": shapes, "energies": energies}


def degree():
    """Convergence in the degree."""
    names = ("horizon a=0.5", "horizon a=0.8", "horizon a=0.866", "a=0.8 r=3", "ergosphere 1.5")
    rows = []
    for name in names:
        surface = surfaces()[name]
        whole = embed_surface(surface.data()).embedding
        exact = REFERENCE[name][1]
        before = None
        for L in DEGREES:
            harmonics = Harmonics(L, 1)
            C = gauss_newton(surface, harmonics, resized(whole.coefficients, whole.harmonics, harmonics))
            found = SmoothEmbedding(surface, harmonics, C, np.inf, np.inf)
            error = relative(found.integrated_mean_curvature, exact)
            row = {"surface": name, "degree": L, "residual": found.residual, "int H error": error}
            if before and error > ROUNDING:
                fall = before[1] / error
                row["falls by, per degree"] = round(fall ** (1.0 / (L - before[0])), 2)
                row["as a power"] = round(np.log(fall) / np.log(L / before[0]), 1)
            rows.append(row)
            before = (L, error)
            if error < ROUNDING:
                break
    show("Convergence in the degree: exponential, but for spin sqrt(3)/2, where K = 0 at the poles", rows)
    return rows


def polyhedron(metric):
    """Seconds, and the embedding, whether or not it is one."""
    try:
        return seconds_of(embed, metric)
    except NotEmbedded as error:
        return None, error.embedding


def mesh(sizes):
    """The mesh route."""
    wanted = [
        *(
            (name, lengths, 0.0)
            for name in ("horizon a=0.8", "a=0.8 r=3")
            for lengths in ("geodesic", "chord")
        ),
        ("ergosphere 0.3", "chord", GRADING),
        *(("ergosphere 0.1", "chord", grading) for grading in (GRADING, 0.0)),
    ]
    rows, limits = [], []
    for name, lengths, grading in wanted:
        surface = surfaces()[name]
        profile = surface.profile()
        exact = REFERENCE.get(name, (None, profile.integrated_mean_curvature))[1]
        batch = []
        for n in sizes:
            triangles = triangulate_metric(surface, n, grading=grading)
            metric = triangles.metric
            if lengths == "chord":
                metric = PolyhedralMetric.from_mesh(profile.points(triangles.directions), triangles.faces)
            seconds, found = polyhedron(metric)
            corrected = SmoothIntegrals(metric.triangulation, found.vertices, lengths)
            estimate = corrected.integrated_mean_curvature
            row = {
                "surface": name,
                "lengths": lengths,
                "grading": f"{grading:g}",
                "N": n,
                "bare": found.integrated_mean_curvature / exact - 1.0,
                "corrected": estimate.value / exact - 1.0,
                "estimated": estimate.error / exact,
                "residual": found.residual,
                "seconds": seconds and round(seconds, 2),
            }
            batch.append(row)
        for one, two in pairwise(batch):
            for which in ("bare", "corrected"):
                ratio = abs(one[which] / two[which])
                two[f"{which} order"] = round(2.0 * np.log(ratio) / np.log(two["N"] / one["N"]), 1)
        rows += batch
        limits.append(extrapolated(batch))
    show("int H dA from polyhedra: relative errors, bare and corrected, and orders in h", rows)
    show("Extrapolated from the two finest, bare in 1/N, corrected in 1/N^2; orders fitted to all", limits)
    paper = [
        {
            "surface": row["surface"],
            "grading": row["grading"],
            "N": row["N"],
            "bare error": abs(row["bare"]),
            "the paper's": PAPER,
            "bare below": abs(row["bare"]) <= PAPER,
            "bare extrapolated": abs(row["bare extrapolated"]),
            "corrected extrapolated": abs(row["corrected extrapolated"]),
            "asked": ASKED,
            "corrected below": abs(row["corrected extrapolated"]) <= ASKED,
        }
        for row in limits
        if row["surface"].startswith("ergosphere")
    ]
    show("The paper's ergosphere", paper)
    return {"rows": rows, "extrapolated": limits, "paper": paper, "negative": negative(min(sizes))}


def extrapolated(batch):
    """What the two finest sizes say of the limit."""
    coarse, fine = batch[-2:]
    row = {key: fine[key] for key in ("surface", "lengths", "grading", "N", "bare", "corrected")}
    for which, power in (("bare", 1), ("corrected", 2)):
        ratio = (fine["N"] / coarse["N"]) ** power
        row[f"{which} extrapolated"] = (ratio * fine[which] - coarse[which]) / (ratio - 1.0)
    for which in ("bare", "corrected"):
        sizes, errors = np.log([row["N"] for row in batch]), np.log([abs(row[which]) for row in batch])
        row[f"{which} order"] = round(-2.0 * float(np.polyfit(sizes, errors, 1)[0]), 1)
    return row


def negative(n):
    """Geodesic lengths where K < 0 somewhere, and the chords that they are corrected to."""
    rows = []
    for name in ("ergosphere 0.3", "ergosphere 0.1"):
        surface = surfaces()[name]
        exact = surface.profile().integrated_mean_curvature
        triangles = triangulate_metric(surface, n, grading=GRADING)
        metric = triangles.metric
        i, j = metric.edges.T
        solution = embed_surface(surface.data()).embedding
        points = solution.points(triangles.directions)
        _, first = polyhedron(metric)
        chords = metric.with_lengths(chord_lengths(metric.triangulation, first.vertices, metric.lengths))
        straight = metric.with_lengths(np.linalg.norm(points[i] - points[j], axis=1))
        tried = {
            "geodesic": first,
            "geodesic, corrected to chords": polyhedron(chords)[1],
            "chords of the smooth solution": polyhedron(straight)[1],
        }
        for label, found in tried.items():
            lengths = "geodesic" if label == "geodesic" else "chord"
            corrected = SmoothIntegrals(metric.triangulation, found.vertices, lengths)
            rows.append(
                {
                    "surface": name,
                    "N": n,
                    "lengths": label,
                    "embedded": found.status == "converged",
                    "residual": found.residual,
                    "bare": found.integrated_mean_curvature / exact - 1.0,
                    "corrected": corrected.integrated_mean_curvature.value / exact - 1.0,
                }
            )
    show("K < 0: which lengths there is a polyhedron for", rows)
    return rows


def slices():
    """One surface in several slices."""
    spheres = []
    for r in (2.5, 3.0, 4.0, 6.0, 10.0, 100.0):
        found = embed_surface(StarSurface.sphere((0.0, 0.0, 0.0), r).data(PainleveGullstrand(1.0))).energies
        row = {"r": f"{r:g}"}
        compared(row, "Brown-York", found.brown_york, 0.0)
        compared(row, "Liu-Yau", found.liu_yau, r * (1.0 - np.sqrt(1.0 - 2.0 / r)))
        compared(row, "Hawking", found.hawking, 1.0)
        spheres.append(row)
    show("Painleve-Gullstrand spheres: 0 against r (1 - sqrt(1 - 2 M / r))", spheres)
    horizons = []
    geometry = KerrSchild(1.0, (0.0, 0.0, EXTREME))
    tilted = KerrSchild(1.0, EXTREME * np.array([0.0, -np.sin(0.4), np.cos(0.4)]))
    closed = KerrNewmanHorizon(1.0, EXTREME).data()
    cases = {"Boyer-Lindquist": closed}
    for label, slice_ in (("Kerr-Schild", geometry), ("Kerr-Schild, tilted", tilted)):
        star = StarSurface.from_radius(slice_.spheroid(slice_.horizon))
        cases[label] = replace(star.data(slice_), marginal=True)
    exact = REFERENCE["horizon a=0.866"][1] / (4.0 * np.pi)
    for label, data in cases.items():
        seconds, embedded = seconds_of(embed_surface, data)
        row = {"slice": label}
        compared(row, "Liu-Yau", embedded.energies.liu_yau, exact)
        row |= {
            "as Dunajski-Tod": abs(embedded.energies.liu_yau.value - DUNAJSKI_TOD) < 5e-6,
            "degree": embedded.embedding.harmonics.degree,
            "residual": embedded.embedding.residual,
            "seconds": round(seconds, 1),
        }
        horizons.append(row)
    show(f"The horizon of spin sqrt(3)/2: {DUNAJSKI_TOD} by Dunajski and Tod", horizons)
    return {"spheres": spheres, "horizons": horizons}


def files(folder):
    """From files to energies."""
    grids = []
    for a, name in GRIDS.items():
        metric = read_metric_grid(folder / "cases" / name)
        data = SurfaceData(metric, marginal=True, name=name)
        seconds, embedded = seconds_of(embed_surface, data)
        area, imc = REFERENCE[f"horizon a={a:g}"]
        row = {"file": name}
        compared(row, "int H", embedded.energies.integrated_mean_curvature, imc)
        compared(row, "area", embedded.energies.area, area)
        compared(row, "Liu-Yau", embedded.energies.liu_yau, imc / (4.0 * np.pi))
        grids.append(row | {"truncation": metric.truncation, "seconds": round(seconds, 1)})
    show("Horizons from metrics on grids", grids)
    return {"grids": grids, "tilted": numerical_horizon(folder / TILTED_FILE)}


def numerical_horizon(path):
    """A numerical horizon, the exact one, and how the distance between them accounts for the differences.

    The area changes by ``int k dn dA`` under a displacement dn along the normals, and int k0 dA of the
    embedding by ``1/2 int (k0 q^AB - k0^AB) dq_AB dA`` with the metric (Brown and York 1993).
    """
    shape = read_horizon(path)
    found = StarSurface.from_points(shape.points, shape.center.tolist())
    exact = StarSurface.from_radius(TILTED.spheroid(TILTED.horizon))
    seconds, embedded = seconds_of(embed_surface, replace(found.data(TILTED), marginal=True))
    reference = embed_surface(replace(exact.data(TILTED), marginal=True))
    u, weights = gauss_rule(64, 128)
    q = exact.metric(TILTED).tensor(u)
    dA = weights * area_density(q)
    e = orthonormal_frame(u, q)
    # dn is the difference of the radii along n_i, which is perpendicular to the surface.
    across = np.cross(*np.einsum("nij,naj->ani", exact.differential(u), e))
    across /= np.sqrt(
        np.einsum(
            "ni,ni->n", across, np.linalg.solve(TILTED.metric(exact.points(u)), across[:, :, None])[:, :, 0]
        )
    )[:, None]
    dn = (found.radius(u) - exact.radius(u)) * np.einsum("ni,ni->n", across, u)
    k = exact.mean_curvature(TILTED, u)
    solution = reference.embedding
    bending = solution.harmonics.second_along(u, e, solution.coefficients)
    h = -np.einsum("nabi,ni->nab", bending, solution.normals(u))
    stress = np.einsum("ncc->n", h)[:, None, None] * np.eye(2) - h
    dq = np.einsum("nai,nij,nbj->nab", e, found.metric(TILTED).tensor(u) - q, e)
    rows = []
    now, true = embedded.energies, reference.energies
    predicted = {
        "area": float(dA @ (k * dn)),
        "int H": 0.25 * float(dA @ np.einsum("nab,nab->n", stress, dq)),
    }
    predicted["Liu-Yau"] = predicted["int H"] / (4.0 * np.pi)
    predicted["irreducible mass"] = predicted["area"] / (32.0 * np.pi * true.irreducible_mass.value)
    for label, one, two, known in (
        ("area", now.area, true.area, REFERENCE["horizon a=0.6"][0]),
        (
            "int H",
            now.integrated_mean_curvature,
            true.integrated_mean_curvature,
            REFERENCE["horizon a=0.6"][1],
        ),
        ("Liu-Yau", now.liu_yau, true.liu_yau, REFERENCE["horizon a=0.6"][1] / (4.0 * np.pi)),
        ("irreducible mass", now.irreducible_mass, true.irreducible_mass, np.sqrt(0.9)),
    ):
        rows.append(
            {
                "": label,
                "file": one.value,
                "estimated": one.error,
                "exact horizon": two.value,
                "its error": relative(two.value, known),
                "difference": one.value - two.value,
                "foretold": predicted[label],
                "relative": (one.value - two.value) / two.value,
            }
        )
    show(f"The numerical horizon of {path.name}, in the exact slice", rows, digits=4)
    theta = found.expansion(TILTED, u)
    facts = {
        "points": len(shape.points),
        "misfit of the points": found.misfit,
        "normal displacement, mean": float(dA @ dn / dA.sum()),
        "least": float(dn.min()),
        "largest": float(dn.max()),
        "expansion theta_+, mean": float(dA @ theta / dA.sum()),
        "its largest size": float(np.abs(theta).max()),
        "on the exact": float(np.abs(exact.expansion(TILTED, u)).max()),
        "area by AHFinderDirect": TILTED_AREA,
        "less ours of the file": TILTED_AREA - now.area.value,
        "seconds": round(seconds, 1),
    }
    show("What the file itself is", [{"": name, "value": value} for name, value in facts.items()], digits=4)
    return {"rows": rows, "facts": facts}


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--only", nargs="+", choices=PARTS, default=PARTS)
    parser.add_argument("--sizes", type=int, nargs="+", default=SIZES, metavar="N", help="of the meshes")
    parser.add_argument("--shared", type=Path, metavar="DIR", help="with the folders cases and real")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the rows to this file")
    options = parser.parse_args()
    if len(options.sizes) < 2:
        parser.error("--sizes takes at least two, to extrapolate")
    parts = {
        "smooth": smooth,
        "degree": degree,
        "mesh": lambda: mesh(sorted(options.sizes)),
        "slices": slices,
        "files": lambda: files(options.shared),
    }
    result = {}
    for part in PARTS:
        if part in options.only and (part != "files" or options.shared):
            seconds, result[part] = seconds_of(parts[part])
            print(f"\n{part}: {seconds:.0f} s", flush=True)
    if options.json:
        options.json.write_text(json.dumps(result, indent=1))


if __name__ == "__main__":
    main()
