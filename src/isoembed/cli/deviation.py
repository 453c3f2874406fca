"""``isoembed deviation``: how far a surface may be off because its lengths are."""

import argparse
from pathlib import Path

import numpy as np

from isoembed.arrays import Floats
from isoembed.cli.numbers import read_numbers
from isoembed.cli.options import add_json_option, add_merge_option, add_output_option
from isoembed.cli.screen import UsageError, print_json, print_out
from isoembed.cli.status import OK
from isoembed.io import MESH_ENDINGS, SURFACE_ENDINGS, check_output, read_surface, write_atomically
from isoembed.io.files import Writer, ending
from isoembed.io.registry import METRIC_ENDINGS
from isoembed.io.surface import mesh_writer, surface_data
from isoembed.linalg import SingularMatrix
from isoembed.plot import PICTURE_ENDINGS, picture_writer
from isoembed.plot.quantity import vertex_deviation
from isoembed.surface.deviation import Deviation
from isoembed.surface.embedding import Embedding


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options of ``isoembed deviation``."""
    endings = " ".join((*METRIC_ENDINGS, *MESH_ENDINGS))
    parser.add_argument("surface", type=Path, metavar="SURFACE", help=f"vertices and triangles ({endings})")
    parser.add_argument(
        "--length-error",
        required=True,
        metavar="E",
        help="standard deviation of the lengths, whose errors are independent, in their unit: a number, or a "
        ".npy file with one for each edge",
    )
    add_output_option(
        parser,
        f"{' '.join(SURFACE_ENDINGS)}: the surface with the standard deviations at its vertices; "
        f"{' '.join(PICTURE_ENDINGS)}: a picture of how far they move",
    )
    add_merge_option(parser)
    add_json_option(parser)


def run(options: argparse.Namespace) -> int:
    """Estimate the deviations; return the exit status."""
    output = options.output
    if output:
        check_output(output, (*SURFACE_ENDINGS, *PICTURE_ENDINGS))
        if output.resolve() == options.surface.resolve():
            raise UsageError(f"the output is the input {output}")
    errors = _errors(options.length_error)
    surface = read_surface(options.surface, merge=options.merge)
    try:
        found = surface.deviation(errors)
    except SingularMatrix:
        raise UsageError(
            f"{options.surface} is not infinitesimally rigid, as where a vertex is flat: to first order, "
            "errors of the lengths move it without bound"
        ) from None
    if output:
        write_atomically({output: _writer(output, surface, found)})
    if options.json:
        print_json(found.report)
    else:
        print_out(_summary(surface, found))
    return OK


def _errors(text: str) -> Floats:
    if ending(text) == ".npy":
        return read_numbers(Path(text))
    try:
        return np.array(float(text))
    except ValueError:
        raise UsageError(f"--length-error {text} is neither a number nor a .npy file") from None


def _writer(path: Path, surface: Embedding, found: Deviation) -> Writer:
    if ending(path) in PICTURE_ENDINGS:
        return picture_writer(path, surface, color=vertex_deviation(found))
    data = surface_data(surface)
    data["vertex_deviation"], data["mean_curvature_deviation"] = found.vertices, found.mean_curvature
    return mesh_writer(path, faces=surface.faces, **data)


def _summary(surface: Embedding, found: Deviation) -> str:
    lines = [
        f"{name:12}{value:.12g} +- {error:.2g}"
        for name, value, error in (
            ("area", surface.area, found.area),
            ("volume", surface.volume, found.volume),
            ("int H dA", surface.integrated_mean_curvature, found.integrated_mean_curvature),
        )
    ]
    for name, values, place, unit in (
        ("vertices", found.vertices, "vertex", ""),
        ("normals", found.normals, "face", " radians"),
        ("dihedral", found.dihedral_angles, "edge", " radians"),
        ("H", found.mean_curvature, "vertex", ""),
    ):
        worst = int(np.argmax(values))
        lines.append(
            f"{name:12}+- {np.sqrt(np.mean(values**2)):.2g}{unit}, "
            f"at most {values[worst]:.2g} (at {place} {worst})"
        )
    known = f", the last four known to {100 * found.relative_error:.2g} %" if found.probes else ""
    return "\n".join([*lines, f"one standard deviation, to first order{known}"])
