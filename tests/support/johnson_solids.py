"""The 92 Johnson solids from first principles: `johnson(number)` are the vertices, of edge length 1."""

from functools import cache
from itertools import combinations

import numpy as np
from scipy.optimize import fsolve

from solids import PHI, drum, has_regular_faces, orbit, polygons, prism, ring, uniform

# The first 48 are caps, one or two, on a ring, a prism or an antiprism.


@cache
def cap(kind, n):
    """What is on top of `ring(m)`, and m."""
    if kind == "pyramid":
        return np.array([[0, 0, np.sqrt(1 - np.linalg.norm(ring(n)[0]) ** 2)]]), n
    top = ring(n, 0, 3 * np.pi / (2 * n))  # each second side of the base is below one of these
    if kind == "cupola":
        apart = 0.5 / np.tan(np.pi / (2 * n)) - 0.5 / np.tan(np.pi / n)
        return top + np.array([0, 0, np.sqrt(1 - apart**2)]), 2 * n
    points = uniform("icosidodecahedron")
    face = next(face for face in polygons(points) if len(face) == 5)
    z = points[face].mean(axis=0)
    z /= np.linalg.norm(z)
    x = points[face[0]] - (points[face[0]] @ z) * z
    x /= np.linalg.norm(x)
    points = points @ np.array([x, np.cross(z, x), z]).T
    turn = 3 * np.pi / 10
    c, s = np.cos(turn), np.sin(turn)
    return points[points[:, 2] > 1e-6] @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]), 10


def capped(top, middle=None, bottom=None, gyrate=False):
    """Caps on both sides of a ring, a "prism" or an "antiprism"; the lower one turned by a side if asked."""
    above, m = cap(*top)
    height = {None: 0.0, "prism": 1.0, "antiprism": drum(m)}[middle]
    turn = np.pi / m if middle == "antiprism" else 0.0
    parts = [above, ring(m)] + ([ring(m, -height, turn)] if middle else [])
    if bottom:
        below, same = cap(*bottom)
        assert same == m
        turn += 2 * np.pi / m * gyrate
        c, s = np.cos(turn), np.sin(turn)
        parts.append(below @ np.array([[c, s, 0], [-s, c, 0], [0, 0, -1]]) - [0, 0, height])
    return np.vstack(parts)


def _capped_ones():
    p3, p4, p5 = (("pyramid", n) for n in (3, 4, 5))
    c3, c4, c5 = (("cupola", n) for n in (3, 4, 5))
    r = ("rotunda", 5)
    pr, an = "prism", "antiprism"
    yield from ((p4,), (p5,), (c3,), (c4,), (c5,), (r,))
    yield from ((p3, pr), (p4, pr), (p5, pr), (p4, an), (p5, an))
    yield from ((p3, None, p3), (p5, None, p5), (p3, pr, p3), (p4, pr, p4), (p5, pr, p5), (p4, an, p4))
    yield from ((c3, pr), (c4, pr), (c5, pr), (r, pr), (c3, an), (c4, an), (c5, an), (r, an))
    yield None  # 26: two prisms crosswise
    yield from ((c3, None, c3), (c4, None, c4), (c4, None, c4, True), (c5, None, c5), (c5, None, c5, True))
    yield from ((c5, None, r), (c5, None, r, True), (r, None, r), (c3, pr, c3), (c3, pr, c3, True))
    yield from ((c4, pr, c4, True), (c5, pr, c5), (c5, pr, c5, True), (c5, pr, r), (c5, pr, r, True))
    yield from (
        (r, pr, r),
        (r, pr, r, True),
        (c3, an, c3),
        (c4, an, c4),
        (c5, an, c5),
        (c5, an, r),
        (r, an, r),
    )


CAPPED = dict(enumerate(_capped_ones(), start=1))

# Others are solids with pyramids or cupolas on some faces, or with some cupolas turned or cut off.

ONE, OPPOSITE, ASKEW, THREE = "one", "opposite", "askew", "three"
AUGMENTED = {
    49: ("prism", 3, 4, ONE),
    50: ("prism", 3, 4, ASKEW),
    51: ("prism", 3, 4, THREE),
    52: ("prism", 5, 4, ONE),
    53: ("prism", 5, 4, ASKEW),
    54: ("prism", 6, 4, ONE),
    55: ("prism", 6, 4, OPPOSITE),
    56: ("prism", 6, 4, ASKEW),
    57: ("prism", 6, 4, THREE),
    58: ("uniform", "dodecahedron", 5, ONE),
    59: ("uniform", "dodecahedron", 5, OPPOSITE),
    60: ("uniform", "dodecahedron", 5, ASKEW),
    61: ("uniform", "dodecahedron", 5, THREE),
    64: ("johnson", 63, 3, ONE),
    65: ("uniform", "truncated tetrahedron", 6, ONE),
    66: ("uniform", "truncated cube", 8, ONE),
    67: ("uniform", "truncated cube", 8, OPPOSITE),
    68: ("uniform", "truncated dodecahedron", 10, ONE),
    69: ("uniform", "truncated dodecahedron", 10, OPPOSITE),
    70: ("uniform", "truncated dodecahedron", 10, ASKEW),
    71: ("uniform", "truncated dodecahedron", 10, THREE),
    87: ("johnson", 86, 4, ONE),
}
"""The solid, and which of its faces with that many sides get a cap."""

