"""Classic nets by name: the Latin cross, tetramonohedra, pita forms, D-forms, the Platonic solids."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from isoembed.gluing.enumeration import edge_gluings
from isoembed.gluing.forms import Outline, dform, pita
from isoembed.gluing.net import Net, glue
from isoembed.gluing.outlines import Ellipse, Stadium, circle, rectangle, regular_polygon, triangle

SIDES = 64  # of a polygon inscribed in a curve

LATIN_CROSS = np.array(
    [
        [0, 0], [1, 0], [1, 1], [1, 2], [2, 2], [2, 3], [1, 3],
        [1, 4], [0, 4], [0, 3], [-1, 3], [-1, 2], [0, 2], [0, 1],
    ],
    dtype=np.float64,
)  # fmt: skip
"""Cross of six unit squares, shape (14, 2), with a corner at each end of each unit side."""


@dataclass(frozen=True)
class Classic:
    """A family of nets: a one-line description, and a function that creates them with labels."""

    purpose: str
    make: Callable[[], list[tuple[str, Net]]]


def latin_cross() -> list[tuple[str, Net]]:
    """All convex edge-to-edge gluings of the Latin cross.

    Known since Lubiw and O'Rourke (When can a polygon fold to a polytope?, 1996): five convex polyhedra.
    """
    gluings = edge_gluings(LATIN_CROSS)
    return [
        (" ".join(f"{i}-{k}" for (_, i), (_, k) in sides), glue([LATIN_CROSS], sides)) for sides in gluings
    ]


def rolled_rectangle(width: float, height: float, twist: float) -> Net:
    """Rectangle rolled to a cylinder, with ends folded shut, one twisted relative to the other.

    Parameters
    ----------
    width, height : float
    twist : float
        Twist, from 0 to below half the width.
    """
    fold = 2 + 2 * twist / width
    top = [((0, 2, fold), (0, 2, fold)), ((0, fold, 3), (0, fold, 3))] if twist else [((0, 2), (0, 2))]
    return glue([rectangle(width, height)], [((0, 1), (0, 3)), ((0, 0), (0, 0)), *top])


def tetramonohedra() -> list[tuple[str, Net]]:
    """Tetrahedra with congruent faces, from triangles and rectangles.

    The sides of a triangle are folded at their midpoints.  The faces are similar to the triangle if it is
    acute, of half its size; if it is right, they coincide in pairs.
    """
    triangles = [(1.0, 1.0, 1.0), (4.0, 5.0, 6.0), (3.0, 4.0, 5.0), (4.0, 5.0, 8.0)]
    folds = [((0, k), (0, k)) for k in range(3)]
    rectangles = [(2.0, 1.0, 0.0), (2.0, 1.0, 0.5), (2.0, 1.3, 0.3), (2.0, 3.0, 0.05)]
    return [
        *((f"triangle {a:g} {b:g} {c:g}, folded", glue([triangle(a, b, c)], folds)) for a, b, c in triangles),
        *((f"rectangle {w:g} x {h:g}, twist {s:g}", rolled_rectangle(w, h, s)) for w, h, s in rectangles),
    ]


def pitas() -> list[tuple[str, Net]]:
    """Outlines zipped shut from a boundary point."""
    forms: list[tuple[str, Outline, float]] = [
        ("circle", circle(), 0.0),
        ("ellipse 2:1 from its tip", Ellipse(2.0, 1.0), 0.0),
        ("ellipse 2:1 from 1/8", Ellipse(2.0, 1.0), 0.125),
        ("stadium 2:1 from 1/8", Stadium(2.0, 1.0), 0.125),
        ("square from 1/16", rectangle(1.0, 1.0), 1 / 16),
        ("rectangle 2 x 1 from 1/20", rectangle(2.0, 1.0), 1 / 20),
        ("regular pentagon from a corner", regular_polygon(5), 0.0),
    ]
    return [(name, pita(outline, at, SIDES)) for name, outline, at in forms]


def dforms() -> list[tuple[str, Net]]:
    """Pairs of outlines glued along their entire boundaries."""
    oval, square = Ellipse(2.0, 1.0), rectangle(1.0, 1.0)
    forms: list[tuple[str, Outline, Outline, float]] = [
        ("two circles", circle(), circle(), 0.0),
        ("ellipses 2:1, by 1/8", oval, oval, 0.125),
        ("ellipses 2:1, by 1/4", oval, oval, 0.25),
        ("stadiums 2:1, by 1/4", Stadium(2.0, 1.0), Stadium(2.0, 1.0), 0.25),
        ("circle and ellipse 2:1", circle(), oval, 0.0),
        ("circle and square", circle(), square, 0.0),
        ("squares, by 1/8", square, square, 0.125),
    ]
    return [(name, dform(first, second, offset, SIDES)) for name, first, second, offset in forms]


def regular_faces(loops: Sequence[Sequence[str | int]]) -> Net:
    """Regular polygons of side 1, glued as the faces of a polyhedron.

    Parameters
    ----------
    loops : sequence of sequence of str or int
        Corner names around each face.
    """
    return glue([regular_polygon(len(loop)) for loop in loops], corners=loops)


def platonic() -> list[tuple[str, Net]]:
    """The Platonic solids from their faces."""
    turn = [(k, (k + 1) % 5) for k in range(5)]
    faces: dict[str, list[list[int]]] = {
        "4 triangles": [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]],
        "6 squares": [[0, 1, 2, 3], [7, 6, 5, 4], [0, 4, 5, 1], [1, 5, 6, 2], [2, 6, 7, 3], [3, 7, 4, 0]],
        "8 triangles": [face for k, m in ((1, 2), (2, 3), (3, 4), (4, 1)) for face in ([0, k, m], [5, m, k])],
        "12 pentagons": [
            [0, 1, 2, 3, 4],
            *([k, 5 + k, 10 + k, 5 + m, m] for k, m in turn),
            *([15 + k, 15 + m, 10 + m, 5 + m, 10 + k] for k, m in turn),
            [19, 18, 17, 16, 15],
        ],
        "20 triangles": [
            *([0, 1 + k, 1 + m] for k, m in turn),
            *([1 + k, 6 + k, 1 + m] for k, m in turn),
            *([1 + m, 6 + k, 6 + m] for k, m in turn),
            *([11, 6 + m, 6 + k] for k, m in turn),
        ],
    }
    return [(name, regular_faces(loops)) for name, loops in faces.items()]


CLASSICS = {
    "latin-cross": Classic("all edge-to-edge gluings of the Latin cross that are convex", latin_cross),
    "tetramonohedra": Classic(
        "tetrahedra with four faces alike, from triangles and rectangles", tetramonohedra
    ),
    "pitas": Classic("outlines zipped shut from one of their points", pitas),
    "dforms": Classic("pairs of outlines of equal perimeter glued all around", dforms),
    "platonic": Classic("the Platonic solids from their faces", platonic),
}
"""Families by their command-line names."""
