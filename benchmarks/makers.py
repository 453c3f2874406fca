"""Solids on paper: are the files of nets right, and do they give the solids back?

    python benchmarks/makers.py [--only KIND ...] [--sizes MM ...] [--hulls N] [--bodies N] [--files KIND ...]
                                [--each] [--json FILE]

The Platonic, Archimedean, Catalan and Johnson solids, N random hulls as of `unfold.py`, N star-shaped bodies
as of `stars.py` and N spheres and ellipsoids with dimples as of `dents.py`.  Each is unfolded and drawn on A4
so that its diameter has a given size in mm; where a face does not fit on the page, so much smaller as the
refusal says.

What is checked is read from the SVG itself, in whole units of its last digit: sides of outlines, tabs
included, meet nowhere but at their common ends; no outline is inside another; each is on one page.  Then the
files are glued, embedded, and the vertices compared with the solid by all their distances.

Printed for each kind and size are the solids, those that were made smaller, pages in the mean, the largest
number of pages, overlaps, outlines beyond a page, the least distance from its rim in mm, and for each kind
of file those that are not the solid again, and the largest difference of a distance in mm.  The names of what
failed follow.
"""

import argparse
import json
import re
import sys
import tempfile
import time
import warnings
import xml.etree.ElementTree as ElementTree
from fractions import Fraction
from pathlib import Path

import numpy as np
from scipy.spatial.distance import pdist

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests" / "support"))

import dents
import johnson_solids
import solids
import stars
from isoembed import (
    Embedding,
    InvalidMetric,
    InvalidParameter,
    NotEmbedded,
    PolyhedralMetric,
    embed,
    glue,
    unfold,
)
from isoembed.gallery import triangulate
from isoembed.io import FileError
from unfold import hull

PAGE = (210, 297)  # mm
OFF = 1e-3  # mm, by which a distance of two vertices may differ: nearly flat vertices magnify digits
SMALLER = 0.999  # of the scale that a refusal names, which is rounded
NUMBER = re.compile(r"-?\d+(?:\.\d+)?")
SVG = "{http://www.w3.org/2000/svg}"


def catalan(name):
    """Vertices and triangles of a Catalan solid."""
    points = solids.catalan(name)
    return points, solids.triangles(solids.polygons(points))


def star(seed):
    """Vertices and triangles of a star-shaped body."""
    vertices, faces, _ = stars.body(seed)
    return vertices, faces


def dented(seed):
    """Vertices and triangles of a sphere or an ellipsoid with one to three dimples."""
    rng = np.random.default_rng([seed, 45])
    axes = tuple(dents.BODIES.values())[seed % 2]
    centers = dents.directions(rng, 1 + seed % 3, dents.APART * dents.WIDTH)
    surface = dents.Dimpled(axes, centers, rng.uniform(0.5, 1.0) * dents.WIDTH, dents.WIDTH)
    return triangulate(surface, int(rng.integers(40, 121)), irregular=seed)


def convex(points):
    """Vertices and triangles of the hull of points."""
    return points, solids.triangles(solids.polygons(points))


def bodies(hulls, count):
    """Kinds of solids: for each, names, and what makes vertices and triangles of one."""
    return {
        "Platonic": (solids.PLATONIC, lambda name: convex(solids.uniform(name))),
        "Archimedean": (solids.ARCHIMEDEAN, lambda name: convex(solids.uniform(name))),
        "Catalan": (solids.ARCHIMEDEAN, catalan),
        "Johnson": (range(1, 93), lambda number: convex(johnson_solids.johnson(number))),
        "hulls": (range(hulls), hull),
        "stars": (range(1000, 1000 + count), star),
        "dents": (range(count), dented),
    }


# What the file says, without the package.


def outlines(path):
    """The closed paths of the layer to cut, (n, 2), in whole units of the last digit, and the unit in mm."""
    root = ElementTree.parse(path).getroot()
    [layer] = [group for group in root.iter(f"{SVG}g") if group.get("id") == "cut"]
    found = []
    for drawn in layer.iter(f"{SVG}path"):
        assert drawn.get("d").endswith("Z") and "transform" not in drawn.attrib
        words = NUMBER.findall(drawn.get("d"))
        found.append([Fraction(word) for word in words])
    digits = max(len(word.partition(".")[2]) for word in NUMBER.findall(layer.find(f"{SVG}path").get("d")))
    width, height = (Fraction(root.get(name).removesuffix("mm")) for name in ("width", "height"))
    assert [Fraction(word) for word in root.get("viewBox").split()] == [0, 0, width, height]
    unit = Fraction(1, 10**digits)
    whole = [np.array([int(value / unit) for value in values]).reshape(-1, 2) for values in found]
    for values, numbers in zip(found, whole, strict=True):
        assert values == [unit * int(number) for number in numbers.ravel()]
    return whole, unit, (width / unit, height / unit)


