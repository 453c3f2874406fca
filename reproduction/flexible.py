"""Flexible polyhedra followed along their flexes, and how many realizations a triangulation has.

K. Kim and C. D. Santangelo, arXiv:2505.07696; R. Bricard (1897); K. Steffen (1978); R. Alexander (1985);
R. Connelly, I. Sabitov and A. Walz (1997).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import pi, sqrt
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.optimize import brentq
from scipy.spatial import ConvexHull

from isoembed import Aim, Embedding, PolyhedralMetric, Triangulation, certify, embed, realizations
from isoembed.surface.alignment import aligned
from isoembed.surface.curvature import dihedral_angles
from isoembed.surface.intersection import self_intersections
from isoembed.surface.measures import edge_lengths, volume
from isoembed.surface.rigidity import LengthSystem, length_residuals
from reproduction import plots
from reproduction.arrays import Floats, Indices
from reproduction.published import Published, rows
from reproduction.section import Section

if TYPE_CHECKING:
    from matplotlib.figure import Figure

OCTAHEDRON = [(0, 1, 2), (0, 2, 4), (0, 4, 5), (0, 5, 1), (3, 2, 1), (3, 4, 2), (3, 5, 4), (3, 1, 5)]
STEFFEN = [
    *((0, 1, 5), (1, 2, 5), (2, 3, 5), (3, 0, 5), (0, 3, 4), (3, 2, 4)),
    *((8, 1, 6), (8, 2, 1), (8, 7, 2), (8, 6, 7), (4, 7, 6), (4, 2, 7)),
    *((6, 1, 0), (0, 4, 6)),
]
STEFFEN_VOLUME = 17 * 11 * sqrt(41.5) / 6  # of the tetrahedron 0, 1, 4, 6: the two bent octahedra have none
BRANCHES = (-1, 1, -1, 1)  # sides on which the apexes lie without crossings; the mirror images do it, too
RIGID = "616.515"  # volume of another realization of Steffen's lengths
STEP = 0.02  # mean edge lengths, of the vertex that moves farthest
MOST_REAL = 8  # realizations of an octahedron up to motions and reflections: 16 complex ones
BASE = 0.1 * np.random.default_rng(0).standard_normal((6, 3)) + [
    *([0, 0, 1], [0, 0, -1], [1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0])
]


@dataclass(frozen=True, eq=False)
class Flex:
    """A polyhedron followed along its flex.

    Attributes
    ----------
    name : str
    faces : ndarray of int, shape (F, 3)
    lengths : ndarray, shape (E,)
    path : ndarray, shape (n, V, 3)
        Its positions, one step after the other.
    """

    name: str
    faces: Indices
    lengths: Floats
    path: Floats

    @property
    def record(self) -> dict[str, Any]:
        """What stays and what changes."""
        t, unit = Triangulation(self.faces), float(self.lengths.mean())
        volumes = np.array([volume(self.faces, x) for x in self.path])
        # Where faces pass through each other at an edge, its angle goes on beyond pi.
        angles = np.unwrap([dihedral_angles(t, x) for x in self.path], axis=0)
        means = 0.5 * angles @ self.lengths
        misses = [length_residuals(t, x, self.lengths) for x in self.path]
        scale = float(np.linalg.norm(self.path[0] - self.path[0].mean(axis=0), axis=1).max())
        return {
            "name": self.name,
            "positions": len(self.path),
            "missed": float(np.abs(misses).max()) / unit,
            "turned": float(np.degrees(np.ptp(angles, axis=0).max())),
            "volume": float(volumes[0]),
            "volume_varies": float(np.ptp(volumes)) / scale**3,
            "mean_curvature": float(means[0]),
            "mean_curvature_varies": float(np.ptp(means)) / scale,
            "embedded": int(sum(not len(self_intersections(self.faces, x)) for x in self.path)),
        }


def study(*, steps: int, stacked: int, starts: int) -> Section:
    """Flexes of Bricard's and Steffen's polyhedra, and counts of realizations.

    Parameters
    ----------
    steps : int
        Along each flex.
    stacked : int
        Vertices on the octahedron at most: each doubles the realizations.
    starts : int
        Random surfaces from which realizations of octahedra are sought.
    """
    flexes = [
        followed("Bricard, line-symmetric", OCTAHEDRON, line_symmetric(), steps),
        followed("Bricard, plane-symmetric", OCTAHEDRON, plane_symmetric(), steps),
        followed("Steffen", STEFFEN, steffen(pi), steps),
    ]
    records = [flex.record for flex in flexes]
    found, wide, other = found_again(), embedded_range(), rigid_realization()
    apart = away_from_closed_form(flexes[-1].path)
    numbers = [
        Published(
            "volume of Steffen's polyhedron",
            f"{STEFFEN_VOLUME:.3f}",
            records[-1]["volume"],
            1e-11,
            STEFFEN_VOLUME,
            "17 * 11 sqrt(41.5) / 6, the tetrahedron between the octahedra",
        ),
        Published(
            "volume of the rigid realization of the same lengths",
            RIGID,
            other["volume"],
            1e-9,
            other["again"],
            "Newton's method from vertices off by 0.1",
        ),
        Published(
            "degrees through which Steffen's polyhedron moves without crossings",
            "",
            wide,
            1e-8,
            range_by_contact(),
            "roots: the edges that meet at the ends span a plane",
        ),
    ]
    counts = [_stacked(k) for k in range(stacked + 1)]
    octahedra = [_octahedron(seed, starts) for seed in range(3)]
    return Section.of(
        "flexible",
        figures={"flexible": picture()},
        numbers={
            "published": [number.numbers for number in numbers],
            "flexes": records,
            "found_again": found,
            "rigid": other,
            "stacked": counts,
            "octahedra": octahedra,
        },
        rows=rows(numbers),
        flexes=records,
        bricard=records[:2],
        step=STEP,
        steffen=records[-1],
        found=found,
        wide=wide,
        other=other,
        apart=apart,
        counts=counts,
        right=sum(one["found"] == one["expected"] for one in counts),
        tried=len(counts),
        octahedra=octahedra,
        most=max(one["found"] for one in octahedra),
        bound=MOST_REAL,
        starts=starts,
    )


def followed(name: str, faces: Sequence[tuple[int, int, int]], start: Floats, steps: int) -> Flex:
    """Follow the flex of a polyhedron: steps along the null vector of J, and Newton's back to the lengths."""
    t = Triangulation(faces)
    lengths, path = edge_lengths(t.edges, start), [start]
    system, step = LengthSystem(t), STEP * float(lengths.mean())
    direction = None
    for _ in range(steps):
        motion = _null_vector(t, path[-1], lengths)
        if direction is not None and np.vdot(motion, direction) < 0:
            motion = -motion
        direction, x = motion, path[-1] + step * motion / np.linalg.norm(motion, axis=1).max()
        x = _back(system, x, lengths)
        path.append(x)
    return Flex(name, np.asarray(faces), lengths, np.array(path))


