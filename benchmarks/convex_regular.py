"""The solids of the classics, for the convex sweep: regular ones over polygons, and stretched ones."""

import sys
from pathlib import Path

import numpy as np

from convex_cases import case

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "support"))
import solids
from johnson_solids import johnson

SIDES = range(3, 21)
HEIGHTS = np.geomspace(1e-2, 1e2, 44)
STRETCHES = (
    (1, 1, 1), (1, 1, 2), (1, 1, 10), (1, 1, 100), (1, 1, 0.5), (1, 1, 0.1), (1, 1, 0.01), (2, 3, 5),
    (1, 2, 4), (1, 3, 0.3), (1, 10, 100), (1, 0.1, 0.01),
)  # fmt: skip
ROUND = {
    "uniform solids": (solids.uniform, (*solids.PLATONIC, *solids.ARCHIMEDEAN)),
    "Catalan solids": (solids.catalan, solids.ARCHIMEDEAN),
    "Johnson solids": (johnson, range(1, 93)),
}
OVER_POLYGONS = {
    "regular prisms": solids.prism,
    "regular antiprisms": solids.antiprism,
    "regular pyramids": solids.pyramid,
    "regular bipyramids": lambda n, height: solids.bipyramid(n, height, HEIGHTS[(7 * SIDES.index(n)) % 44]),
}
COUNTS = {family: len(SIDES) * len(HEIGHTS) for family in OVER_POLYGONS} | {
    family: len(names) * len(STRETCHES) for family, (_, names) in ROUND.items()
}
"""How many there are of each family: 4,644 in all."""


def regular(family, number):
    """A solid on its own triangles, or, if its number is odd, on others that random flips made."""
    if family in ROUND:
        make, names = ROUND[family]
        name, axes = names[number // len(STRETCHES)], STRETCHES[number % len(STRETCHES)]
        points, name = make(name), f"{name}, stretched by {axes}"
    else:
        n, height = SIDES[number // len(HEIGHTS)], HEIGHTS[number % len(HEIGHTS)]
        points, name, axes = OVER_POLYGONS[family](n, height), f"n = {n}, height {height:.4g}", (1, 1, 1)
    faces = solids.triangles(solids.polygons(points))
    return case(np.random.default_rng(number), points * axes, faces, shuffled=number % 2, name=name)
