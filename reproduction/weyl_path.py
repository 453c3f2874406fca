"""Weyl's problem along paths of metrics, and the embedding of a Ricci flow.

G. Gao, K. Hu, B. Li and G. Zhang, arXiv:2602.18722, examples 6.1 and 6.2; R. S. Hamilton (1988).
"""

# ruff: noqa: N806 (A, C, G, J, T as the paper writes them)
from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import pi
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.polynomial import legendre
from scipy.integrate import solve_ivp

from isoembed import embed
from isoembed.gallery import Ellipsoid
from isoembed.meshing.sphere import fibonacci_directions
from isoembed.plot import Panel, Scale, placed_figure
from isoembed.smooth import AxisymmetricEmbedding, PulledBack, SphereMesh, embed_smooth, triangulate_metric
from isoembed.surface.alignment import aligned
from reproduction import plots
from reproduction.arrays import Floats, Indices
from reproduction.section import Section

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Map = Callable[[Floats], Floats]

AXES = np.array([2.0, 2.0, 3.0])  # of the ellipsoid of example 6.1; the unit sphere is at t = 1
TIMES = (0.0, 0.25, 0.5, 0.75, 1.0)
THEIRS = {  # example 6.2 as their notebook printed it: order 1, h = 0.1, steps of 0.05, 4,221 unknowns
    "unknowns": 4221,
    "initial": "1.309e-02",
    "metric": "1.795e-01",
    "L2": "7.961e-03",
}
ELEMENTS = (  # example 6.1 at t = 1 by their method, run with NGSolve: order, unknowns, errors of r and of g
    (1, 945, 2.0864e-1, 1.2758e-1),
    (1, 1866, 1.0714e-1, 7.0183e-2),
    (1, 3651, 5.3812e-2, 3.8801e-2),
    (2, 3762, 6.1588e-2, 1.0250e-1),
    (2, 7446, 3.1757e-2, 5.3422e-2),
    (2, 14586, 1.6020e-2, 2.6743e-2),
    (3, 8457, 2.2747e-3, 3.8324e-3),
    (3, 16746, 8.6078e-4, 1.3976e-3),
    (3, 32811, 2.9483e-4, 4.6302e-4),
)
AGAIN = {"unknowns": 4164, "L2": "7.74e-03", "metric": "1.790e-01"}  # example 6.2 by the same run
WAIST = 0.45  # of the Ricci flow's first metric, exp(2 w) times the round one with w = WAIST P_2(cos(theta))
MODES = 32
SHOWN = (0.0, 0.1, 0.25, 0.5, 0.8)  # times of the flow, over that at which the surface vanishes
LATE = (0.9, 0.99)  # likewise, between which its rate is measured
DRAWN = 1000  # vertices of its surfaces in the film
END_OF_FILM = 0.95  # likewise; later the surface is too small to be seen