TURNED = {
    72: ("t", ONE),
    73: ("tt", OPPOSITE),
    74: ("tt", ASKEW),
    75: ("ttt", THREE),
    76: ("c", ONE),
    77: ("tc", OPPOSITE),
    78: ("tc", ASKEW),
    79: ("ttc", THREE),
    80: ("cc", OPPOSITE),
    81: ("cc", ASKEW),
    82: ("tcc", THREE),
    83: ("ccc", THREE),
}
"""Which cupolas of a rhombicosidodecahedron are turned and which are cut off."""


def chosen(directions, how):
    """One of these; two opposite ones; two that are next to opposite; or three such."""
    if how == ONE:
        return (0,)
    cosines = directions @ directions.T
    off = cosines[cosines > (-2 if how == OPPOSITE else -1 + 1e-9)].min()
    together = np.abs(cosines - off) < 1e-9
    groups = combinations(range(len(directions)), 3 if how == THREE else 2)
    return next(g for g in groups if all(together[i, j] for i, j in combinations(g, 2)))


def directions_of(points, faces):
    centers = np.array([points[face].mean(axis=0) for face in faces]) - points.mean(axis=0)
    return centers / np.linalg.norm(centers, axis=1)[:, None]


def augmented(points, faces):
    """A solid with a pyramid or cupola on each of these faces."""
    added = [points]
    for face in faces:
        m, corners = len(face), points[face]
        top, _ = cap("pyramid", m) if m < 6 else cap("cupola", m // 2)
        options = []
        for first in corners[:2]:
            center = corners.mean(axis=0)
            x = (first - center) / np.linalg.norm(first - center)
            z = np.cross(corners[1] - corners[0], corners[2] - corners[1])
            z /= np.linalg.norm(z)
            options.append(top @ np.array([x, np.cross(z, x), z]) + center)
        added.append(next(o for o in options if m < 6 or has_regular_faces(np.vstack([points, o]))))
    return np.vstack(added)


def turned(operations, how):
    """A rhombicosidodecahedron with cupolas turned by a side ("t") or cut off ("c")."""
    points = uniform("rhombicosidodecahedron")
    faces = [face for face in polygons(points) if len(face) == 5]
    directions = directions_of(points, faces)
    points, gone = points.copy(), []
    for k, operation in zip(chosen(directions, how), operations, strict=True):
        if operation == "c":
            gone.extend(faces[k])
        else:  # half a turn about its axis is half a side of the pentagon
            points[faces[k]] = (
                2 * np.outer(points[faces[k]] @ directions[k], directions[k]) - points[faces[k]]
            )
    return np.delete(points, gone, axis=0)


def diminished_icosahedron(how):
    points = uniform("icosahedron")
    return np.delete(points, chosen(points / np.linalg.norm(points[0]), how), axis=0)


# The last ones, of side 2: orbits of points under the mirrors x = 0 and y = 0, some also under a turn with a
# mirror.  Their unknown coordinates make some of the distances 2.


def mirrored(points):
    """All images of points under the mirrors x = 0 and y = 0."""
    return np.concatenate([orbit(np.array(x), (np.diag([-1, 1, 1]), np.diag([1, -1, 1]))) for x in points])


def both_ends(points):
    """Points and their images under a quarter turn about the z axis with a mirror z = 0."""
    return np.vstack([points, points @ np.array([[0, 1, 0], [-1, 0, 0], [0, 0, -1]])])


def solved(points_of, pairs, start):
    """The points at which these pairs are at the distance 2, near a rough start of the unknowns."""

    def missed(unknowns):
        points = np.array(points_of(*unknowns))
        return [np.linalg.norm(points[i] - points[j]) - 2 for i, j in pairs]

    return points_of(*fsolve(missed, start, xtol=1e-13))


def snub_disphenoid():
    points = solved(
        lambda b, c, d: [(1, 0, c), (0, b, d), (b, 0, -d)], [(0, 1), (1, 2), (0, 2)], (1.29, 1.57, 0.41)
    )
    return both_ends(mirrored(points[:2]))


def snub_square_antiprism():
    s = 0.5**0.5
    (_, _, c), (x, _, d) = solved(
        lambda r, c, d: [(2**0.5, 0, c), (s * r, s * r, d), (0, r, -d), (1, 1, -c)],
        [(0, 1), (1, 2), (1, 3)],
        (2.4, 1.34, 0.4),
    )[:2]
    square, wide = ring(4) * 2, ring(4, turn=np.pi / 4) * 2 * x
    half = np.vstack([square + np.array([0, 0, c]), wide + np.array([0, 0, d])])
    return np.vstack([half, half @ np.array([[s, s, 0], [-s, s, 0], [0, 0, -1]])])


def sphenocorona():
    return mirrored(
        solved(
            lambda a, b, c, d, e: [(0, 1, a), (b, 1, 0), (0, c, d), (1, 0, -e)],
            [(0, 1), (0, 2), (1, 2), (1, 3), (2, 3)],
            (1.05, 1.71, 1.58, -0.87, 1.58),
        )
    )


MEGACORONA = [(0, 1), (0, 2), (1, 2), (2, 4), (1, 4), (1, 3), (3, 4)]


def sphenomegacorona():
    return mirrored(
        solved(
            lambda a, b, c, d, e, f, g: [(0, 1, a), (b, 1, 0), (0, c, d), (1, 0, -e), (0, f, g)],
            MEGACORONA,
            (1.61, 1.19, 2.57, 0.36, 1.72, 1.71, -1.44),
        )
    )


def hebesphenomegacorona():
    return mirrored(
        solved(
            lambda a, b, c, d, e, f, g: [(1, 1, a), (b, 1, 0), (0, c, d), (1, 0, -e), (0, f, g)],
            MEGACORONA,
            (1.95, 1.43, 2.20, 0.71, 1.68, 1.7, -1.1),
        )
    )


def disphenocingulum():
    points = solved(
        lambda a, b, c, d, m: [(0, 1, a), (b, 1, m), (0, c, d), (1, b, -m), (c, 0, -d)],
        [(0, 1), (0, 2), (1, 2), (1, 3), (1, 4)],
        (2.21, 1.53, 2.26, 0.65, 0.93),
    )
    return both_ends(mirrored(points[:3]))


def bilunabirotunda():
    half = mirrored([(1, 1, PHI), (1 + PHI, 0, 1)])
    return np.vstack([half, half * [1, 1, -1], mirrored([(0, PHI, 0)])])


def triangular_hebesphenorotunda():
    """Twelve vertices of an icosidodecahedron around a triangle, and a hexagon."""
    points = 2 * uniform("icosidodecahedron")
    face = next(face for face in polygons(points) if len(face) == 3)
    corners = points[face]
    z = corners.sum(axis=0) / np.linalg.norm(corners.sum(axis=0))
    x = corners[0] - corners.mean(axis=0)
    x /= np.linalg.norm(x)
    points = points @ np.array([x, np.cross(z, x), z]).T
    points = points[np.argsort(-points[:, 2], kind="stable")[:12]]
    lowest = points[points[:, 2] < points[:, 2].min() + 1e-9]
    for turn in (0, np.pi / 6):
        hexagon = 2 * ring(6, turn=turn)
        across = np.linalg.norm((lowest[:, None] - hexagon)[..., :2], axis=2).min()
        solid = np.vstack([points, hexagon + np.array([0, 0, lowest[0, 2] - np.sqrt(4 - across**2)])])
        if across < 2 and has_regular_faces(solid / 2):
            return solid
    raise AssertionError("no hexagon fits")


SOLVED = {
    84: snub_disphenoid,
    85: snub_square_antiprism,
    86: sphenocorona,
    88: sphenomegacorona,
    89: hebesphenomegacorona,
    90: disphenocingulum,
    91: bilunabirotunda,
    92: triangular_hebesphenorotunda,
}


@cache
def johnson(number):
    """A Johnson solid by its number, 1 to 92."""
    if number == 26:  # two triangular prisms crosswise
        base = mirrored([(1, 1, 0)])
        return np.vstack([base, [(s, 0, 3**0.5) for s in (1, -1)], [(0, s, -(3**0.5)) for s in (1, -1)]]) / 2
    if number in CAPPED:
        return capped(*CAPPED[number])
    if number in TURNED:
        return turned(*TURNED[number])
    if number in SOLVED:
        return SOLVED[number]() / 2
    if number in (62, 63):
        return diminished_icosahedron({62: ASKEW, 63: THREE}[number])
    kind, which, sides, how = AUGMENTED[number]
    points = {"prism": prism, "uniform": uniform, "johnson": johnson}[kind](which)
    faces = [face for face in polygons(points) if len(face) == sides]
    if number == 64:  # the triangle whose neighbors are pentagons
        pentagons = np.concatenate([face for face in polygons(points) if len(face) == 5]).tolist()
        faces.sort(key=lambda face: -sum(pentagons.count(v) for v in face))
    return augmented(points, [faces[k] for k in chosen(directions_of(points, faces), how)])
