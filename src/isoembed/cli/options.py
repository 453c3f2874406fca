"""Options shared by several commands: input and output, space, horizon quantities, batch runs."""

import argparse
import re
from collections.abc import Callable, Collection
from pathlib import Path
from typing import Any, Literal, TypeVar

from isoembed.cli.console import UsageError
from isoembed.io import MESH_ENDINGS, METRIC_ENDINGS
from isoembed.metric.given_mesh import MERGING
from isoembed.space import Euclidean, Space
from isoembed.typed_numbers import number

T = TypeVar("T")
DEFAULT = 1000  # vertices
READABLE = " ".join((*METRIC_ENDINGS, *MESH_ENDINGS))
"""Endings of files with vertices and triangles."""
OF_RUNS = ("jobs", "scheduler", "shard", "chunk", "retry", "force")


class _Once(argparse.Action):
    """An option that may be given only once, as a second value would replace the first."""

    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,
        value: Any,
        name: str | None = None,
    ) -> None:
        if getattr(namespace, self.dest) is not None:
            parser.error(f"argument {name}: given twice: {getattr(namespace, self.dest)} and {value}")
        setattr(namespace, self.dest, value)


def add_output_option(
    parser: argparse.ArgumentParser, purpose: str, *, metavar: str = "FILE", required: bool = False
) -> None:
    """Add the output option."""
    parser.add_argument(
        "-o", "--output", type=Path, metavar=metavar, required=required, help=purpose, action=_Once
    )


def add_surface_argument(parser: argparse.ArgumentParser) -> None:
    """Add the file of a surface."""
    parser.add_argument("surface", type=Path, metavar="SURFACE", help=f"vertices and triangles ({READABLE})")


def add_metric_argument(parser: argparse.ArgumentParser) -> None:
    """Add the file of the lengths of a surface, which are those of its mesh by default."""
    parser.add_argument(
        "metric",
        type=Path,
        nargs="?",
        metavar="METRIC",
        help=f"the lengths, on the same triangles ({READABLE}; default: those of SURFACE)",
    )


def add_json_option(
    parser: argparse.ArgumentParser, purpose: str = "print one JSON object instead of text"
) -> None:
    """Add the option for JSON output."""
    parser.add_argument("--json", action="store_true", help=purpose)


def add_merge_option(parser: argparse.ArgumentParser) -> None:
    """Add the option that merges mesh vertices."""
    parser.add_argument(
        "--merge",
        type=_merge,
        nargs="?",
        const=MERGING.usual,
        metavar="TOLERANCE",
        help="merge vertices of a mesh within this distance, in mean edge lengths, and split sides at "
        f"vertices within it (T-junctions); 0 merges equal vertices only (default {MERGING.usual:g}, "
        "the rounding of single precision)",
    )


