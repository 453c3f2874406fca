"""A hyperbolic surface of genus 2 with 10 vertices in hyperbolic space.

Z. Zou, "Vertex-minimal hyperbolic origami 2-torus", arXiv:2509.18668.
"""

from __future__ import annotations

from decimal import Decimal, localcontext
from math import pi
from typing import TYPE_CHECKING

import numpy as np

from isoembed import InvalidMetric, NotEmbedded, PolyhedralMetric, embed
from isoembed.metric.curvature import area, deficits
from isoembed.surface.intersection import self_intersections
from reproduction import plots
from reproduction.arrays import Floats, Indices
from reproduction.published import Published, rows
from reproduction.section import Section

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# In Klein's ball, from the paper's notebook: x and y have four decimals, the heights make the angles 2 pi.
VERTICES = (
    ("0.7315", "0.0202", "0.28688022781563440615364787558404"),
    ("-0.316", "0.5792", "-0.2252919753182150895621576631383"),
    ("0.3426", "-0.592", "-0.22851917827575874828458055465199"),
    ("-0.4323", "-0.592", "-0.23272863894943839798113773793091"),
    ("-0.7303", "0.04", "-0.22959077803009316431117678104662"),
    ("0.1464", "0.6149", "0.13588682780065943976868637469759"),
    ("-0.5154", "0.0395", "0.46102777383206591809202059407883"),
    ("0.6649", "-0.1156", "-0.22651115997910956793325851442687"),
    ("0.152", "0.2539", "-0.23985732806740791506457015735734"),
    ("-0.03", "0.0606", "0.64396456614136038886542316026992"),
)
FACES = """
    017 021 036 049 053 064 078 085 092 124 137 146 158 165 183 238 263 274 287 296 347 354 459 569
"""
DIGITS = 50  # of the sums of angles
DECIMALS = 2  # of the heights with which Newton's method begins
STEP = 1e-6  # of differences
SECTIONS = 8  # in the picture


def study() -> Section:
    """The surface: its angles, its crossings, and its heights computed again."""
    klein, faces = coordinates(), triangles()
    metric = hyperbolic(klein, faces)
    heights, steps = solved_heights(klein, faces)
    numbers = [
        Published(
            f"height of vertex {k}", f"{Decimal(z):.13f}", float(found), 1e-15, float(z),
            "the paper's 32 digits",
        )
        for k, ((_, _, z), found) in enumerate(zip(VERTICES, heights, strict=True))
    ]  # fmt: skip
    degrees = sorted(np.bincount(faces.ravel()).tolist(), reverse=True)
    return Section.of(
        "hyperbolic-torus",
        figures={"hyperbolic-torus": picture(klein, faces)},
        numbers={
            "heights": [number.numbers for number in numbers],
            "deficits": deficits(metric).tolist(),
            "closure": float(closure(faces)),
            "reach": reach(klein, faces),
        },
        rows=rows(numbers),
        degrees=", ".join(map(str, degrees)),
        deficit=float(np.abs(deficits(metric)).max()),
        closure=float(closure(faces)),
        digits=DIGITS,
        area_error=area(metric) / (4 * pi) - 1,
        crossings=len(self_intersections(faces, klein)),
        reach=reach(klein, faces),
        agreeing=sum(number.agrees for number in numbers),
        apart=max(abs(number.ours - number.second) for number in numbers),
        decimals=DECIMALS,
        steps=steps,
        shortest=float(metric.lengths.min()),
        longest=float(metric.lengths.max()),
        refusal=refusal(metric),
    )


def coordinates() -> Floats:
    """The vertices (10, 3) in Klein's ball."""
    return np.array(VERTICES, dtype=np.float64)


def triangles() -> Indices:
    """The faces (24, 3)."""
    return np.array([[int(letter) for letter in face] for face in FACES.split()])


def hyperbolic(klein: Floats, faces: Indices) -> PolyhedralMetric:
    """The metric of hyperbolic triangles with these corners."""
    return PolyhedralMetric.from_mesh(klein, faces, curvature=-1.0, model="projective")


