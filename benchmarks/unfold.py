"""Solids unfolded: are there nets without overlaps, and do they give the solids back?

    python benchmarks/unfold.py [--hulls N] [--first SEED] [--json FILE]

The Platonic, Archimedean and Johnson solids, and N hulls of 8 to 100 random points on a sphere, on an
ellipsoid, in a cube and of a normal distribution.  Each net goes through the JSON of `isoembed glue`: the
outlines that are read there are checked to be simple in rational arithmetic, every side against every other,
and to have the area of the solid together; they are glued, embedded, and the vertices compared by all their
distances.  Printed are solids, those in one sheet, the largest number of sheets, overlaps, the largest
difference of a distance over the diameter, the seconds to unfold in the mean and at most, and the sides
that have no tab and the smallest label on A4, in mm.
"""

import argparse
import json
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from scipy.spatial.distance import pdist

from alexandrov import outward_hull

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests" / "support"))

import johnson_solids
import solids
from exact import is_simple
from isoembed import Embedding, PolyhedralMetric, embed, unfold
from isoembed.io.net import read_net, write_net
from isoembed.papercraft.drawing import drawn


def hull(seed):
    """Vertices and faces of a random hull."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(8, 101))
    while True:
        points = rng.uniform(-1, 1, (n, 3)) if seed % 4 == 2 else rng.normal(size=(n, 3))
        if seed % 4 < 2:
            points /= np.linalg.norm(points, axis=1)[:, None]
        if seed % 4 == 1:
            points *= [3.0, 2.0, 1.0]
        vertices, faces = outward_hull(points)
        if len(vertices) >= 8:
            return vertices, faces


def bodies(first, count):
    """Kinds of solids: for each, vertices and triangles."""
    platonic = (solids.uniform(name) for name in solids.PLATONIC)
    archimedean = (solids.uniform(name) for name in solids.ARCHIMEDEAN)
    johnson = (johnson_solids.johnson(number) for number in range(1, 93))
    for kind, points in (("Platonic", platonic), ("Archimedean", archimedean), ("Johnson", johnson)):
        yield kind, ((each, solids.triangles(solids.polygons(each))) for each in points)
    yield "hulls", (hull(seed) for seed in range(first, first + count))


def unfolded(vertices, faces, path):
    """One row of numbers."""
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    surface = Embedding(metric, vertices, method="given", tolerance=1e-10)
    start = time.process_time()
    unfolding = unfold(surface)
    seconds = time.process_time() - start
    write_net(path, unfolding)
    written = json.loads(path.read_text())
    written.pop("folds", None)  # the outlines alone are glued again
    path.write_text(json.dumps(written))
    net = read_net(str(path))
    simple = all(map(is_simple, net.polygons))
    area = sum((x * np.roll(y, -1) - y * np.roll(x, -1)).sum() / 2 for x, y in (p.T for p in net.polygons))
    again = embed(net, method="alexandrov").vertices
    of = dict(zip(np.concatenate(unfolding.corners), np.concatenate(net.corners), strict=True))
    found = again[[of[v] for v in range(len(vertices))]]
    drawing = drawn(unfolding)
    return {
        "vertices": len(vertices),
        "sheets": len(unfolding.sheets),
        "overlaps": bool(not simple or abs(area / surface.area - 1) > 1e-12),
        "off": float(np.abs(pdist(found) - pdist(vertices)).max() / pdist(vertices).max()),
        "seconds": seconds,
        "pairs": len(unfolding.sides),
        "tabs": len(drawing.folds) - sum(map(len, unfolding.folds)),
        "label": min(one.size for one in drawing.labels),
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--hulls", type=int, default=1000)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    every = {}
    print("kind         solids  one sheet  sheets  overlaps      off  seconds   most  no tab  least label")
    with tempfile.TemporaryDirectory() as folder:
        for kind, some in bodies(options.first, options.hulls):
            rows = every[kind] = [unfolded(*body, Path(folder) / "net.json") for body in some]
            column = {key: np.array([row[key] for row in rows]) for key in rows[0]}
            print(
                f"{kind:12} {len(rows):6} {(column['sheets'] == 1).sum():10} {column['sheets'].max():7} "
                f"{column['overlaps'].sum():9} {column['off'].max():8.1e} {column['seconds'].mean():8.3f} "
                f"{column['seconds'].max():6.2f} {(column['pairs'] - column['tabs']).sum():7} "
                f"{column['label'].min():12.2f}",
                flush=True,
            )
    if options.json:
        options.json.write_text(json.dumps(every, indent=1))


if __name__ == "__main__":
    main()