def converted(text: str, by: Callable[[str], T], wanted: str) -> T:
    """Value of an argument, for types of options.

    Raises
    ------
    ArgumentTypeError
        The conversion raises ValueError; the message says what is wanted.
    """
    try:
        return by(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is not {wanted}") from None


def _merge(text: str) -> float:
    value = converted(text, number, "a number (put files before --merge, not after it)")
    if not 0 <= value < 1:
        raise argparse.ArgumentTypeError(f"{text} is not a number of mean edge lengths in [0, 1)")
    return value


def add_space_option(parser: argparse.ArgumentParser, purpose: str) -> None:
    """Add the option for a space: a `Space`, or its name if no curvature is given."""
    parser.add_argument(
        "--space",
        type=_space,
        metavar="hyperbolic[=K]|spherical[=K]",
        help=f"{purpose}; K is negative in hyperbolic space, positive in spherical space",
    )


def _space(text: str) -> Space | str:
    name, equals, curvature = text.partition("=")
    if name not in ("hyperbolic", "spherical"):
        raise argparse.ArgumentTypeError(f"{text!r} is not hyperbolic[=K] or spherical[=K]")
    if not equals:
        return name
    space = converted(curvature, lambda k: Space(float(k)), "a finite number")
    if space.name != name:
        sign = "negative" if name == "hyperbolic" else "positive"
        meant = f": {name}={-space.curvature:g}" if space.curvature else ""
        raise argparse.ArgumentTypeError(
            f"{curvature} is not the curvature of {name} space, which is {sign}{meant}"
        )
    return space


def add_quiet_option(parser: argparse.ArgumentParser, **default: Any) -> None:
    """Add the option that silences the command."""
    parser.add_argument("--quiet", action="store_true", help="print nothing but notes and errors", **default)


def add_vertices_option(parser: argparse.ArgumentParser) -> None:
    """Add the option for the number of vertices in the mesh of a smooth surface."""
    parser.add_argument(
        "--vertices",
        type=int,
        metavar="N",
        help="number of vertices of the initial mesh of a smooth surface, and of the output mesh (default "
        f"{DEFAULT})",
    )


def add_marginal_options(parser: argparse.ArgumentParser, quantity: str, otherwise: str) -> None:
    """Add the options that decide whether a surface is a horizon."""
    decision = parser.add_mutually_exclusive_group()
    decision.add_argument(
        "--marginal", action="store_true", help=f"{quantity}: it is a horizon, k^2 = p^2 ({otherwise})"
    )
    decision.add_argument(
        "--not-marginal",
        action="store_true",
        help=f"{quantity}: it is not a horizon; k and p are taken as they are",
    )


def add_report_options(parser: argparse.ArgumentParser) -> None:
    """Add the options for additional horizon quantities in reports."""
    parser.add_argument(
        "--axis",
        type=float,
        nargs=3,
        metavar=("X", "Y", "Z"),
        help="additional axis for which to report the angular momentum",
    )
    parser.add_argument(
        "--wang-yau",
        action="store_true",
        help="add the Wang-Yau energy, minimized over time functions from tau = 0",
    )
    parser.add_argument(
        "--multipoles",
        type=int,
        metavar="L",
        help="add the multipoles (l, m) of horizons up to l = L, without assuming symmetry",
    )
    add_reference_option(parser)


def add_reference_option(parser: argparse.ArgumentParser) -> None:
    """Add the option for the reference space of energies."""
    add_space_option(
        parser,
        "the space to embed in, the reference of energies (default: R^3); without K, the least curved "
        "hyperbolic space known to embed a smooth metric",
    )


def reference(options: argparse.Namespace) -> Space | Literal["hyperbolic"]:
    """Reference space of energies, as accepted by `isoembed.relativity.embed_surface`.

    Raises
    ------
    UsageError
        The space is spherical without a curvature.
    """
    space: Space | str | None = options.space
    if space == "spherical":
        raise UsageError("--space spherical needs its curvature, as in --space spherical=0.1")
    return Euclidean() if space is None else space if isinstance(space, Space) else "hyperbolic"


def marginal(options: argparse.Namespace) -> bool | None:
    """Whether the surface is a horizon, if specified."""
    return True if options.marginal else False if options.not_marginal else None


def vertices(options: argparse.Namespace) -> int:
    """Number of vertices in the mesh of a smooth surface.

    Raises
    ------
    UsageError
        The number is too small.
    """
    from isoembed.meshing.surface_mesh import MIN_VERTICES  # needed for smooth surfaces only

    if options.vertices is not None and options.vertices < MIN_VERTICES:
        raise UsageError(f"--vertices must be at least {MIN_VERTICES}, not {options.vertices}")
    return DEFAULT if options.vertices is None else int(options.vertices)


def add_run_options(parser: argparse.ArgumentParser) -> None:
    """Add the options for parallel execution and reruns of tasks."""
    where = parser.add_mutually_exclusive_group()
    where.add_argument("--jobs", type=_count, metavar="N", help="number of processes (default: one per core)")
    where.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        help="use the workers of a running Dask cluster, tcp://HOST:PORT, instead of local processes",
    )
    parser.add_argument(
        "--shard",
        type=_shard,
        metavar="I/N",
        help="do the I-th of N parts, for array jobs of a batch system; all parts may share one folder",
    )
    parser.add_argument(
        "--chunk",
        type=_count,
        metavar="N",
        help="number of consecutive items per process, each started from the previous one (default: an "
        "eighth of all, at most 8)",
    )
    again = parser.add_mutually_exclusive_group()
    again.add_argument("--retry", action="store_true", help="retry the items that failed")
    again.add_argument("--force", action="store_true", help="redo all items, including those with results")


def given(options: argparse.Namespace, names: Collection[str]) -> dict[str, Any]:
    """Values of options by name, without those that are not given."""
    return {name: value for name in names if (value := getattr(options, name)) is not None}


def refuse_given(options: argparse.Namespace, names: tuple[str, ...], why: str) -> None:
    """Raise an error if any of the given options, which are incompatible with others, is present.

    Raises
    ------
    UsageError
        The message names the first such option.
    """
    for name, value in given(options, names).items():
        if value is not False:
            named = f"the input {options.input}" if name == "input" else f"--{name.replace('_', '-')}"
            raise UsageError(f"{named} {why}")


def _count(text: str) -> int:
    value = converted(text, int, "a whole number")
    if value < 1:
        raise argparse.ArgumentTypeError(f"{text} is less than 1")
    return value


def _shard(text: str) -> tuple[int, int]:
    found = re.fullmatch(r"(\d+)/(\d+)", text)
    if found is None or not 1 <= int(found[1]) <= int(found[2]):
        raise argparse.ArgumentTypeError(f"{text!r} is not I/N with I from 1 to N, such as 3/10")
    return int(found[1]), int(found[2])