def closure(faces: Indices) -> Decimal:
    """How far angles are from sums of 2 pi, in 50 digits: products of ``cos + i sin`` at a vertex, less 1.

    The angle at a of a triangle a, b, c is that of ``b + <a, b> a`` and ``c + <a, c> a`` on the hyperboloid.
    """
    with localcontext() as context:
        context.prec = DIGITS
        points = [_on_hyperboloid(tuple(Decimal(x) for x in vertex)) for vertex in VERTICES]
        products = [(Decimal(1), Decimal(0))] * len(points)
        for face in faces:
            for k in range(3):
                a, b, c = (points[face[(k + j) % 3]] for j in range(3))
                u, v = (tuple(p + _dot(a, x) * q for p, q in zip(x, a, strict=True)) for x in (b, c))
                cosine = _dot(u, v) / (_dot(u, u) * _dot(v, v)).sqrt()
                sine = (1 - cosine**2).sqrt()
                re, im = products[face[k]]
                products[face[k]] = re * cosine - im * sine, re * sine + im * cosine
        return max(((re - 1) ** 2 + im**2).sqrt() for re, im in products)


def _on_hyperboloid(x: tuple[Decimal, ...]) -> tuple[Decimal, ...]:
    w = 1 / (1 - sum((a * a for a in x), Decimal(0))).sqrt()
    return (*(w * a for a in x), w)


def _dot(a: tuple[Decimal, ...], b: tuple[Decimal, ...]) -> Decimal:
    """Minkowski's product, the last coordinate that of time."""
    *space, time = (p * q for p, q in zip(a, b, strict=True))
    return sum(space, Decimal(0)) - time


def solved_heights(klein: Floats, faces: Indices) -> tuple[Floats, int]:
    """The heights at which all angles sum to 2 pi, from rounded ones by Newton's method, and its steps."""

    def misses(z: Floats) -> Floats:
        return deficits(hyperbolic(np.column_stack([klein[:, :2], z]), faces))

    z = klein[:, 2].round(DECIMALS)
    for step in range(1, 10):
        slopes = [(misses(z + STEP * e) - misses(z - STEP * e)) / (2 * STEP) for e in np.eye(len(z))]
        change = np.linalg.solve(np.column_stack(slopes), misses(z))
        z = z - change
        if np.abs(change).max() < 1e-12:
            return z, step
    raise NotEmbedded("the angles of the hyperbolic surface of genus 2 do not become 2 pi", None)


def reach(klein: Floats, faces: Indices) -> float:
    """How far vertices may move in Klein's ball while no face can touch another, by bisection."""
    low, high = 0.0, 0.1
    while high - low > 1e-3 * high:
        middle = 0.5 * (low + high)
        if len(self_intersections(faces, klein, middle)):
            high = middle
        else:
            low = middle
    return low


def refusal(metric: PolyhedralMetric) -> str:
    """What `embed` says to the lengths."""
    try:
        embed(metric)
    except InvalidMetric as error:
        return str(error)
    return "embedded"


def picture(klein: Floats, faces: Indices) -> Figure:
    """Sections of the surface at equal steps of height in Klein's ball, whose lines are straight."""
    from matplotlib.patches import Circle

    figure = plots.blank(4.4)
    levels = np.linspace(klein[:, 2].min(), klein[:, 2].max(), SECTIONS + 2)[1:-1]
    for ax, level in zip(figure.subplots(2, SECTIONS // 2).flat, levels, strict=True):
        for triangle in klein[faces]:
            ends = _cut(triangle, float(level))
            ax.plot(*ends.T, color=plots.BLUE, linewidth=1.2)
        ax.add_patch(Circle((0, 0), np.sqrt(1 - level**2), fill=False, color=plots.STONE, linewidth=0.8))
        ax.set_title(f"z = {level:.2f}", color=plots.INK, fontsize=plots.TEXT)
        plots.bare(ax)
    return figure


def _cut(triangle: Floats, level: float) -> Floats:
    """The ends (2, 2) of the line in which a horizontal plane cuts a triangle, or none (0, 2)."""
    above = triangle[:, 2] - level
    ends = [
        triangle[k - 1] + above[k - 1] / (above[k - 1] - above[k]) * (triangle[k] - triangle[k - 1])
        for k in range(3)
        if above[k - 1] * above[k] < 0
    ]
    return np.array(ends).reshape(-1, 3)[:, :2]
