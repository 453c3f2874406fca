"""Reports of quasi-local energies, as JSON and text."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from isoembed.embedding.embedding import Embedding
from isoembed.errors import NotEmbedded
from isoembed.relativity.energies.embedded_surface import (
    CONVENTIONS,
    conventions,
    intrinsic_entries,
    space_report,
)
from isoembed.relativity.energies.energies import Energies
from isoembed.relativity.energies.smooth_energies import intrinsic_energies
from isoembed.relativity.horizons.conformal_multipoles import multipole_lines
from isoembed.relativity.horizons.curvature_check import CurvatureCheck
from isoembed.relativity.horizons.horizon_shape import shape_lines
from isoembed.relativity.horizons.spin import find_spin
from isoembed.relativity.horizons.stability_spectrum import spectrum_lines
from isoembed.relativity.spacetimes.surface_data import SurfaceData
from isoembed.surface.estimate import Estimate
from isoembed.surface.smooth_integrals import Lengths

SHOWN = {
    "area": "area",
    "integrated_mean_curvature": "int H dA, H = (k1 + k2)/2",
    "irreducible_mass": "irreducible mass",
    "christodoulou_mass": "Christodoulou mass",
    "dimensionless_spin": "dimensionless spin J / M^2",
    "hawking": "Hawking energy",
    "brown_york": "Brown-York energy",
    "liu_yau": "Kijowski-Liu-Yau energy",
    "wang_yau": "Wang-Yau energy",
}


def energy_table(report: dict[str, Any]) -> str:
    """Energies of a report with their errors, one per line, and its notes."""
    width = max(map(len, SHOWN.values()))
    lines = [report["name"], *_space_lines(report.get("space")), ""]
    for name, shown in SHOWN.items():
        if name == "wang_yau" and report.get("wang_yau_admissible") is False:
            shown = "E(tau), tau not admissible"
        if report.get(name) is not None:
            line = _line(shown, report[name], report["errors"][name], width)
            lines.append(line + _by_lengths(report, name))
    if spin := report.get("spin"):
        lines += _angular_momentum(spin, width)
        if spin["axis"]:
            turned = spin["axis_error"]
            lines.append(f"{'its axis':{width}}  {_triple(spin['axis'], turned)} +- {turned:.0e} radians")
            error = spin["error"] + turned * abs(spin["J"])
            about = "of K_ij about x, y and z" if "electromagnetic" in spin else "J about x, y and z"
            lines.append(f"{about:{width}}  {_triple(spin['vector'], error)}")
    lines += shape_lines(report)
    if multipoles := report.get("conformal_multipoles"):
        lines += multipole_lines(multipoles)
    lines += ["", *(f"note: {note}" for note in report["notes"])]
    lines.append(CONVENTIONS["units"])
    if check := report.get("curvature_check"):
        lines.append(check["message"])
    if horizon := report.get("horizon"):
        lines += _horizon_lines(horizon)
    return "\n".join(lines)


def _angular_momentum(spin: dict[str, Any], width: int) -> Iterator[str]:
    """Lines on J, for a charged surface with its parts from K_ij and from the electromagnetic field."""
    charged = "electromagnetic" in spin
    yield _line("J of K_ij" if charged else "angular momentum J", spin["J"], spin["error"], width)
    if charged and spin["total"] is None:
        yield f"{'J electromagnetic':{width}}  not known"
    elif charged:
        yield _line("J electromagnetic", spin["electromagnetic"], spin["error"], width)
        yield _line("angular momentum J", spin["total"], spin["error"], width)


def _space_lines(space: dict[str, Any] | None) -> Iterator[str]:
    """Line on the reference space; for Euclidean space only if another one was searched for."""
    if space is None:
        return
    if "least" in space:
        yield space["least"]["explanation"]
    elif space["curvature"]:
        yield f"in {space['name']} space of curvature {space['curvature']:.9g}"


def _horizon_lines(horizon: dict[str, Any]) -> Iterator[str]:
    """Lines on a horizon, from its file or the finder, and on its expansion."""
    if "points" in horizon:
        moment = "".join(
            f"{name} {horizon[name]:.9g}: " for name in ("time", "iteration") if horizon[name] is not None
        )
        yield (
            f"{moment}{horizon['points']} points, fitted to {horizon['misfit']:.1e} of a mean radius "
            f"{horizon['mean_coordinate_radius']:.6g} in coordinates"
        )
    if "stability" in horizon:
        stable = "stable, as outermost horizons are" if horizon["outer"] else "unstable, and so not outermost"
        yield (
            f"found in harmonics of degree {horizon['degree']}; the least eigenvalue of the stability "
            f"operator is {horizon['stability']:.6g} / R^2, R the areal radius: {stable}"
        )
    if horizon.get("outermost"):
        outermost = horizon["outermost"]
        yield f"no other horizon was found to enclose it ({outermost['evidence']}): {outermost['basis']}"
    if "stability_spectrum" in horizon:
        yield from spectrum_lines(horizon["stability_spectrum"])
    yield (
        f"the expansion of outgoing rays, 0 on a horizon, is at most "
        f"{horizon['largest_expansion']:.1e} +- {horizon['expansion_error']:.0e}"
        + ("" if horizon["marginal"] else ": it is not treated as a horizon of this geometry")
    )


def _line(shown: str, value: float, error: float, width: int) -> str:
    estimate = Estimate(value, error)
    return f"{shown:{width}}  {estimate.rounded:22} {estimate.plus_minus}"


def _by_lengths(report: dict[str, Any], name: str) -> str:
    """Standard deviation of a number, if that of the lengths is known."""
    sigma = report.get("deviation", {}).get(name)
    return "" if sigma is None else f", +- {sigma:.1e} by the lengths"


def _triple(x: list[float], error: float) -> str:
    """Three numbers with a common error, to one digit more than is significant in the largest."""
    size = max(map(abs, x)) or 1.0
    digits = Estimate(size, error).digits
    return "(" + ", ".join(f"{round(c / size, digits) * size + 0.0:.{digits}g}" for c in x) + ")"


def unembedded_report(data: SurfaceData, error: NotEmbedded) -> dict[str, Any]:
    """Report of a surface that was not embedded: the reason, and energies that require no embedding."""
    spin = find_spin(data)
    return {
        "status": "not embedded",
        **error.report,
        "hindrance": error.embedding.hindrance or None,
        "name": data.name,
        **intrinsic_energies(data, spin).report,
        **intrinsic_entries(data, spin),
        "space": space_report(error.embedding.space),
    }


def mesh_report(
    embedding: Embedding,
    energies: Energies,
    lengths: Lengths | None,
    name: str,
    deviation: dict[str, float | None] | None = None,
) -> dict[str, Any]:
    """Report of the energies of a mesh, from `mesh_energies` and `mesh_deviation`."""
    return {
        "status": "embedded",
        "message": embedding.message,
        "name": name,
        **energies.report,
        "lengths": lengths or "not known",
        "space": space_report(embedding.space),
        "embedding": {
            "vertices": embedding.triangulation.n_vertices,
            "residual": embedding.residual,
            "volume": embedding.volume,
        },
        "conventions": conventions(embedding.space),
        **({} if deviation is None else {"deviation": deviation}),
    }


def checked_report(report: dict[str, Any], check: CurvatureCheck | None) -> dict[str, Any]:
    """Report with the check of the curvature against that in the file, if there is one."""
    notes = report["notes"] + list(check.notes if check else ())
    return {**report, "notes": notes, "curvature_check": check and check.report}