def _back(system: LengthSystem, x: Floats, lengths: Floats) -> Floats:
    """The surface that Newton's method leads to, with a little damping, as J may be singular."""
    for _ in range(20):
        r = length_residuals(system.triangulation, x, lengths)
        if np.abs(r).max() < 1e-15 * lengths.mean():
            break
        x = x - system.step(x, lengths, r, mu=1e-9)
    return x


def _null_vector(t: Triangulation, x: Floats, lengths: Floats) -> Floats:
    """The motion (V, 3) that changes no length to first order and is no rigid one."""
    (a, b), edges = t.edges.T, np.arange(len(lengths))
    J = np.zeros((len(lengths), *x.shape))
    J[edges, a] = (x[a] - x[b]) / lengths[:, None]
    J[edges, b] = -J[edges, a]
    moved = x - x.mean(axis=0)
    rigid = [np.tile(axis, (len(x), 1)) for axis in np.eye(3)]
    rigid += [np.cross(axis, moved) for axis in np.eye(3)]
    held = np.vstack([J.reshape(len(lengths), -1), np.reshape(rigid, (6, -1))])
    return np.asarray(np.linalg.svd(held)[2][-1].reshape(x.shape))


def line_symmetric() -> Floats:
    """Bricard's first type: opposite vertices change places when it is turned half about an axis."""
    half = np.random.default_rng(0).standard_normal((3, 3))
    return np.vstack([half, half * [-1, -1, 1]])


def plane_symmetric() -> Floats:
    """Bricard's second type: a plane through two opposite vertices, the others are mirror images in pairs."""
    (a, b), (c, d) = np.random.default_rng(1).standard_normal((2, 2, 3))
    flat, mirror = [1, 1, 0], [1, 1, -1]
    return np.array([a, b, c * flat, a * mirror, b * mirror, d * flat])