def crossings(every):
    """Number of pairs of sides of closed polygons that meet where they should not."""
    starts = np.concatenate(every)
    ends = np.concatenate([np.roll(polygon, -1, axis=0) for polygon in every])
    sizes = np.array([len(polygon) for polygon in every])
    first = np.repeat(np.cumsum(sizes) - sizes, sizes)
    number = np.arange(len(starts))
    after = np.where(number + 1 < first + np.repeat(sizes, sizes), number + 1, first)
    low, high = np.minimum(starts, ends), np.maximum(starts, ends)
    i, j = np.triu_indices(len(starts), 1)
    near = ((low[i] <= high[j]) & (low[j] <= high[i])).all(axis=1)
    i, j = i[near], j[near]
    consecutive = (after[i] == j) | (after[j] == i)
    a, b, c, d = starts[i], ends[i], starts[j], ends[j]
    meet = (turn(a, b, c) * turn(a, b, d) <= 0) & (turn(c, d, a) * turn(c, d, b) <= 0) & ~consecutive
    # Two sides one after the other meet elsewhere, too, if the second leads back along the first.
    x, y = b[consecutive] - a[consecutive], d[consecutive] - c[consecutive]
    back = (x[:, 0] * y[:, 1] == x[:, 1] * y[:, 0]) & ((x * y).sum(axis=1) < 0)
    return int(meet.sum() + back.sum() + ((starts == ends).all(axis=1)).sum())


def turn(a, b, c):
    """Sign of the turn from ab to ac, in whole numbers."""
    u, v = b - a, c - a
    return np.sign(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])


def inside(point, polygon):
    """Whether a point that is not on it is inside a polygon, in whole numbers."""
    below = polygon[:, 1] <= point[1]
    a, b = polygon, np.roll(polygon, -1, axis=0)
    upward, downward = below & (b[:, 1] > point[1]), ~below & (b[:, 1] <= point[1])
    left = turn(a, b, np.broadcast_to(point, a.shape))
    return int((upward & (left > 0)).sum() - (downward & (left < 0)).sum()) != 0