def study(*, sizes: Sequence[float], vertices: int, images: int) -> Section:
    """The path of ellipsoids, the surface of revolution, and a Ricci flow.

    Parameters
    ----------
    sizes : sequence of float
        Mean edge lengths h, falling, of the polyhedra on the ellipsoid (2, 2, 3).
    vertices : int
        Of the polyhedron of example 6.2.
    images : int
        Of the film of the Ricci flow.
    """
    path = [_along(t) for t in TIMES]
    meshes = [_polyhedron(h) for h in sizes]
    h, errors = np.log([[one["h"], one["error"]] for one in meshes]).T
    order = float(np.polyfit(h, errors, 1)[0])
    revolution = _revolution(vertices)
    elements = [
        {
            "order": k,
            "unknowns": n,
            "L2": L2,
            "metric": defect,
            "ours": _at_the_sphere(n // 3) if k == 1 else None,
        }
        for k, n, L2, defect in ELEMENTS
    ]
    flow = RicciFlow.solved()
    frames = [_frame(flow, share) for share in SHOWN]
    mesh = triangulate_metric(PulledBack(_identity), DRAWN)
    filmed = [flow.embedded(share, mesh) for share in np.linspace(0, END_OF_FILM, images).tolist()]
    late = [flow.deviation(share) for share in LATE]
    rate = float(np.diff(np.log(late))[0] / np.diff(np.log1p(-np.array(LATE)))[0])
    frame = frames[2]
    smooth = flow.embedded_by_harmonics(frame["share"])
    return Section.of(
        "weyl-path",
        figures={
            "weyl-path": picture(meshes, flow),
            "ricci-flow": meridians(flow),
            "ricci-flow-film": film(filmed),
        },
        numbers={
            "path": path,
            "polyhedra": meshes,
            "order": order,
            "revolution": revolution,
            "elements": elements,
            "flow": frames,
            "rate": rate,
            "by_harmonics": smooth,
            "film": [{"share": one.share, "away": one.away} for one in filmed],
        },
        path=path,
        worst=max(one["error"] for one in path),
        meshes=meshes,
        first=meshes[0],
        last=meshes[-1],
        order=order,
        one=revolution,
        theirs=THEIRS,
        again=AGAIN,
        elements=[{**one, "ours": f"{one['ours']:.2e}" if one["ours"] else ""} for one in elements],
        linear=elements[2],
        cubic=elements[-1],
        frames=frames,
        area_error=max(abs(one["area_error"]) for one in frames),
        rate=rate,
        vanishes=flow.end,
        start=frames[0],
        end=frames[-1],
        apart=abs(smooth - frame["mean_curvature"]),
        share=frame["share"],
        waist=WAIST,
        images=images,
        away=max(one.away for one in filmed),
    )


def turned() -> Floats:
    """A rotation, so that no axis of the ellipsoid is one of the coordinates."""
    return np.asarray(np.linalg.qr(np.random.default_rng(0).standard_normal((3, 3)))[0])


def linear_map(t: float) -> Floats:
    """The matrix A of the surface u -> A u at t: (1 - t) (2, 2, 3) + t (1, 1, 1) on turned axes."""
    R = turned()
    return np.asarray(R @ np.diag((1 - t) * AXES + t) @ R.T)


def _along(t: float) -> dict[str, Any]:
    """The embedding by harmonics of the metric at t, and how far it is from the exact surface."""
    A = linear_map(t)
    found = embed_smooth(PulledBack(lambda u: np.tile(A, (len(u), 1, 1))))
    u = fibonacci_directions(2000)
    a, b, c = ((1 - t) * AXES + t).tolist()
    away = aligned(found.points(u), u @ A.T) - u @ A.T
    return {
        "t": t,
        "degree": found.harmonics.degree,
        "error": float(np.linalg.norm(away, axis=1).max()),
        "mean_curvature_error": found.integrated_mean_curvature
        - Ellipsoid((a, b, c)).integrated_mean_curvature,
    }


def _polyhedron(h: float) -> dict[str, Any]:
    """The convex polyhedron with geodesic lengths of about h on the ellipsoid at t = 0."""
    A = linear_map(0.0)
    mesh = triangulate_metric(PulledBack(lambda u: np.tile(A, (len(u), 1, 1))), size=h)
    found = embed(mesh.metric, method="alexandrov")
    exact = mesh.directions @ A.T
    away = np.linalg.norm(aligned(found.vertices, exact) - exact, axis=1)
    return {
        "h": found.metric.mean_length,
        "vertices": len(exact),
        "error": float(np.sqrt((away**2).mean() * Ellipsoid((2.0, 2.0, 3.0)).area)),
        "largest": float(away.max()),
        "residual": found.residual,
    }


def _at_the_sphere(vertices: int) -> float:
    """The error of example 6.1 at t = 1 by a polyhedron, in L2 of the ellipsoid, lifted along rays."""
    A, B = linear_map(0.0), linear_map(1.0)

    def ellipsoid(p: Floats) -> Floats:
        return np.tile(A, (len(p), 1, 1))

    def sphere(p: Floats) -> Floats:
        return np.tile(B, (len(p), 1, 1))

    mesh = triangulate_metric(PulledBack(ellipsoid), vertices)
    found = embed(mesh.measured(PulledBack(sphere)), method="alexandrov")
    exact = mesh.directions @ B.T
    at = aligned(found.vertices, exact)
    return errors_of_elements(mesh.directions, found.faces, at, lambda p: p @ B.T, sphere, ellipsoid)[0]


def profile_of_revolution(p: Floats) -> Floats:
    """The surface at t = 1 of example 6.2, at points p of the unit sphere."""
    q = -0.32 + 0.48 * (1 - p[:, 2] ** 2) ** 2
    return np.column_stack([(1 + q)[:, None] * p[:, :2], p[:, 2]])


def _differential(p: Floats) -> Floats:
    """Its differential (n, 3, 3)."""
    z = p[:, 2]
    q, dq = -0.32 + 0.48 * (1 - z**2) ** 2, -1.92 * z * (1 - z**2)
    J = np.zeros((len(p), 3, 3))
    J[:, 0, 0] = J[:, 1, 1] = 1 + q
    J[:, 0, 2], J[:, 1, 2], J[:, 2, 2] = p[:, 0] * dq, p[:, 1] * dq, 1
    return J


def _identity(p: Floats) -> Floats:
    return np.tile(np.eye(3), (len(p), 1, 1))


def _revolution(vertices: int) -> dict[str, Any]:
    """Example 6.2 by a polyhedron with as many unknowns, and by harmonics; errors in the paper's norms."""
    metric, sphere = PulledBack(_differential), PulledBack(_identity)
    mesh = triangulate_metric(sphere, vertices)
    found = embed(mesh.measured(metric))
    exact = profile_of_revolution(mesh.directions)
    L2, defect = errors_of_elements(
        mesh.directions, mesh.faces, aligned(found.vertices, exact), profile_of_revolution, _differential
    )
    _, initial = errors_of_elements(mesh.directions, mesh.faces, mesh.directions, lambda p: p, _identity)
    _, interpolated = errors_of_elements(
        mesh.directions, mesh.faces, exact, profile_of_revolution, _differential
    )
    smooth = embed_smooth(metric)
    u = fibonacci_directions(2000)
    away = aligned(smooth.points(u), profile_of_revolution(u)) - profile_of_revolution(u)
    return {
        "vertices": vertices,
        "unknowns": 3 * vertices,
        "L2": L2,
        "metric": defect,
        "initial": initial,
        "interpolated": interpolated,
        "residual": found.residual,
        "harmonics": float(np.linalg.norm(away, axis=1).max()),
        "degree": smooth.harmonics.degree,
    }


def errors_of_elements(
    u: Floats, faces: Indices, vertices: Floats, surface: Map, differential: Map, reference: Map | None = None
) -> tuple[float, float]:
    """Errors in L2 of linear elements and of their metric, over the unit sphere and in its metric.

    Or over a surface with the differential `reference`, and in its metric.

    The triangles have the corners u (V, 3) on the sphere, to which their points are projected, and `vertices`
    (V, 3) of the embedding; `surface` and `differential` are the exact map.
    """
    corners, images = u[faces], vertices[faces]
    sides, moved = (x[:, 1:] - x[:, :1] for x in (corners, images))  # (F, 2, 3)
    metric_h = np.einsum("fix,fjx->fij", moved, moved)
    squares = np.zeros(2)
    for weight, place in _rule():
        x = np.einsum("c,fcx->fx", place, corners)
        size = np.linalg.norm(x, axis=1)
        p = x / size[:, None]
        lifted = (sides - np.einsum("fix,fx->fi", sides, p)[..., None] * p[:, None]) / size[:, None, None]
        based = lifted if reference is None else np.einsum("fxy,fiy->fix", reference(p), lifted)
        G = np.einsum("fix,fjx->fij", based, based)
        pushed = np.einsum("fxy,fiy->fix", differential(p), lifted)
        D = np.linalg.solve(G, metric_h - np.einsum("fix,fjx->fij", pushed, pushed))
        dA = 0.5 * weight * np.sqrt(np.linalg.det(G))
        away = np.einsum("c,fcx->fx", place, images) - surface(p)
        squares += dA @ np.column_stack([(away**2).sum(axis=1), np.einsum("fij,fji->f", D, D)])
    L2, defect = np.sqrt(squares)
    return float(L2), float(defect)


def _rule() -> list[tuple[float, Floats]]:
    """Weights and barycentric places on a triangle, exact to degree 5 (Radon)."""
    root = np.sqrt(15.0)
    rule = [(9 / 40, np.full(3, 1 / 3))]
    for sign in (-1, 1):
        inner, weight = (6 + sign * root) / 21, (155 + sign * root) / 1200
        rule += [(weight, np.roll([1 - 2 * inner, inner, inner], k)) for k in range(3)]
    return rule


@dataclass(frozen=True, eq=False)
class RicciFlow:
    """The Ricci flow dg/dt = -2 K g of g = exp(2 w) times the round metric, w a function of x = cos(theta).

    w_t = exp(-2 w) (Delta w - 1), in Legendre polynomials, by an implicit method.

    Attributes
    ----------
    end : float
        When the surface vanishes: by Gauss and Bonnet the area falls by 8 pi per unit of time.
    w : callable
        The coefficients (MODES,) at a time over `end`.
    """

    end: float
    w: Callable[[float], Floats]

    @classmethod
    def solved(cls) -> RicciFlow:
        """Up to 99.5 % of its time."""
        x, weights = legendre.leggauss(2 * MODES)
        to_values = legendre.legvander(x, MODES - 1)
        degree = np.arange(MODES)
        to_modes = (degree + 0.5)[:, None] * to_values.T * weights
        start = np.zeros(MODES)
        start[2] = WAIST
        end = float(2 * pi * weights @ np.exp(2 * to_values @ start)) / (8 * pi)

        to_laplacian = -to_values * degree * (degree + 1)

        def rates(_: float, w: Floats) -> Floats:
            return np.asarray(to_modes @ (np.exp(-2 * to_values @ w) * (to_laplacian @ w - 1)))

        def slopes(_: float, w: Floats) -> Floats:
            change = to_laplacian - 2 * (to_laplacian @ w - 1)[:, None] * to_values
            return np.asarray(to_modes @ (np.exp(-2 * to_values @ w)[:, None] * change))

        found = solve_ivp(
            rates,
            (0.0, 0.995 * end),
            start,
            method="Radau",
            jac=slopes,
            rtol=1e-10,
            atol=1e-12,
            dense_output=True,
        )
        return cls(end, lambda share: np.asarray(found.sol(share * end)))

    def profile(self, share: float) -> AxisymmetricEmbedding:
        """The surface of revolution at a time over `end`."""
        w = self.w(share)

        def factor(theta: Floats) -> Floats:
            return np.asarray(np.exp(2 * legendre.legval(np.cos(theta), w)))

        return AxisymmetricEmbedding.from_components(factor, lambda theta: np.sin(theta) ** 2 * factor(theta))

    def deviation(self, share: float) -> float:
        """The range of K A / 4 pi."""
        least, greatest = _extremes(self.profile(share))
        return greatest - least

    def embedded_by_harmonics(self, share: float) -> float:
        """Integral of H dA of the spectral embedding, which is given the tensor at unit vectors only."""
        return embed_smooth(Conformal(self.w(share))).integrated_mean_curvature

    def embedded(self, share: float, mesh: SphereMesh) -> Embedded:
        """The surface at a time over `end` by harmonics, drawn with the triangles of a mesh."""
        found = embed_smooth(Conformal(self.w(share)))
        u, profile = mesh.directions, self.profile(share)
        theta = np.arccos(u[:, 2])
        around = u[:, :2] / np.sin(theta)[:, None]
        exact = np.column_stack([profile.rho(theta)[:, None] * around, profile.z(theta)])
        vertices = aligned(found.points(u), exact)
        radius = np.sqrt(profile.area / (4 * pi))
        away = float(np.linalg.norm(vertices - exact, axis=1).max() / radius)
        return Embedded(share, Panel(vertices, mesh.faces, radius * found.mean_curvature(u)), away)


@dataclass(frozen=True, eq=False)
class Conformal:
    """The metric exp(2 w) times the round one, w by coefficients in Legendre polynomials of cos(theta)."""

    w: Floats

    def tensor(self, u: Floats) -> Floats:
        """At unit vectors u (n, 3)."""
        factor = np.exp(2 * legendre.legval(u[:, 2], self.w))
        return np.asarray(factor[:, None, None] * (np.eye(3) - u[:, :, None] * u[:, None, :]))


@dataclass(frozen=True, eq=False)
class Embedded:
    """A surface of the flow.

    Attributes
    ----------
    share : float
        Time over that at which the surface vanishes.
    panel : Panel
        The surface, colored by mean curvature times areal radius.
    away : float
        The largest distance from the surface of revolution, over the areal radius.
    """

    share: float
    panel: Panel
    away: float


def _frame(flow: RicciFlow, share: float) -> dict[str, Any]:
    """The embedding at a time of the flow."""
    profile = flow.profile(share)
    least, greatest = _extremes(profile)
    left = 8 * pi * flow.end * (1 - share)
    return {
        "share": share,
        "area": profile.area,
        "area_error": profile.area / left - 1,
        "least": least,
        "greatest": greatest,
        "mean_curvature": profile.integrated_mean_curvature,
        "ratio": profile.integrated_mean_curvature / np.sqrt(4 * pi * profile.area),
    }


def picture(meshes: Sequence[dict[str, Any]], flow: RicciFlow) -> Figure:
    """Errors of the polyhedra against h, and the curvature along the Ricci flow."""
    figure = plots.blank(3.2)
    left, right = figure.subplots(1, 2)
    plots.dress(left, "h", "error in L2", "ellipsoid (2, 2, 3), polyhedra")
    h, errors = (np.array([one[name] for one in meshes]) for name in ("h", "error"))
    left.loglog(h, errors, color=plots.BLUE, marker="o")
    left.loglog(h, 0.6 * errors[-1] * (h / h[-1]) ** 2, color=plots.INK, linewidth=0.7)
    plots.note(left, "$h^2$", (h[0], 0.6 * errors[-1] * (h[0] / h[-1]) ** 2), (-24, -16))
    left.set_xticks(h, [f"{x:.2g}" for x in h])
    left.set_xticks([], minor=True)
    plots.dress(right, "t / T", "$K\\,A\\,/\\,4\\pi$", "Ricci flow, least and greatest curvature")
    shares = np.linspace(0, 0.95, 20)
    extremes = np.array([_extremes(flow.profile(float(share))) for share in shares])
    right.plot(shares, extremes, color=plots.VERMILION)
    right.axhline(0.0, color=plots.INK, linewidth=0.8)
    return figure


def _extremes(profile: AxisymmetricEmbedding) -> tuple[float, float]:
    """The least and the greatest K A / 4 pi."""
    K = profile.gaussian_curvature(np.linspace(0, pi, 401)) * profile.area / (4 * pi)
    return float(K.min()), float(K.max())


def meridians(flow: RicciFlow) -> Figure:
    """Meridians of the flow's surfaces, side by side."""
    figure = plots.blank(2.6)
    axes = figure.subplots(1, len(SHOWN), sharex=True, sharey=True)
    theta = np.linspace(0, pi, 200)
    for ax, share in zip(axes, SHOWN, strict=True):
        profile = flow.profile(share)
        rho, z = profile.rho(theta), profile.z(theta)
        ax.fill(np.concatenate([z, z[::-1]]), np.concatenate([rho, -rho[::-1]]), color=plots.PALE)
        ax.plot(np.concatenate([z, z[::-1]]), np.concatenate([rho, -rho[::-1]]), color=plots.BLUE)
        ax.set_title(f"t = {share:g} T", color=plots.INK, fontsize=plots.TEXT)
        plots.bare(ax)
    return figure


def film(surfaces: Sequence[Embedded]) -> list[Figure]:
    """The flow's surfaces one after the other, all to one scale."""
    scale = Scale.of([one.panel for one in surfaces])
    label = "mean curvature times areal radius"
    return [
        placed_figure(one.panel, label=label, caption=f"t = {one.share:.2f} T", scale=scale)
        for one in surfaces
    ]