def steffen(t: float, branches: Sequence[int] = BRANCHES) -> Floats:
    """Steffen's polyhedron in closed form: t is the angle of the edge 0-6 about the axis 1-4.

    Vertices 1, 2, 4 are at rest; 0 and 6 turn about the axis, and each of the others has given distances
    from three of these.
    """
    B, E, C = np.zeros(3), np.array([11.0, 0, 0]), np.array([5.5, sqrt(100 - 5.5**2), 0])
    far = sqrt(144 - 5.5**2)
    half = np.arcsin(17 / 2 / far)
    A, G = (np.array([5.5, far * np.cos(t + s), far * np.sin(t + s)]) for s in (-half, half))
    D, H = (_at_distances((X, C, E), (10, 12, 5), branches[i]) for X, i in ((A, 0), (G, 2)))
    P, Q = (_at_distances((X, B, C), (10, 5, 12), branches[i]) for X, i in ((A, 1), (G, 3)))
    x = np.array([A, B, C, D, E, P, G, H, Q])
    return x if volume(np.array(STEFFEN), x) > 0 else x * [1, 1, -1]


def _at_distances(centers: Sequence[Floats], radii: Sequence[float], side: int) -> Floats:
    """The point at given distances from three points, on one side of their plane."""
    p, q, r = centers
    (a, b, c), d = radii, np.linalg.norm(q - p)
    e_x = (q - p) / d
    i = (r - p) @ e_x
    e_y = r - p - i * e_x
    j = np.linalg.norm(e_y)
    e_y = e_y / j
    x = (a * a - b * b + d * d) / (2 * d)
    y = (a * a - c * c + i * i + j * j - 2 * i * x) / (2 * j)
    return np.asarray(
        p + x * e_x + y * e_y + side * sqrt(max(0.0, a * a - x * x - y * y)) * np.cross(e_x, e_y)
    )


def embedded_range() -> float:
    """The angle, in degrees, through which Steffen's polyhedron moves without crossings, by bisection."""

    def end(free: float, crossed: float) -> float:
        for _ in range(40):
            middle = (free + crossed) / 2
            crosses = bool(len(self_intersections(STEFFEN, steffen(middle))))
            free, crossed = (free, middle) if crosses else (middle, crossed)
        return free

    return float(np.degrees(end(pi, pi + 0.6) - end(pi, pi - 0.6)))


def range_by_contact() -> float:
    """The same from the edges that meet at its ends: 3-5 with 0-4, and 7-8 with 1-6, span a plane there."""

    def spanned(t: float, a: int, b: int, c: int, d: int) -> float:
        x = steffen(t)
        return float(np.linalg.det([x[b] - x[a], x[d] - x[c], x[c] - x[a]]))

    start = brentq(spanned, pi - 0.4, pi, args=(3, 5, 0, 4), xtol=1e-14)
    stop = brentq(spanned, pi, pi + 0.4, args=(7, 8, 1, 6), xtol=1e-14)
    return float(np.degrees(stop - start))


def away_from_closed_form(path: Floats) -> float:
    """The largest distance of the followed positions from those of the closed form at the same angle.

    Where an apex falls into the plane of its three neighbors, the motion goes on to the other side.
    """
    worst, sides = 0.0, [(a, -a, b, -b) for a in (-1, 1) for b in (-1, 1)]
    for x in path:
        axis = (x[4] - x[1]) / np.linalg.norm(x[4] - x[1])
        middle, base = (x[0] + x[6]) / 2 - x[1], x[2] - x[1]
        across = base - (base @ axis) * axis
        across /= np.linalg.norm(across)
        t = float(np.arctan2(middle @ np.cross(axis, across), middle @ across))
        away = [np.linalg.norm(aligned(steffen(s, b), x) - x, axis=1).max() for s in (t, -t) for b in sides]
        worst = max(worst, float(min(away)))
    return worst


def nearest(metric: PolyhedralMetric, vertices: Floats) -> Embedding:
    """The realization nearest to a surface among those that are found."""
    return embed(metric, method=Aim(which=tuple((x, y, z) for x, y, z in vertices.tolist())))


def found_again() -> dict[str, Any]:
    """The flexible surface by `embed`, from a position rounded to one digit."""
    metric = PolyhedralMetric(STEFFEN, edge_lengths(Triangulation(STEFFEN).edges, steffen(pi)))
    rough = steffen(pi + 0.1).round(0)
    found = nearest(metric, rough)
    return {"volume": found.volume, "residual": found.residual, "said": certify(found).reason.split(":")[0]}


def rigid_realization() -> dict[str, Any]:
    """What the default method makes of Steffen's lengths, with its certificate."""
    metric = PolyhedralMetric(STEFFEN, edge_lengths(Triangulation(STEFFEN).edges, steffen(pi)))
    found = embed(metric)
    rough = found.vertices + 0.1 * np.random.default_rng(2).standard_normal(found.vertices.shape)
    again = _back(LengthSystem(metric.triangulation), rough, metric.lengths)
    return {
        "volume": found.volume,
        "again": abs(volume(found.faces, again)),
        "certified": certify(found).certified,
    }