def read(path):
    """Pages, overlaps, outlines beyond their page, and the least distance from its rim in mm."""
    every, unit, (width, height) = outlines(path)
    page = np.array([int(PAGE[0] / unit), int(PAGE[1] / unit)])
    assert width in page
    across, up = (page if width == page[0] else page[::-1]).tolist()
    assert height % up == 0
    pages = int(height / up)
    overlaps, beyond, margin = 0, 0, np.inf
    on = [int(polygon[0, 1] // up) for polygon in every]
    for k in range(pages):
        mine = [polygon for polygon, place in zip(every, on, strict=True) if place == k]
        if not mine:
            continue
        overlaps += crossings(mine)
        overlaps += sum(inside(p[0], q) for p in mine for q in mine if p is not q)
        for polygon in mine:
            low, high = polygon.min(axis=0), polygon.max(axis=0)
            room = min(low[0], across - high[0], low[1] - k * up, (k + 1) * up - high[1])
            beyond += room < 0
            margin = min(margin, float(room * unit))
    return {"pages": pages, "overlaps": overlaps, "beyond": beyond, "margin": margin}


# The package: a file of a body, and the body of a file.


def drawn(body, size, path, kinds):
    """Unfold and draw a body; what of the size is left, and the scale."""
    vertices, faces = body
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    unfolding = unfold(Embedding(metric, vertices, method="given", tolerance=1e-10))
    scale = wanted = size / float(pdist(vertices).max())
    for attempt in range(2):
        try:
            for kind in kinds:
                unfolding.save(path.with_suffix(f".{kind}"), paper="A4", scale=scale)
        except InvalidParameter as refusal:
            fits = re.search(r"up to scale=([\d.]+(?:e[-+]\d+)?)", str(refusal))
            if fits is None or attempt:
                raise
            scale = SMALLER * float(fits[1])
        else:
            break
    return scale / wanted, scale


def back(path, body, scale):
    """The largest difference, in mm, of a distance between vertices of the solid of a file."""
    vertices, _ = body
    net = glue(path)
    found = embed(net)
    if len(found.vertices) != len(vertices):
        return np.inf
    there, here = np.sort(pdist(found.vertices)), np.sort(scale * pdist(vertices))
    return float(np.abs(there - here).max())


def measured(name, body, size, path, kinds):
    """One row: what became of a body on paper."""
    start = time.process_time()
    row = {"name": name, "size": size}
    try:
        row["smaller"], scale = drawn(body, size, path, ("svg", *(kind for kind in kinds if kind != "svg")))
    except (InvalidMetric, InvalidParameter) as refusal:
        return row | {"failed": str(refusal)}
    row |= read(path.with_suffix(".svg"))
    for kind in kinds:
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                row[kind] = back(path.with_suffix(f".{kind}"), body, scale)
        except (FileError, InvalidMetric, InvalidParameter, NotEmbedded) as refusal:
            row[kind], row[f"{kind} failed"] = np.inf, str(refusal)
    row["seconds"] = time.process_time() - start
    return row


def table(kind, size, rows, kinds):
    """The lines of a kind and size."""
    done = [row for row in rows if "failed" not in row]
    parts = [f"{kind:12} {size:5g} {len(rows):6} {len(rows) - len(done):7}"]
    if done:
        column = {key: np.array([row[key] for row in done]) for key in ("smaller", "pages", "margin")}
        parts.append(
            f"{(column['smaller'] < 1).sum():8} {column['pages'].mean():6.2f} {column['pages'].max():5} "
            f"{sum(row['overlaps'] > 0 for row in done):9} {sum(row['beyond'] > 0 for row in done):7} "
            f"{column['margin'].min():7.2f} "
        )
        for name in kinds:
            off = np.array([row[name] for row in done])
            there = off[np.isfinite(off)]
            worst = f"{there.max():8.1e}" if len(there) else "        "
            parts.append(f"{(~(off <= OFF)).sum():8} {worst}")
    wrong = []
    for row in rows:
        if "failed" in row:
            wrong.append(f"    {row['name']}: {row['failed']}")
            continue
        said = [f"{row[name]} {name}" for name in ("overlaps", "beyond") if row[name]]
        said += [f"{name} {row.get(f'{name} failed', row[name])}" for name in kinds if not row[name] <= OFF]
        if said:
            wrong.append(f"    {row['name']}: {'; '.join(said)}")
    return "\n".join([" ".join(parts), *wrong])


def main():
    """Run what is asked."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--only", nargs="+", choices=tuple(bodies(0, 0)), metavar="KIND")
    parser.add_argument("--sizes", nargs="+", type=float, default=[100.0, 250.0], metavar="MM")
    parser.add_argument("--hulls", type=int, default=200, metavar="N")
    parser.add_argument("--bodies", type=int, default=30, metavar="N", help="stars, and bodies with dimples")
    parser.add_argument("--files", nargs="*", choices=("svg", "dxf"), default=["svg", "dxf"], metavar="KIND")
    parser.add_argument("--each", action="store_true", help="print a line for each body")
    parser.add_argument("--json", type=Path, metavar="FILE")
    options = parser.parse_args()
    every = []
    print(
        f"{'kind':12} {'mm':>5} solids refused  smaller  pages  most  overlaps  beyond  margin  "
        + " ".join(f"{f'{kind} lost':>8} {'off, mm':>8}" for kind in options.files)
    )
    with tempfile.TemporaryDirectory() as folder:
        for kind, (names, make) in bodies(options.hulls, options.bodies).items():
            if options.only and kind not in options.only:
                continue
            for size in options.sizes:
                rows = []
                for name in names:
                    row = measured(name, make(name), size, Path(folder) / "net.svg", options.files)
                    rows.append(row | {"kind": kind})
                    if options.each:
                        print(f"  {row}", flush=True)
                print(table(kind, size, rows, options.files), flush=True)
                every += rows
    print(f"{sum(row.get('seconds', 0.0) for row in every):.0f} s")
    if options.json:
        options.json.write_text(json.dumps(every, indent=1, default=str))


if __name__ == "__main__":
    main()
