"""Reports of energies: of embedded surfaces, of those that do not embed, of triangles and of horizons."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

from isoembed.errors import InvalidMetric, InvalidParameter, NoMinimum, NotEmbedded
from isoembed.relativity.energies.embedded import CONVENTIONS, EmbeddedSurface, embed_surface
from isoembed.relativity.energies.energies import Energies
from isoembed.relativity.energies.quadrature import intrinsic_energies
from isoembed.relativity.energies.wang_yau_energy import wang_yau
from isoembed.relativity.energies.wang_yau_result import WangYau
from isoembed.relativity.horizons.curvature_check import CurvatureCheck
from isoembed.relativity.horizons.horizon import Horizon
from isoembed.relativity.horizons.horizon_shape import shape_lines, shape_report
from isoembed.relativity.horizons.spin import find_spin, spin_report
from isoembed.relativity.spacetimes.surface_data import SurfaceData
from isoembed.surface.embedding import Embedding
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
    """Energies of a report with their errors, a line each, and its notes."""
    width = max(map(len, SHOWN.values()))
    lines = [report["name"], ""]
    for name, shown in SHOWN.items():
        if report.get(name) is not None:
            lines.append(_line(shown, report[name], report["errors"][name], width))
    if spin := report.get("spin"):
        lines.append(_line("angular momentum J", spin["J"], spin["error"], width))
        if spin["axis"]:
            turned = spin["axis_error"]
            lines.append(f"{'its axis':{width}}  {_triple(spin['axis'], turned)} +- {turned:.0e} radians")
            error = spin["error"] + turned * abs(spin["J"])
            lines.append(f"{'J about x, y and z':{width}}  {_triple(spin['vector'], error)}")
    lines += shape_lines(report)
    lines += ["", *(f"note: {note}" for note in report["notes"])]
    lines.append(CONVENTIONS["units"])
    if check := report.get("curvature_check"):
        lines.append(check["message"])
    return "\n".join(lines)


def _line(shown: str, value: float, error: float, width: int) -> str:
    return f"{shown:{width}}  {Estimate(value, error).rounded:22} +- {error:.0e}"


def _triple(x: list[float], error: float) -> str:
    """Three numbers with one error, to one digit more than that leaves of the largest."""
    size = max(map(abs, x)) or 1.0
    digits = Estimate(size, error).digits
    return "(" + ", ".join(f"{round(c / size, digits) * size + 0.0:.{digits}g}" for c in x) + ")"


def unembedded_report(data: SurfaceData, error: NotEmbedded) -> dict[str, Any]:
    """Report of a surface that does not embed: why, and the energies that need no embedding."""
    spin = find_spin(data)
    return {
        "status": "not embedded",
        "message": str(error),
        "name": data.name,
        **intrinsic_energies(data, spin).report,
        "spin": spin_report(data, spin),
        **shape_report(data, spin),
    }


def mesh_report(
    embedding: Embedding, energies: Energies, lengths: Lengths | None, name: str
) -> dict[str, Any]:
    """Report of the energies of triangles, from `mesh_energies` with these lengths."""
    return {
        "status": "embedded",
        "message": embedding.message,
        "name": name,
        **energies.report,
        "lengths": lengths or "not known",
        "embedding": {
            "vertices": embedding.triangulation.n_vertices,
            "residual": embedding.residual,
            "volume": embedding.volume,
        },
        "conventions": CONVENTIONS,
    }


def wang_yau_report(surface: EmbeddedSurface) -> tuple[dict[str, Any], WangYau | None]:
    """Report of an embedded surface with its least Wang-Yau energy, or why there is none; and that energy."""
    report = surface.report
    try:
        found = wang_yau(surface.data, "optimal", embedding=surface.embedding)
    except (InvalidParameter, NotEmbedded, NoMinimum) as error:
        report["wang_yau"] = report["errors"]["wang_yau"] = None
        report["notes"].append(str(error))
        return report, None
    report["wang_yau"], report["errors"]["wang_yau"] = found.energy.value, found.energy.error
    report["error_estimate"] = max(report["error_estimate"], found.energy.error)
    report["minimum"] = found.report
    report["notes"] += found.notes
    return report, found


@dataclass(frozen=True)
class EmbeddedHorizon:
    """A horizon of a sequence with its embedding; as a string, its energies and what the file was like.

    Attributes
    ----------
    surface : EmbeddedSurface or None
        None where there is no embedding, or the file is refused: the message of the report says why.
    report : dict
        Plain numbers, for JSON.
    """

    surface: EmbeddedSurface | None
    report: dict[str, Any]

    @classmethod
    def refused(cls, name: str, error: Exception) -> EmbeddedHorizon:
        """The place in a sequence of what is no surface, or has no metric."""
        return cls(None, {"status": "refused", "message": str(error), "name": name})

    def __str__(self) -> str:
        horizon, table = self.report["horizon"], energy_table(self.report)
        if not horizon:
            return table
        if "points" in horizon:
            moment = "".join(
                f"{name} {horizon[name]:.9g}: " for name in ("time", "iteration") if horizon[name] is not None
            )
            table += (
                f"\n{moment}{horizon['points']} points, fitted to {horizon['misfit']:.1e} of a mean radius "
                f"{horizon['mean_coordinate_radius']:.6g} in coordinates"
            )
        if "stability" in horizon:
            stable = "stable, as outermost horizons are" if horizon["outer"] else "unstable: an inner horizon"
            table += (
                f"\nfound in harmonics of degree {horizon['degree']}; the least eigenvalue of the stability "
                f"operator is {horizon['stability']:.6g} / R^2, R the areal radius: {stable}"
            )
        return (
            f"{table}\nthe expansion of outgoing rays, 0 on a horizon, is at most "
            f"{horizon['largest_expansion']:.1e} +- {horizon['expansion_error']:.0e}"
            + ("" if horizon["marginal"] else ": in this geometry it is no horizon")
        )


def embed_horizons(
    horizons: Iterable[Horizon], vertices: int = 1000, *, wang_yau: bool = False
) -> Iterator[EmbeddedHorizon]:
    """Embeddings of a sequence of horizons, each from the one before or, where that fails, from a mesh.

    Parameters
    ----------
    horizons : iterable of Horizon
    vertices : int
        Of the mesh.
    wang_yau : bool
        Whether to report the least Wang-Yau energy, too.

    Yields
    ------
    EmbeddedHorizon
        One for each; those that do not embed, or are refused, do not end the sequence.
    """
    before: EmbeddedSurface | None = None
    for horizon in horizons:
        try:
            before = _embedded(horizon.data, before, vertices)
        except NotEmbedded as error:
            yield EmbeddedHorizon(None, _of_horizon(horizon, unembedded_report(horizon.data, error)))
        except (InvalidMetric, InvalidParameter) as error:
            yield EmbeddedHorizon.refused(horizon.data.name, error)
        else:
            report = wang_yau_report(before)[0] if wang_yau else before.report
            yield EmbeddedHorizon(before, _of_horizon(horizon, report))


def checked_report(report: dict[str, Any], check: CurvatureCheck | None) -> dict[str, Any]:
    """The report of a surface with how its curvature compares with that in its file, if it is there."""
    notes = report["notes"] + list(check.notes if check else ())
    return {**report, "notes": notes, "curvature_check": check and check.report}


def _of_horizon(horizon: Horizon, report: dict[str, Any]) -> dict[str, Any]:
    """The report with what the file says."""
    return {**checked_report(report, horizon.curvature_check), "horizon": horizon.facts}


def _embedded(data: SurfaceData, before: EmbeddedSurface | None, vertices: int) -> EmbeddedSurface:
    if before is not None:
        try:
            return embed_surface(data, start=before)
        except NotEmbedded:
            pass
    return embed_surface(data, vertices=vertices)
