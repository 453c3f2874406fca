"""``isoembed surface``: triangulation of a closed-form surface, and its metric."""

import argparse
from dataclasses import Field, fields
from typing import Any, get_args, get_type_hints

from isoembed.cli.console import OK, UsageError, print_aside, print_out
from isoembed.cli.options import add_output_option, add_quiet_option
from isoembed.cli.outputs import written
from isoembed.gallery import SURFACES, Surface, ZoneSurface, triangulate
from isoembed.io import (
    METRIC_ENDINGS,
    SURFACE_ENDINGS,
    check_output,
    mesh_writer,
    metric_writer,
    write_atomically,
)
from isoembed.io.files import ending
from isoembed.metric.polyhedral import PolyhedralMetric

EXAMPLES = (
    "isoembed surface --list",
    "isoembed surface ellipsoid --axes 3 2 1 --vertices 100 -o metric.npz",
)


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options of ``isoembed surface``: a subcommand per surface, an option per field."""
    parser.add_argument("--list", action="store_true", help="list the surfaces and their options")
    names = parser.add_subparsers(title="surfaces", metavar="NAME", dest="name")
    for name, surface in SURFACES.items():
        purpose = _purpose(surface)
        options = names.add_parser(name, help=purpose, description=purpose)
        options.allow_abbrev = False
        types = get_type_hints(surface)
        for field in fields(surface):  # type: ignore[arg-type]
            _add_option(options, field, types[field.name])
        options.add_argument(
            "--vertices", type=int, required=True, metavar="N", help="number of vertices, at least 12"
        )
        options.add_argument(
            "--irregular",
            type=int,
            metavar="SEED",
            help="irregular triangles on well-spaced random points (default: nearly equilateral ones)",
        )
        add_output_option(
            options,
            f"{' '.join(METRIC_ENDINGS)}: the metric alone; "
            f"{' '.join(name for name in SURFACE_ENDINGS if name not in METRIC_ENDINGS)}: the mesh",
            required=True,
        )
        add_quiet_option(options, default=argparse.SUPPRESS)


def run(options: argparse.Namespace) -> int:
    """Write the metric or the mesh; return the exit status."""
    if options.list:
        width = max(len(name) for name in SURFACES)
        lines = (f"{name:{width}}  {_purpose(kind)}{_defaults(kind)}" for name, kind in SURFACES.items())
        print_out("\n".join(lines))
        return OK
    if options.name is None:
        raise UsageError(f"which surface? There are {', '.join(SURFACES)}")
    check_output(options.output, SURFACE_ENDINGS)
    surface, vertices, faces = _meshed(options)
    metric = PolyhedralMetric.from_mesh(vertices, faces)
    if ending(options.output) in METRIC_ENDINGS:
        writer = metric_writer(options.output, metric)
    else:
        writer = mesh_writer(options.output, vertices, faces)
    write_atomically({options.output: writer})
    print_aside(
        f"{surface!r}, {metric.triangulation.n_vertices} vertices; the smooth surface has "
        f"area {surface.area:.12g}, {_integrals(surface)} with H = (k1 + k2)/2\n"
        f"{written(options, options.output)}"
    )
    return OK


def _integrals(surface: Surface | ZoneSurface) -> str:
    """Text with the enclosed volume of a surface, or its bending energies."""
    if isinstance(surface, Surface):
        return f"volume {surface.volume:.12g}, int H dA {surface.integrated_mean_curvature:.12g}"
    return f"int k1^2 + k2^2 dA {surface.second_form_energy:.12g}, int H^2 dA {surface.bending_energy:.12g}"


def _meshed(options: argparse.Namespace) -> tuple[Surface | ZoneSurface, Any, Any]:
    kind = SURFACES[options.name]
    values = {field.name: getattr(options, field.name) for field in fields(kind)}  # type: ignore[arg-type]
    try:
        surface = kind(**{name: tuple(v) if isinstance(v, list) else v for name, v in values.items()})
        return surface, *triangulate(surface, options.vertices, irregular=options.irregular)
    except ValueError as error:
        raise UsageError(str(error)) from None


def _add_option(parser: argparse.ArgumentParser, field: Field[Any], type_: Any) -> None:
    count = len(get_args(type_))
    default = _shown(field.default)
    parser.add_argument(
        f"--{field.name.replace('_', '-')}",
        dest=field.name,
        type=int if type_ is int else float,
        nargs=count or None,
        default=field.default,
        metavar=field.name[0].upper(),
        help=f"{field.metadata['help']} (default {default})",
    )


def _purpose(surface: type[Surface | ZoneSurface]) -> str:
    return (surface.__doc__ or "").partition("\n")[0].rstrip(".")


def _defaults(surface: type[Surface | ZoneSurface]) -> str:
    options = (f"--{f.name.replace('_', '-')} {_shown(f.default)}" for f in fields(surface))  # type: ignore[arg-type]
    return f" ({', '.join(options)})"


def _shown(default: Any) -> str:
    return " ".join(f"{x:g}" for x in default) if isinstance(default, tuple) else f"{default:g}"
