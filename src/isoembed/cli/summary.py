"""Summary of an embedding for the terminal."""

import math
from collections.abc import Mapping
from typing import Any

from isoembed.embedding.embedding import Embedding
from isoembed.surface.estimate import Estimate

INTEGRALS = {"area": "area", "volume": "volume", "integrated_mean_curvature": "int H dA"}
"""Integrals of a surface, and their names in text."""
ARRAYS = (
    ("vertices", "vertices", "vertex", ""),
    ("normals", "normals", "face", " radians"),
    ("dihedral_angles", "dihedral", "edge", " radians"),
    ("mean_curvature", "H", "vertex", ""),
)
"""Changes of a surface: attribute, name in text, element that has one, and unit."""


def why_undetermined(nonlinearity: float | None) -> str:
    """Reason for a volume without standard deviation, by nonlinearity (None or infinite if J is singular).

    Errors of the lengths may be large, or that of one length, or the surface soft.
    """
    if nonlinearity is None or math.isinf(nonlinearity):
        return "the surface is not infinitesimally rigid"
    return "the errors of the lengths, or one of them, are too large for a first-order estimate"


def summary(
    embedding: Embedding, found: Mapping[str, Any], *, stages: bool = False, failed: bool = False
) -> str:
    """Summary of a report, printed by ``isoembed embed`` without an output file.

    After a failure the message is omitted, as it is printed as the error.
    """
    size, residual = found["input"], found["residual"]
    convexity, smoothness = found["convexity"], found["smoothness"]
    bending = "int H^2 dA" if "sheet" in found else "bending energy"
    lines = [
        f"{embedding.status}: the best attempt" if failed else f"{found['status']}: {found['message']}",
        "",
        f"method      {found['method']}, tolerance {found['tolerance']:.0e}",
        *_space(found["space"]),
        f"input       {size['vertices']} vertices, {size['edges']} edges, {size['faces']} faces, "
        f"{size['negative_deficits']} negative deficits",
        f"residual    {_error(residual['max'])} max, {residual['mean']:.2e} mean, {residual['std']:.2e} std "
        "(in mean edge lengths)",
        f"convexity   {convexity['concave_edges']} concave edges, {convexity['inverted_vertices']} inverted "
        f"and {convexity['partially_inverted_vertices']} partially inverted vertices",
        f"smoothness  {smoothness['rough_edges']} edges bent against their neighborhood, "
        f"roughness {_short(smoothness['roughness'])}, {bending} {_short(smoothness['bending_energy'])}",
        f"rigidity    smallest singular value {_short(smoothness['smallest_singular_value'])}",
        f"proof       {found['certificate']['reason']}",
        *_sheet(found.get("sheet")),
        f"area        {measure(found, 'area')}",
        *(
            []
            if "sheet" in found and found["volume"] is None
            else [f"volume      {measure(found, 'volume')}"]
        ),
        f"int H dA    {measure(found, 'integrated_mean_curvature')}   with H = (k1 + k2)/2",
    ]
    if stages and embedding.stages:
        width = max(len("total"), *(len(stage.name) for stage in embedding.stages))
        lines += ["", f"{'stage':{width}}  seconds  iterations  factorizations"]
        rows = [(s.name, s.seconds, s.iterations, s.factorizations) for s in embedding.stages]
        rows.append(("total", *(sum(column) for column in list(zip(*rows, strict=True))[1:])))
        lines += [
            f"{name:{width}}  {seconds:7.2f}  {iterations:10d}  {factorizations:14d}"
            for name, seconds, iterations, factorizations in rows
        ]
    return "\n".join(lines)


def _sheet(sheet: Mapping[str, Any] | None) -> list[str]:
    """Line for a surface with boundary, or of higher genus."""
    if sheet is None:
        return []
    sizes = [f"of {size} edges" for size in sheet["boundaries"]]
    return [
        f"sheet       boundary {sheet['condition']}, {' and '.join(sizes) or 'none'}, "
        f"genus {sheet['genus']}, {bending(sheet)}"
    ]


def bending(sheet: Mapping[str, Any]) -> str:
    """Energy of a surface with boundary or of higher genus, and its distance from a minimum, if known."""
    left = "" if sheet["imbalance"] is None else f", imbalance {sheet['imbalance']:.0e}"
    return f"int k1^2 + k2^2 dA {sheet['second_form_energy']:.6g}{left}"


def _space(space: Mapping[str, Any]) -> list[str]:
    """Line for a space other than R^3."""
    return (
        [f"space       {space['name']}, of curvature {space['curvature']:.12g}"] if space["curvature"] else []
    )


def _error(value: float | None) -> str:
    return "infinite" if value is None else f"{value:.2e}"


def _number(value: float | None) -> str:
    return "beyond the range of numbers" if value is None else f"{value:.12g}"


def measure(report: Mapping[str, Any], name: str) -> str:
    """Number and, if the lengths have errors, its standard deviation, rounded accordingly."""
    value = report[name]
    if "deviation" not in report:
        return _number(value)
    sigma = report["deviation"][name]
    if sigma is None:
        known = _number(value) if value is None else f"{value:.3g}"
        return f"{known} +- not determined: {why_undetermined(report['deviation']['volume_nonlinearity'])}"
    if value is None:
        return f"{_number(value)} +- {sigma:.2g}"
    return f"{Estimate(value, sigma).rounded} +- {sigma:.2g}"


def _short(value: float | None) -> str:
    return "not computed" if value is None else f"{value:.4g}"