def stacked_octahedron(count: int, height: float = 0.05) -> tuple[Floats, Indices]:
    """An octahedron with low pyramids on some of its faces."""
    rng, x = np.random.default_rng(0), list(BASE)
    hull = ConvexHull(BASE)
    faces = [(a, b, c) if _outside(BASE[[a, b, c]]) else (a, c, b) for a, b, c in hull.simplices.tolist()]
    for _ in range(count):
        corners = faces.pop(0)
        triangle = np.array([x[i] for i in corners])
        normal = np.cross(triangle[1] - triangle[0], triangle[2] - triangle[0])
        up = height * (1 + 0.3 * rng.random()) / np.linalg.norm(normal)
        x.append(rng.dirichlet((8, 8, 8)) @ triangle + up * normal)
        a, b, c = corners
        faces += [(a, b, len(x) - 1), (b, c, len(x) - 1), (c, a, len(x) - 1)]
    return np.array(x), np.array(faces)


def _outside(triangle: Floats) -> bool:
    return bool(np.linalg.det(triangle) > 0)


def _stacked(count: int) -> dict[str, Any]:
    """Realizations near the octahedron with so many pyramids, each of which may point in."""
    x, faces = stacked_octahedron(count)
    metric = PolyhedralMetric.from_mesh(x, faces)
    found = embed(metric)
    near = realizations(found)
    sigma, _, _ = LengthSystem(metric.triangulation).smallest_singular_values(
        found.vertices, metric.lengths, count + 1
    )
    return {
        "pyramids": count,
        "vertices": len(x),
        "edges": len(metric.lengths),
        "soft": int((sigma < 0.2).sum()),
        "expected": 2**count,
        "found": len(near.surfaces),
        "certified": sum(certify(one).certified for one in near.surfaces),
        "bezout": f"2^{3 * len(x) - 9}",
    }


def _octahedron(seed: int, starts: int) -> dict[str, Any]:
    """Realizations of a generic octahedron that Newton's method finds from random surfaces."""
    rng = np.random.default_rng(seed)
    x = BASE[[0, 2, 3, 1, 4, 5]] + 0.1 * rng.standard_normal((6, 3))
    metric = PolyhedralMetric.from_mesh(x, OCTAHEDRON)
    found: list[Embedding] = []
    for _ in range(starts):
        near = nearest(metric, rng.standard_normal(x.shape))
        for one in (near, *near.others):
            if one.converged and all(one.distance(known) > 1e-6 for known in found):
                found.append(one)
    return {"seed": seed, "found": len(found), "certified": sum(certify(one).certified for one in found)}


def picture() -> Figure:
    """Steffen's polyhedron at the ends and in the middle of its way, and what changes."""
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection  # type: ignore[import-untyped]

    half = np.radians(embedded_range() / 2)
    figure = plots.blank(5.6)
    parts: Any = figure.subfigures(2, 1, height_ratios=(3, 2))
    upper, lower = parts
    for k, t in enumerate((pi - half, pi, pi + half)):
        axes: Any = upper.add_subplot(1, 3, k + 1, projection="3d")
        x = steffen(float(t))
        colors = [plots.SERIES[c] for c in (5, 5, 5, 5, 4, 4, 2, 2, 2, 2, 4, 4, 3, 3)]
        solid = Poly3DCollection(
            x[STEFFEN], facecolors=colors, edgecolors=plots.INK, linewidths=0.7, alpha=0.8
        )
        axes.add_collection3d(solid)
        middle = x.mean(axis=0)
        for set_limits, m in zip((axes.set_xlim, axes.set_ylim, axes.set_zlim), middle, strict=True):
            set_limits(m - 7, m + 7)
        axes.view_init(elev=18, azim=-62)
        axes.set_axis_off()
        axes.set_title(f"{np.degrees(t - pi):+.1f} degrees", color=plots.INK, fontsize=plots.TEXT)
    _changes(lower.add_subplot())
    return figure


def _changes(axes: Any) -> None:
    angles = np.radians(np.linspace(-13, 13, 41)) + pi
    t = Triangulation(STEFFEN)
    turned = np.degrees(np.array([dihedral_angles(t, steffen(float(s))) for s in angles]))
    axes.plot(np.degrees(angles - pi), turned - turned[len(angles) // 2], color=plots.BLUE, linewidth=0.8)
    plots.dress(axes, "angle of the edge 0-6 in degrees", "degrees", "changes of the 21 dihedral angles")
